"""The command line, end to end with the real engine."""

import json
import os
import shutil
import re
import signal
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
from frangible import Recording, __version__, shot_defaults, shots
from frangible.cli import main
from frangible.cli.shot_groups import GROUPS, OTHERS


def frangible(*arguments: object, **options: Any) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "frangible", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, **options)


def test_shots_are_listed_with_a_line_each(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["shots"]) == 0
    groups = capsys.readouterr().out.strip().split("\n\n")
    titles = [group.splitlines()[0] for group in groups]
    assert len(titles) > 3 and all(title.endswith(":") for title in titles)
    assert f"{OTHERS}:" not in titles, "a shot is in no group of shot_groups.py"
    found = [line.split()[0] for group in groups for line in group.splitlines()[1:]]
    assert sorted(found) == sorted(name for name, _ in shots())
    assert len(found) == sum(len(names.split()) for _, names in GROUPS)


def test_a_run_ends_with_one_line_of_json(tmp_path: Path) -> None:
    run = frangible(
        "run", "wall", "--frames", 12, "--json", "--out", tmp_path / "wall.npz", "--threads", 1
    )
    assert run.returncode == 0
    summary = json.loads(run.stdout.splitlines()[-1])
    shapes = {
        "bodies": {"start", "end", "quarantined"},
        "mass_kg": {"start", "end"},
        "energy_J": {
            *("start", "end", "work", "started", "max_frame_gain", "scale", "dissipated", "banked")
        },
        "momentum": {"linear_error", "angular_error"},
        "penetration_m": {"p50", "p99", "max"},
        "ms_per_frame": {"mean", "median", "p95", "max"},
    }
    for key, fields in shapes.items():
        assert set(summary[key]) == fields
    assert summary["shot"] == "wall"
    assert summary["method"] == shot_defaults()["method"]
    assert summary["frames"] == 12
    assert summary["dt"] == pytest.approx(1 / 30)
    assert summary["fractures"] == 1
    assert int(summary["state_hash"], 16) >= 0
    assert summary["peak_memory_MiB"] > 1
    assert all(milliseconds >= 0 for milliseconds in summary["stages_ms"].values())

    # A wall keeps its mass when it breaks, and the books balance.
    assert summary["mass_kg"]["end"] == pytest.approx(summary["mass_kg"]["start"], rel=1e-12)
    assert summary["bodies"]["end"] > summary["bodies"]["start"] == 3
    energy = summary["energy_J"]
    end = energy["start"] + energy["work"] - energy["dissipated"] - energy["banked"]
    assert end == pytest.approx(energy["end"], abs=1e-9 * energy["scale"])
    assert energy["max_frame_gain"] <= 1e-9 * energy["scale"]
    assert Recording.load(tmp_path / "wall.npz").frames == 12


