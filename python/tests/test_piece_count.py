"""As many pieces as are asked for, and none that is a crumb or falls apart."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from frangible import _frangible
from frangible.breaking.break_mesh import break_mesh
from frangible.breaking.piece_count import difference
from frangible.cli import main

KINDS = [name for name, _ in _frangible.patterns()]

#: A box of 4 x 2 x 3 m as an OBJ file.
BOX = """v -2 -1 -1.5\nv 2 -1 -1.5\nv -2 1 -1.5\nv 2 1 -1.5
v -2 -1 1.5\nv 2 -1 1.5\nv -2 1 1.5\nv 2 1 1.5
f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"""


@pytest.fixture
def box(tmp_path: Path) -> Path:
    path = tmp_path / "box.obj"
    path.write_text(BOX)
    return path


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("pieces", [8, 30])
def test_break_makes_the_pieces(box: Path, kind: str, pieces: int) -> None:
    broken = break_mesh(
        box, _frangible.Pattern.named(kind), normal=(0, 0, 1), exact=True, pieces=pieces
    )
    assert abs(len(broken.pieces) - pieces) <= 0.1 * pieces
    assert not any("asked for" in note for note in broken.notes)


def test_the_same_pieces_again_and_on_a_grid(box: Path) -> None:
    pattern = _frangible.Pattern.named("voronoi", seed=7)
    first, second = (break_mesh(box, pattern, exact=True, pieces=20) for _ in range(2))
    assert all(
        np.array_equal(a.vertices, b.vertices)
        for a, b in zip(first.pieces, second.pieces, strict=True)
    )
    assert abs(len(break_mesh(box, pattern, voxels=48, pieces=20).pieces) - 20) <= 2


def test_a_saved_pattern_is_laid_on_larger(box: Path, tmp_path: Path) -> None:
    saved = tmp_path / "rubble.json"
    _frangible.Pattern.named("natural", cells=200).save(str(saved))
    pattern = _frangible.Pattern.named(str(saved))
    assert abs(len(break_mesh(box, pattern, exact=True, pieces=12).pieces) - 12) <= 1
    # It has no more than it has, and says so.
    coarse = break_mesh(box, pattern, exact=True, pieces=900)
    assert (
        coarse.notes[-1]
        == f"900 pieces were asked for, and {len(coarse.pieces)} is as near as this pattern comes"
    )


@pytest.mark.parametrize("smallest", [0.0, 0.1, 0.5])
def test_small_pieces_join_a_neighbour(box: Path, smallest: float) -> None:
    pattern = _frangible.Pattern.named("natural", cells=60)
    broken = break_mesh(box, pattern, exact=True, smallest=smallest)
    volumes = [piece.volume for piece in broken.pieces]
    assert min(volumes) >= smallest * np.mean(volumes)
    assert sum(volumes) == pytest.approx(24.0, rel=1e-9)
    assert broken.volume_defect < 1e-9
    all_of_them = break_mesh(box, pattern, exact=True, smallest=0.0)
    assert (len(broken.pieces) < len(all_of_them.pieces)) == (smallest > 0.0)


def test_the_command_says_what_does_not_fit(
    box: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = str(tmp_path / "pieces.glb")
    assert (
        main(
            [
                "break",
                str(box),
                "--pattern",
                "voronoi",
                "--pieces",
                "5",
                "--cells",
                "5",
                "--out",
                out,
            ]
        )
        == 2
    )
    assert (
        capsys.readouterr().err
        == "frangible: --pieces: 5, must come without --cells, which follow from it\n"
    )
    assert main(["run", "stack", "--pieces", "5"]) == 2
    assert (
        capsys.readouterr().err
        == "frangible: pieces: 5, must come with a scene in which a body has 'breaking'\n"
    )


def test_patterns_have_the_cells() -> None:
    for kind in KINDS:
        for pieces in (7, 20, 133):
            _, count = _frangible.Pattern.named(kind).with_pieces(pieces)
            # Splinters come in twos, bricks with their joints in threes.
            assert difference(count, pieces) is None or abs(count - pieces) <= {
                "splinters": 1,
                "bricks": 4,
            }.get(kind, 0)


def test_a_scene_asks_for_pieces() -> None:
    for pieces in (6, 25):
        wall = {
            "name": "wall",
            "shape": {"kind": "box", "size": [3.0, 2.0, 0.3]},
            "position": [0.0, 1.0, 0.0],
            "breaking": {"strength": 10.0, "pattern": {"kind": "voronoi"}, "pieces": pieces},
        }
        ball = {
            "name": "ball",
            "shape": {"kind": "sphere", "radius": 0.2},
            "position": [0.9, 1.4, 1.0],
            "linear_velocity": [0.0, 0.0, -20.0],
        }
        world = _frangible.World.build(json.dumps({"bodies": [wall, ball]}))
        for _ in range(10):
            if fractures := world.step()["fractures"]:
                break
        assert fractures[0]["wanted"] == pieces
        assert abs(len(fractures[0]["fragments"]) - pieces) <= 0.1 * pieces
    wall["breaking"]["pieces"] = 1
    with pytest.raises(
        _frangible.BuildError, match=r"bodies\[0\]\.breaking\.pieces: 1, must be from 2 to 10000"
    ):
        _frangible.World.build(json.dumps({"bodies": [wall]}))
