"""Benchmarks, on what is small."""

import csv
import io
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from frangible import World, shot_frames, shot_scene
from frangible.bench import peers, pile_file
from frangible.bench.pile_file import Pile, load_states
from frangible.bench.run_process import LAST_FRAMES, STATE, Request, run_apart, run_here
from frangible.bench.stage_times import COLUMNS, SHOTS, append_rows, describe_bench, shots_to_bench
from frangible.bench.standing import Standing
from frangible.cli import main


def test_a_benchmark_ends_with_what_a_run_says_and_times_by_stage(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    frames = LAST_FRAMES + 40
    arguments = ["stack", "--frames", str(frames), "--threads", "1", "--json"]
    assert main(["bench", *arguments, "--out", str(tmp_path)]) == 0
    measured = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert main(["run", *arguments]) == 0
    run = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert set(run) < set(measured)
    for key in (
        "shot",
        "method",
        "frames",
        "dt",
        "state_hash",
        "bodies",
        "mass_kg",
        "energy_J",
        "momentum",
    ):
        assert measured[key] == run[key]

    # The last frames are without the first, and the stages are parts of the frame.
    assert (
        set(measured["ms_per_frame"])
        == set(measured["ms_per_frame_all"])
        == set(run["ms_per_frame"])
    )
    assert measured["ms_per_frame"]["max"] <= measured["ms_per_frame_all"]["max"]
    assert measured["ms_per_frame"]["mean"] != measured["ms_per_frame_all"]["mean"]
    assert (
        set(measured["stages_last_ms"]) == set(measured["stages_all_ms"]) == set(run["stages_ms"])
    )
    assert (
        0
        < sum(stage["mean"] for stage in measured["stages_all_ms"].values())
        <= measured["ms_per_frame_all"]["mean"]
    )
    assert 0 < measured["cpu_ms_per_frame"]["mean"]
    assert measured["memory_per_piece_KiB"] > 0

    # A row for each stage and one for the frame.
    with open(tmp_path / "stages.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == COLUMNS
    assert [row["stage"] for row in rows] == [*measured["stages_last_ms"], "frame"]
    assert float(rows[-1]["last_median_ms"]) == pytest.approx(
        measured["ms_per_frame"]["median"], abs=5e-4
    )


def test_the_table_of_a_benchmark_names_stages_and_memory(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bench", "stack", "--frames", "3", "--out", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert (
        lines[0].startswith("stack: ")
        and "3 frames of 33.33 ms (frame-rate method), 1 thread" in lines[0]
    )
    assert "last 3 frames" in lines[1]
    assert [word for word in lines[-3].split()][0] == "frame" and len(lines[-3].split()) == 7
    assert lines[-2].split()[:2] == ["stands", "83.3"] and lines[-2].endswith(" m")
    assert lines[-1].split()[0] == "memory" and lines[-1].endswith("KiB a piece")


def test_each_number_of_threads_is_measured_and_ends_in_the_same_state(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert (
        main(
            [
                "bench",
                "bricks",
                "--frames",
                "4",
                "--threads",
                "1,2",
                "--json",
                "--out",
                str(tmp_path),
            ]
        )
        == 0
    )
    runs = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [run["threads"] for run in runs] == [1, 2]
    # The ball has come to the wall, and more than half of it is where it was.
    assert 0.5 < runs[0]["standing"] < 1.0
    assert runs[0]["median_height_m"] == pytest.approx(12.5 * 0.065, abs=0.01)
    assert runs[0]["state_hash"] == runs[1]["state_hash"]


def test_all_are_those_that_need_no_mesh() -> None:
    shots = shots_to_bench("all")
    assert "stack" in shots and "pile-table" in shots
    assert "bunny" not in shots


def test_what_cannot_be_measured_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for arguments, sentence in (
        (["wall-e"], "unknown shot 'wall-e'"),
        (["impact"], "needs a mesh file"),
        (["wall", "--peers"], "wall: body 'wall', must be a hull, a box or a sphere"),
        (["slab", "--peers"], "--peers: bench/peers, must be here"),
    ):
        assert main(["bench", *arguments, "--frames", "2"]) == 2
        assert sentence in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(scope="module")
def slab() -> Pile:
    return Pile.of_shot("slab")


@pytest.mark.parametrize("shot", ["slab", "bricks"])
def test_the_file_of_a_pile_holds_what_the_world_holds(shot: str) -> None:
    pile = Pile.of_shot(shot)
    file = io.BytesIO()
    pile.write(file)
    data = file.getvalue()
    assert data.startswith(b"FRANPILE")
    assert int.from_bytes(data[8:12], "little") == len(pile.start)
    numbers = np.frombuffer(data[12:44], "<f8")
    assert numbers.tolist() == pytest.approx([1 / 30, 0.0, -9.81, 0.0])

    # Body by body, to the end of the file.
    at = 44
    scene = json.loads(shot_scene(shot))
    world = World.build(json.dumps(scene))
    smallest = [min(body[key] for body in scene["bodies"]) for key in ("friction", "restitution")]
    for row, (mass, body) in enumerate(zip(world.masses.tolist(), scene["bodies"], strict=True)):
        kind, corners, at = read_shape(data, at)
        rest = np.frombuffer(data, "<f8", STATE + 6, at)
        at += 8 * (STATE + 6)
        assert rest[STATE] == mass
        assert rest[-2:].tolist() == (
            smallest if math.isinf(mass) else [body["friction"], body["restitution"]]
        )
        if math.isinf(mass):
            assert kind == 1 and corners[:, 1].max() + rest[1] == 0.0
            continue
        assert kind == {"hull": 0, "box": 1, "sphere": 2}[body["shape"]["kind"]]
        assert rest[:3] == pytest.approx(world.positions[row])
        # A body's moments are about its centre: for a solid, less than its mass times the square of
        # how far its corners are.
        farthest = np.linalg.norm(corners, axis=1).max()
        assert pile.radii[row] == pytest.approx(farthest)
        assert (
            0 < rest[STATE + 1 : STATE + 4].min()
            and rest[STATE + 1 : STATE + 4].max() < mass * farthest**2
        )
        if kind == 1:
            wanted = mass / 3.0 * (np.sum(corners[-1] ** 2) - corners[-1] ** 2)
            assert rest[STATE + 1 : STATE + 4] == pytest.approx(wanted, rel=1e-6)
            assert 2.0 * corners[-1] == pytest.approx(np.array(body["shape"]["size"]), rel=1e-6)
    assert at == len(data)


def read_shape(data: bytes, at: int) -> tuple[int, Any, int]:
    """A shape's kind, points (n, 3) that reach as far as it does, a box's farthest last, and where
    it ends."""
    kind = int.from_bytes(data[at : at + 4], "little")
    if kind == 0:
        count = int.from_bytes(data[at + 4 : at + 8], "little")
        return (
            kind,
            np.frombuffer(data, "<f8", 3 * count, at + 8).reshape(-1, 3),
            at + 8 + 24 * count,
        )
    if kind == 1:
        half = np.frombuffer(data, "<f8", 3, at + 4)
        return kind, np.stack([-half, half]), at + 28
    radius = float(np.frombuffer(data, "<f8", 1, at + 4)[0])
    return kind, radius * np.eye(3), at + 12


def test_the_piles_of_the_comparison_are_piles_for_other_engines() -> None:
    piles = {"pile-spread", "pile-deep", "pile-table", "bricks", "bricks-still"}
    assert set(peers.PILES) == piles <= set(SHOTS)
    for shot in peers.PILES:
        for body in json.loads(shot_scene(shot))["bodies"]:
            pile_file.check(shot, body)


def test_energies_and_overlaps_from_a_file_of_states_are_the_worlds(
    slab: Pile, tmp_path: Path
) -> None:
    path = tmp_path / "states"
    summary = run_here(Request("slab", 5, 1, str(path)))
    states = load_states(str(path), slab)
    assert states.shape == (5, len(slab.start), STATE)
    assert slab.energies(states)[-1] == pytest.approx(summary["energy_J"]["end"], rel=1e-5)
    assert np.percentile(slab.penetrations(states[-1]), 99) == pytest.approx(
        summary["penetration_m"]["p99"], abs=1e-6
    )


def test_gains_and_losses_are_seen(slab: Pile) -> None:
    still = np.repeat(slab.start[None], 3, axis=0)
    quality = peers.judge(slab, still)
    assert quality.energy_gain == 0.0 and quality.lost == 0 and quality.penetration[2] < 1e-6

    # One is pushed a millimetre up, one falls through the ground, one is nowhere: mass and height
    # say what that is worth.
    wrong = still.copy()
    wrong[1:, 3, 1] += 1e-3
    energies = slab.energies(still)
    assert peers.judge(slab, wrong).energy_gain == pytest.approx(
        slab.masses[3] * 9.81 * 1e-3 / energies[0], rel=1e-6
    )
    # What sank into the ground by less than its own size is not lost.
    wrong[2, 7, 1] = -0.5 * slab.radii[7]
    assert peers.judge(slab, wrong).lost == 0
    wrong[2, 5, 1] = -1.0
    wrong[2, 6, 0] = np.nan
    assert peers.judge(slab, wrong).lost == 2


def test_what_fell_does_not_stand(slab: Pile) -> None:
    still = np.repeat(slab.start[None], 2, axis=0)
    whole = peers.judge(slab, still).stands
    assert whole.share == 1.0 and whole.median_height == pytest.approx(0.1, abs=0.01)

    # Less than half a width stands, more does not, and what is gone neither stands nor counts.
    pieces = int(slab.moves.sum())
    fallen = still.copy()
    fallen[1, 3, 1] -= 0.4 * slab.widths[3]
    fallen[1, 4, 1] -= 0.6 * slab.widths[4]
    fallen[1, 5, :3] = np.nan
    stands = peers.judge(slab, fallen).stands
    assert stands.share == pytest.approx(1 - 2 / pieces) and np.isfinite(stands.median_height)


def test_what_cannot_be_built_is_left_out_with_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    package = tmp_path / "broken"
    package.mkdir()
    (package / "Cargo.toml").write_text("[package]\n")
    assert peers.build(package) == []
    assert "broken: left out, because " in capsys.readouterr().err


def test_what_an_engine_complains_of_is_no_part_of_its_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program = tmp_path / "peer-loud"
    program.write_text(
        "#!/bin/sh\necho no room for contacts\n"
        "printf '1.0\\n3.0\\n' > \"$3\"\necho loud 1.0\necho 512\n"
    )
    program.chmod(0o755)
    name, times, memory = peers.run_peer(program, "pile", 2, str(tmp_path / "states"))
    assert name == "loud 1.0" and times["median"] == 2.0 and memory == 512.0
    assert "loud 1.0: no room for contacts" in capsys.readouterr().err


def test_an_engine_takes_substeps_and_steps_if_they_are_given(tmp_path: Path) -> None:
    program = tmp_path / "peer-obedient"
    program.write_text(
        '#!/bin/sh\nshift 4\necho 1.0 > "'
        + str(tmp_path / "states.times")
        + '"\necho "obedient: $*"\necho 0\n'
    )
    program.chmod(0o755)
    for effort, said in (((), "obedient: "), ((8,), "obedient: 8"), ((4, 2), "obedient: 4 2")):
        assert peers.run_peer(program, "pile", 1, str(tmp_path / "states"), effort)[0] == said


def test_every_engine_in_the_repository_is_found_and_told_of() -> None:
    root = Path(__file__).parents[2]
    names = [package.name for package in peers.packages(root / peers.PROGRAMS)]
    assert names == ["box3d", "jolt", "physx", "rapier"]
    table = (root / "docs" / "performance.md").read_text(encoding="utf-8")
    assert all(f"`bench/peers/{name}`" in table for name in names)


def test_the_table_of_engines_is_in_units_of_ours() -> None:
    quality = peers.Quality((0.0011, 0.02, 0.3), 0.0015, 2, Standing(0.5, 0.75))
    results = [
        peers.Result(name, {"median": time, "p95": time, "max": time}, 3.25, quality)
        for name, time in (("frangible", 20.0), ("other 1.0", 50.0))
    ]
    rows = peers.result_rows("pile", 150, 3, results)
    assert [row["time_ratio"] for row in rows] == [1.0, 2.5]
    lines = peers.describe_peers(rows).splitlines()
    assert (
        lines[0] == "pile: the last 150 of 150 frames, 3 runs by turns on one core, processor time"
    )
    assert lines[3].split() == [
        "other",
        "1.0",
        "50.0",
        "50.0",
        "50.0",
        "2.5",
        "1.1",
        "20.0",
        "300.0",
        "0.0015",
        "2",
        "3.25",
        "0.5",
        "0.75",
    ]
    assert len({len(line) for line in lines[1:]}) == 1


def test_rows_are_appended_below_one_head(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    for number in (1, 2):
        append_rows(str(path), ["number"], [{"number": number}])
    assert path.read_text().split() == ["number", "1", "2"]


def test_a_process_of_its_own_says_the_same(slab: Pile) -> None:
    request = Request("stack", 2, 1)
    apart, here = run_apart(request), run_here(request)
    assert apart["state_hash"] == here["state_hash"]
    assert shot_frames("stack") > 2 and "stack: " in describe_bench(apart)
