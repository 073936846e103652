"""Runs that are kept on a disk: what stops them, and how they go on."""

from __future__ import annotations

import os
import random
import re
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from frangible import CacheError, Recording
from frangible.bench import summary
from frangible.cli import main
from frangible.io.npz import Parts, write_arrays
from frangible.journal import Journal, read_journal
from frangible.kept_frames import steps_kept
from kill_and_resume import command, facts, killed

#: A run of half a second, which breaks after three frames.
RUN = ["run", "pane", "--frames", "25", "--quiet"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The cache of a run that nothing stopped."""
    path = tmp_path_factory.mktemp("whole") / "pane.npz"
    assert main([*RUN, "--out", str(path)]) == 0
    assert not os.path.exists(f"{path}.part")
    return path


def test_what_is_kept_on_a_disk_is_what_memory_holds(whole: Path) -> None:
    from frangible import run

    assert facts(Recording.load(whole)) == facts(run("pane", frames=25))


def test_a_killed_run_goes_on_to_the_same_bits(whole: Path, tmp_path: Path) -> None:
    """Killed three times at random."""
    path = tmp_path / "pane.npz"
    kills = sorted(random.Random(44).sample(range(1, 22), 3))
    for number, frames in enumerate(kills):
        kept = killed(path, frames, [*RUN, *(["--resume"] if number else [])])
        assert kept >= frames
        assert not path.exists()
        # What a run left can be looked at as it is.
        left = Recording.load(f"{path}.part")
        assert left.frames == kept
    assert main([*RUN, "--out", str(path), "--resume"]) == 0
    assert facts(Recording.load(path)) == facts(Recording.load(whole))
    assert not os.path.exists(f"{path}.part")


def test_ctrl_c_keeps_the_run_and_its_outputs(whole: Path, tmp_path: Path) -> None:
    path = tmp_path / "pane.npz"
    with subprocess.Popen(command(*RUN, "--out", str(path)), stderr=subprocess.PIPE) as run:
        while steps_kept(f"{path}.part") < 2:
            time.sleep(0.002)
        run.send_signal(signal.SIGINT)
        assert run.stderr is not None
        said = run.stderr.read().decode()
    assert run.returncode == 130
    assert re.fullmatch(r"frangible: stopped after \d+ of 25 frames; outputs are of those\n", said)
    assert Recording.load(path).frames == steps_kept(f"{path}.part") < 25
    assert main([*RUN, "--out", str(path), "--resume"]) == 0
    assert facts(Recording.load(path)) == facts(Recording.load(whole))


def test_a_full_disk_says_one_sentence_and_keeps_what_is_there(
    whole: Path, tmp_path: Path
) -> None:
    """The frames do not fit, or they do and the cache does not; with room again the run goes on."""
    path = tmp_path / "pane.npz"
    path.write_bytes(whole.read_bytes())
    before = path.read_bytes()
    for most in (300_000, 700_000):
        limited = subprocess.run(
            command(*RUN, "--out", str(path), "--resume"),
            capture_output=True,
            text=True,
            preexec_fn=lambda most=most: resource.setrlimit(  # type: ignore[misc]
                resource.RLIMIT_FSIZE, (most, most)
            ),
        )
        assert limited.returncode == 1, limited
        said = limited.stderr.splitlines()[-1]
        assert re.fullmatch(
            rf"frangible: {path}.part: File too large; it keeps \d+ frames, and --resume goes on",
            said,
        )
        assert path.read_bytes() == before
        assert sorted(os.listdir(tmp_path)) == ["pane.npz", "pane.npz.part"]
    assert main([*RUN, "--out", str(path), "--resume"]) == 0
    assert facts(Recording.load(path)) == facts(Recording.load(whole))


def test_what_cannot_go_on_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "stack.npz"
    run = ["run", "stack", "--frames", "8", "--quiet", "--out", str(path)]
    assert main(["run", "stack", "--resume"]) == 2
    assert "must come with the --out" in capsys.readouterr().err

    # Nothing is kept: it begins.
    assert main([*run, "--resume"]) == 0
    assert "keeps no run to go on with" in capsys.readouterr().err
    assert killed(path, 5, ["run", "stack", "--frames", "100000", "--quiet"]) >= 5
    assert main([*run, "--resume", "--set", "gravity=[0,-1,0]"]) == 2
    assert "keeps a run of another scene" in capsys.readouterr().err


def test_memory_does_not_grow_with_frames(tmp_path: Path) -> None:
    """Of 3,000 frames against 300, in a process of its own."""
    text = """
import sys
from frangible.cli import main
from frangible.recording import step_frames
import frangible.cli.run as command

def resident():
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmRSS"))

def watched(world, frames, *, on_step, **rest):
    def step(report, step_ms):
        on_step(report, step_ms)
        if report["frame"] in (300, 3000):
            print(resident(), file=sys.stderr)
    step_frames(world, frames, on_step=step, **rest)

command.step_frames = watched
main(["run", "stack", "--frames", "3000", "--quiet", "--out", sys.argv[1]])
"""
    ran = subprocess.run(
        [sys.executable, "-c", text, str(tmp_path / "stack.npz")], capture_output=True, text=True
    )
    early, late = (int(line) for line in ran.stderr.splitlines())
    assert late < 1.1 * early


def test_a_record_that_is_cut_off_or_damaged_ends_a_journal(tmp_path: Path) -> None:
    path = tmp_path / "frames"
    journal = Journal(str(path))
    ends = []
    for number in range(4):
        arrays = {"a": np.arange(number, dtype=np.float32), "b": np.ones((2, number), np.bool_)}
        journal.append("thing", {"number": number}, arrays)
        ends.append(journal.length)
    journal.close()
    read = list(read_journal(str(path)))
    assert [record.fields["number"] for record in read] == [0, 1, 2, 3]
    assert [record.end for record in read] == ends
    assert read[3].arrays["a"].tolist() == [0, 1, 2]
    assert read[3].arrays["b"].shape == (2, 3)

    whole = path.read_bytes()
    for length in range(0, len(whole), 7):
        path.write_bytes(whole[:length])
        assert len(list(read_journal(str(path)))) == sum(end <= length for end in ends)
    for place in range(0, len(whole), 5):
        damaged = bytearray(whole)
        damaged[place] ^= 1
        path.write_bytes(damaged)
        assert len(list(read_journal(str(path)))) == sum(end <= place for end in ends)


def test_arrays_in_parts_are_arrays(tmp_path: Path) -> None:
    parts = [np.arange(6.0).reshape(2, 3), np.zeros((0, 3)), np.ones((1, 3))]
    arrays = {"x": Parts(parts, (3,), np.float32), "n": np.array(5)}
    write_arrays(str(tmp_path / "a.npz"), {**arrays, "none": Parts([], (4,), np.int64)})
    with np.load(tmp_path / "a.npz") as read:
        assert np.array_equal(read["x"], np.concatenate(parts).astype(np.float32))
        assert read["x"].dtype == np.float32
        assert read["n"] == 5
        assert read["none"].shape == (0, 4)


@pytest.mark.parametrize("name", ["frames", ""])
def test_a_folder_that_is_none_of_ours_says_so(name: str, tmp_path: Path) -> None:
    if name:
        (tmp_path / name).write_bytes(b"no records")
    with pytest.raises(CacheError, match="must be a file or the .part folder"):
        Recording.load(tmp_path)


def test_percentiles_of_many_depths_are_within_a_thousandth(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    drawn = np.random.default_rng(44).exponential(1e-3, (50, 400))
    drawn[::7] = 0.0
    few, many = summary.Depths(), summary.Depths()
    for depths in drawn:
        few.add(depths)
    monkeypatch.setattr(summary, "_MOST_DEPTHS", 3000)
    for depths in drawn:
        many.add(depths)
    for percent in (50, 90, 99):
        expected = np.percentile(drawn, percent)
        assert few.percentile(percent) == expected
        assert many.percentile(percent) == pytest.approx(expected, rel=2e-3)
    assert few.percentile(100) == many.percentile(100) == drawn.max()
    assert summary.Depths().percentile(50) == 0.0
