"""Meshes as they come, from `info` to pieces: open floors, repeated and turned faces, parts that
touch."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from frangible import BuildError, Pattern, World, _frangible, break_mesh
from frangible.breaking.mesh_facts import describe_mesh

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
    with pytest.raises(BuildError, match="encloses no volume.*--thickness"):
        break_mesh(path, Pattern.named("voronoi", cells=6))
    facts = describe_mesh(path)
    assert facts["volume_m3"] == 0.0
    assert "encloses no volume" in str(facts["surface"])


def area(path: str) -> float:
    vertices, triangles = _frangible.load_mesh(path)
    corners = vertices[triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * float(np.linalg.norm(across, axis=1).sum())


@pytest.mark.parametrize(("thickness", "exact"), [(0.01, True), (0.4, True), (0.4, False)])
def test_sheets_with_a_thickness_are_plates(thickness: float, exact: bool, tmp_path: Path) -> None:
    second = [(x + 4.0, y + 1.0, z) for x, y, z in FLOOR[0]]
    for parts in ([FLOOR], [FLOOR, (second, FLOOR[1])], [FLOOR, box()]):
        path = written(tmp_path, parts)
        expected = (
            1.0 + 9.0 * thickness
            if len(parts[1:]) and parts[1] == box()
            else thickness * area(path)
        )
        pieces = break_mesh(
            path,
            Pattern.named("voronoi", cells=6, seed=2),
            thickness=thickness,
            exact=exact,
            voxels=32,
        )
        assert pieces.volume == pytest.approx(expected, rel=1e-9)
        written_volume = sum(piece.volume for piece in pieces.pieces)
        assert len(pieces.pieces) > 1
        if exact:
            assert written_volume == pytest.approx(expected, rel=1e-9)
        assert any(f"{thickness:g} m thick" in note for note in pieces.notes), pieces.notes


def test_a_thickness_without_a_sheet_is_told(tmp_path: Path) -> None:
    path = written(tmp_path, [box()])
    pieces = break_mesh(path, Pattern.named("voronoi", cells=4), thickness=0.1)
    assert pieces.volume == pytest.approx(1.0)
    assert "no open part" in pieces.notes[0]
    with pytest.raises(BuildError, match="thickness -1 m, must be above 0"):
        break_mesh(path, Pattern.named("voronoi", cells=4), thickness=-1.0)


def test_sheets_break_in_scenes(tmp_path: Path) -> None:
    path = written(tmp_path, [FLOOR])
    shape = {"kind": "mesh", "path": path, "thickness": 0.5, "resolution": {"voxels": [24, 4, 24]}}
    body = {"shape": shape, "density": 2.0}
    assert World.build({"bodies": [body]}).masses[0] == pytest.approx(9.0, rel=1e-3)
    shape["scale"] = 2.0
    assert World.build({"bodies": [body]}).masses[0] == pytest.approx(36.0, rel=1e-3)
    vertices = [list(corner) for corner in FLOOR[0]]
    shape = {
        "kind": "triangles",
        "positions": vertices,
        "triangles": [[0, 3, 2], [0, 2, 1]],
        "thickness": 0.5,
    }
    assert World.build({"bodies": [{"shape": shape, "density": 2.0}]}).masses[0] == pytest.approx(
        9.0, rel=0.02
    )
    for wrong in (0.0, -1.0):
        with pytest.raises(BuildError, match="thickness"):
            World.build({"bodies": [{"shape": {**shape, "thickness": wrong}}]})


def test_a_floor_that_is_left_out_is_named(tmp_path: Path) -> None:
    pieces = break_mesh(
        written(tmp_path, [box(), FLOOR]), Pattern.named("voronoi", cells=6), exact=True
    )
    (note,) = pieces.notes
    assert (
        note
        == "1 open part that encloses nothing left out: 2 triangles from (-1, -1, -1) to (2, -1, 2)"
    )


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_long_work_says_what_it_does_and_stops_when_asked(
    number: signal.Signals, tmp_path: Path
) -> None:
    path = written(tmp_path, [box()])
    command = [
        sys.executable,
        "-m",
        "frangible",
        "break",
        path,
        "--pattern",
        "voronoi",
        "--grid",
        "--voxels",
        "500",
    ]
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