def test_a_run_tells_people_what_happened_and_writes_every_format(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    outputs = [tmp_path / f"wall.{ending}" for ending in ("usda", "usdc", "glb", "npz", "png")]
    arguments = [argument for path in outputs for argument in ("--out", str(path))]
    assert main(["run", "wall", "--frames", "3", "--frame", "2", *arguments]) == 0
    captured = capsys.readouterr()
    assert (
        captured.out.splitlines()[1]
        == "nothing broke; no energy dissipated; no frame gained energy"
    )
    for path in outputs:
        assert path.stat().st_size > 0
        assert str(path) in captured.err
    shapes = ["wall.geometry.usda", "wall.geometry.usdc"]
    assert sorted(os.listdir(tmp_path)) == sorted([*shapes, *(path.name for path in outputs)])


def test_what_happened_is_said_in_a_few_words(
    capsys: pytest.CaptureFixture[str], wall: Recording
) -> None:
    assert main(["run", "wall", "--frames", "60", "--quiet"]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    lines = captured.out.splitlines()
    assert len(lines) <= 4
    pieces = sum(body.parent is not None for body in wall.alive(60))
    (when,) = [report["time"] for report in wall.reports if report["fractures"]]
    assert lines[0].startswith("wall: 2 s in 60 frames, simulated in ")
    assert re.fullmatch(
        rf"{pieces} pieces after {when:.2f} s; [\d.]+ % of the energy dissipated; no frame gained "
        rf"energy",
        lines[1],
    )


def test_the_bare_command_and_its_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    assert capsys.readouterr().out.startswith("usage: frangible")
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"frangible {__version__}\n"


@pytest.mark.parametrize(
    "arguments", [["shots"], ["info", "tetrahedron.obj"], ["pattern", "slices"]]
)
def test_lists_are_also_objects_of_json(
    arguments: list[str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    tetrahedron: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (tmp_path / "tetrahedron.obj").write_text(tetrahedron)
    monkeypatch.chdir(tmp_path)
    assert main([*arguments, "--json"]) == 0
    assert isinstance(json.loads(capsys.readouterr().out), dict)


def test_folders_of_outputs_are_made_and_one_failure_leaves_the_others(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("frangible.io.cache.write_npz", fail)
    bad, good = tmp_path / "bad.npz", tmp_path / "new" / "deep" / "good.glb"
    assert main(["run", "wall", "--frames", "2", "--out", str(bad), "--out", str(good)]) == 1
    captured = capsys.readouterr()
    assert f"frangible: {bad}: No space left on device" in captured.err.splitlines()
    assert "nothing broke" in captured.out
    assert good.stat().st_size > 0
    assert not bad.exists()


def test_in_a_pipe_progress_is_a_line_for_every_tenth() -> None:
    run = frangible("run", "wall", "--frames", 30)
    lines = [line for line in run.stderr.splitlines() if line.startswith("frame ")]
    assert [line.split(",")[0] for line in lines] == [f"frame {3 * i}/30" for i in range(1, 11)]
    assert "\r" not in run.stderr
    assert "\x1b" not in run.stderr


def test_on_a_terminal_progress_is_a_bar() -> None:
    leader, follower = os.openpty()
    command = [sys.executable, "-m", "frangible", "run", "wall", "--frames", "20"]
    process = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=follower, env={**os.environ, "TERM": "xterm"}
    )
    os.close(follower)
    shown = b""
    try:
        while piece := os.read(leader, 4096):
            shown += piece
    except OSError:
        # Linux ends a terminal that nobody writes to any more with an error.
        pass
    os.close(leader)
    assert process.wait(timeout=60) == 0
    assert b"bodies" in shown
    assert b"s left" not in shown


def test_threads_and_repetition_do_not_change_the_state() -> None:
    runs = [
        frangible("run", "wall", "--frames", 40, "--json", "--threads", threads)
        for threads in (1, 2, 2)
    ]
    hashes = {json.loads(run.stdout)["state_hash"] for run in runs}
    assert len(hashes) == 1


@pytest.mark.parametrize("ending", ["npz", "usdc", "glb"])
def test_info_describes_our_caches(
    ending: str, wall: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"wall.{ending}"
    wall.save(path)
    assert main(["info", str(path)]) == 0
    facts = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert facts["frames"] == "60"
    assert float(facts["fps"]) == 30.0
    assert str(len(wall.bodies)) in facts["bodies"]


def test_info_describes_a_mesh(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], tetrahedron: str
) -> None:
    path = tmp_path / "tetrahedron.obj"
    path.write_text(tetrahedron)
    assert main(["info", str(path)]) == 0
    facts = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert facts["triangles"] == "4"
    # Corners at the origin and at one metre along each axis, at unit density: the textbook's
    # moments.
    assert float(facts["volume_m3"]) == pytest.approx(1 / 6, rel=1e-5)
    assert [float(word) for word in facts["center_m"].split()] == pytest.approx([0.25] * 3)
    rows = [[float(word) for word in row.split()] for row in facts["unit_inertia_m5"].split(";")]
    assert rows == [
        pytest.approx([1 / 80 if i == j else 1 / 480 for j in range(3)], rel=1e-5) for i in range(3)
    ]


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_what_was_simulated_before_a_signal_is_kept(
    number: int, status: int, tmp_path: Path
) -> None:
    command = [
        sys.executable,
        "-m",
        "frangible",
        "run",
        "wall",
        "--frames",
        "1000",
        "--out",
        tmp_path / "wall.npz",
        "--json",
    ]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    assert process.stderr.readline().startswith("frame 100/1000")
    process.send_signal(number)
    out, errors = process.communicate(timeout=30)
    assert process.returncode == status
    frames = json.loads(out)["frames"]
    assert 100 <= frames < 1000
    assert (
        f"frangible: stopped after {frames} of 1000 frames; outputs are of those"
        in errors.splitlines()
    )
    assert "Traceback" not in errors
    # The folder is for --resume.
    assert sorted(os.listdir(tmp_path)) == ["wall.npz", "wall.npz.part"]
    assert Recording.load(tmp_path / "wall.npz").frames == frames


def test_a_folder_that_goes_away_during_the_run_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()

    def replace(*_: object) -> Any:
        shutil.rmtree(folder)
        folder.write_text("a file")
        return nullcontext()

    monkeypatch.setattr("frangible.cli.run.report_progress", replace)
    assert main(["run", "wall", "--frames", "1", "--out", str(folder / "wall.glb")]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert str(folder) in line
    assert "File exists" in line or "Not a directory" in line


def test_a_reader_that_has_seen_enough_is_no_error() -> None:
    shell = f"'{sys.executable}' -m frangible shots | true"
    run = subprocess.run(["bash", "-c", shell], capture_output=True, text=True, timeout=60)
    assert run.stderr == ""
