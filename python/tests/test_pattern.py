"""Patterns: made, saved, drawn and refused."""

from pathlib import Path

import numpy as np
import pytest
from frangible import Pattern, patterns
from frangible.breaking.pattern import exploded
from frangible.cli import main
from PIL import Image


@pytest.mark.parametrize("kind", [name for name, _ in patterns()])
def test_each_kind_is_made_and_fills_its_box(kind: str) -> None:
    pattern = Pattern.named(kind, cells=30, seed=2)
    assert 20 <= len(pattern) <= 45
    volumes = []
    for cell in range(len(pattern)):
        vertices, triangles = pattern.region_mesh(cell)
        a, b, c = vertices[triangles].swapaxes(0, 1)
        volumes.append(np.sum(a * np.cross(b, c)) / 6)
    assert sum(volumes) == pytest.approx(8 * np.prod(pattern.half_extent), rel=1e-9)
    assert np.min(volumes) > 0


def test_a_pattern_is_saved_drawn_and_read_back(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    saved, picture = tmp_path / "rubble.json", tmp_path / "rubble.png"
    assert (
        main(
            [
                "pattern",
                "natural",
                "--cells",
                "12",
                "--seed",
                "3",
                "--out",
                str(saved),
                "--picture",
                str(picture),
            ]
        )
        == 0
    )
    facts = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert facts["cells"] == "12"
    assert Pattern.load(str(saved)) == Pattern.named("natural", cells=12, seed=3)
    assert Pattern.load(str(saved)) != Pattern.named("natural", cells=12, seed=4)
    pixels = np.asarray(Image.open(picture))
    assert pixels.std() > 20

    # A saved pattern is a name, too, and is saved as it was.
    again = tmp_path / "again.json"
    assert main(["pattern", str(saved), "--out", str(again)]) == 0
    assert again.read_bytes() == saved.read_bytes()


@pytest.mark.parametrize("lost", [None, 3])
def test_a_drawn_pattern_is_told_where_it_has_a_gap(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], lost: int | None
) -> None:
    pattern, text, first = Pattern.named("voronoi", cells=8), "", 1
    for cell in range(8):
        vertices, triangles = pattern.region_mesh(cell)
        if cell != lost:
            text += "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in vertices.tolist())
            text += "".join(f"f {a} {b} {c}\n" for a, b, c in (triangles + first).tolist())
            first += len(vertices)
    path = tmp_path / "drawn.obj"
    path.write_text(text)
    if lost is None:
        assert main(["pattern", str(path)]) == 0
    else:
        assert main(["pattern", str(path)]) == 2
        assert (
            f"{path}: a gap of 0.78 m^3 (9.8 % of the box) around (-0.7236, 0.086, 0.5948)"
            in capsys.readouterr().err
        )


def test_pieces_are_pulled_apart_from_the_middle() -> None:
    pattern = Pattern.named("voronoi", cells=10)
    together, apart = exploded(pattern, 1.0), exploded(pattern, 2.0)
    for near, far in zip(together.bodies, apart.bodies, strict=True):
        assert far.positions[0] == pytest.approx(2.0 * near.positions[0])
    points = np.concatenate([body.vertices_world(0) for body in together.bodies])
    assert np.abs(points).max(axis=0) == pytest.approx(pattern.half_extent, abs=1e-6)


def test_mortar_has_the_colour_of_cracks() -> None:
    pattern = Pattern.named("bricks", cells=30)
    joints = [pattern.is_joint(cell) for cell in range(len(pattern))]
    assert any(joints) and not all(joints)
    assert [bool(body.interior.all()) for body in exploded(pattern).bodies] == joints


def test_kinds_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["pattern", "--help"])
    shown = capsys.readouterr().out
    assert all(f"{name} " in shown and line in shown for name, line in patterns())


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["bubbles"], "pattern: bubbles, must be one of radial, voronoi, natural"),
        (["natural", "--cells", "20000"], "cells: 20000, must be from 1 to 10000"),
        (["none.json"], "none.json: no such file"),
        (
            ["natural", "--out", "x.obj"],
            "x.obj: the ending '.obj' is unknown, must be one of .json, .png",
        ),
        (["natural", "--picture", "x.jpg"], "--picture: x.jpg, must end in .png"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["pattern", *arguments]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"frangible: {sentence}") and error.count("\n") == 1


def test_a_cell_that_is_none_is_refused() -> None:
    with pytest.raises(IndexError, match="cell: 9, must be below the number of cells, 3"):
        Pattern.named("voronoi", cells=3).region_mesh(9)
