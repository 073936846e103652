"""Meshes as they come, from `info` to pieces: open floors, repeated and turned faces, parts that touch."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from frangible import BuildError, Pattern, break_mesh
from frangible.mesh_facts import describe_mesh

CORNERS = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
QUADS = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
FLOOR = ([(-1, -1, -1), (2, -1, -1), (2, -1, 2), (-1, -1, 2)], [[0, 3, 2, 1]])
Part = tuple[list[tuple[float, ...]], list[list[int]]]


def box(x: float = 0.0) -> Part:
    return [(a + x, b, c) for a, b, c in CORNERS], QUADS


def turned(quads: list[list[int]]) -> list[list[int]]:
    return [quad[::-1] for quad in quads]


def written(folder: Path, parts: list[Part]) -> str:
    lines: list[str] = []
    count = 1
    for corners, faces in parts:
        lines += [f"v {x} {y} {z}" for x, y, z in corners]
        lines += ["f " + " ".join(str(corner + count) for corner in face) for face in faces]
        count += len(corners)
    path = folder / "raw.obj"
    path.write_text("\n".join(lines))
    return str(path)


MESHES: dict[str, tuple[list[Part], float]] = {
    "floor": ([box(), FLOOR], 1.0),
    "floor first": ([FLOOR, box()], 1.0),
    "one face turned": ([(CORNERS, [*QUADS[:5], QUADS[5][::-1]])], 1.0),
    "double-sided": ([(CORNERS, QUADS + turned(QUADS))], 1.0),
    "repeated, open": ([(CORNERS, [quad for quad in QUADS[:5] for _ in range(20)])], 1.0),
    "touching": ([box(), box(1.0)], 2.0),
    "in one plane": ([box(), box(0.25)], 1.25),
    "turned parts": ([(box()[0], turned(QUADS)), box(3.0)], 2.0),
    "open": ([(CORNERS, QUADS[:5])], 1.0),
    "far away": ([(box(1e3)[0], QUADS[:5])], 1.0),
}


@pytest.mark.parametrize("name", MESHES)
def test_info_and_pieces_have_the_volume_of_the_solids(name: str, tmp_path: Path) -> None:
    parts, volume = MESHES[name]
    path = written(tmp_path, parts)
    pattern = Pattern.named("voronoi", cells=6, seed=2)
    pieces = break_mesh(path, pattern, exact=True)
    assert pieces.volume == pytest.approx(volume, rel=1e-9)
    assert describe_mesh(path)["volume_m3"] == pytest.approx(pieces.volume, rel=1e-12)
    assert not any("grid" in note for note in pieces.notes)
    on_grid = break_mesh(path, pattern, voxels=16)
    assert on_grid.volume == pytest.approx(volume, rel=0.02)


def test_a_sheet_alone_is_refused_and_described(tmp_path: Path) -> None:
    path = written(tmp_path, [FLOOR])
    with pytest.raises(BuildError, match="encloses no volume"):
        break_mesh(path, Pattern.named("voronoi", cells=6))
    facts = describe_mesh(path)
    assert facts["volume_m3"] == 0.0
    assert "encloses no volume" in str(facts["surface"])


def test_a_floor_that_is_left_out_is_named(tmp_path: Path) -> None:
    pieces = break_mesh(written(tmp_path, [box(), FLOOR]), Pattern.named("voronoi", cells=6), exact=True)
    (note,) = pieces.notes
    assert note == "1 open part that encloses nothing left out: 2 triangles from (-1, -1, -1) to (2, -1, 2)"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_long_work_says_what_it_does_and_stops_when_asked(number: signal.Signals, tmp_path: Path) -> None:
    path = written(tmp_path, [box()])
    command = [sys.executable, "-m", "frangible", "break", path, "--pattern", "voronoi", "--grid", "--voxels", "500"]
    process = subprocess.Popen(
        [*command, "--out", str(tmp_path / "pieces.glb")], stderr=subprocess.PIPE, text=True
    )
    assert process.stderr is not None
    assert "grid of 500 voxels" in process.stderr.readline()
    process.send_signal(number)
    begin = time.monotonic()
    assert process.wait(timeout=60) == 128 + number
    assert time.monotonic() - begin < 10.0
    assert not list(tmp_path.glob("*pieces*"))
