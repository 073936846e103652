"""Break a mesh, glue its pieces, simulate: one way."""

import json
from pathlib import Path

import frangible
import pytest
from frangible import BuildError, Recording
from frangible.cli import main
from frangible.mesh_scene import Wishes, mesh_scene

#: An arch, which is not convex: outline in x and y, extruded along z.
OUTLINE = [(0, 0), (0.5, 0), (0.5, 1), (1.5, 1), (1.5, 0), (2, 0), (2, 1.5), (0, 1.5)]
CAP = [(0, 1, 2), (0, 2, 7), (2, 3, 6), (2, 6, 7), (3, 4, 5), (3, 5, 6)]
VOLUME = 3.0 - 1.0


@pytest.fixture
def pieces(tmp_path: Path) -> Path:
    """An arch in pieces, and their report."""
    pytest.importorskip("manifold3d")
    corners = [(x, y, z) for z in (0.0, 0.5) for x, y in OUTLINE]
    faces = [(c, b, a) for a, b, c in CAP] + [(a + 8, b + 8, c + 8) for a, b, c in CAP]
    for a in range(8):
        b = (a + 1) % 8
        faces += [(a, b, b + 8), (a, b + 8, a + 8)]
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    mesh = tmp_path / "arch.obj"
    mesh.write_text("\n".join(lines))
    path = tmp_path / "pieces.glb"
    command = f"break {mesh} --pattern voronoi --pieces 20 --quiet --out {path}"
    assert main(command.split()) == 0
    return path


def broken(recording: Recording) -> int:
    return sum(len(body.name.split(".")) > 1 for body in recording.bodies)


def test_pieces_are_glued_stand_and_break(pieces: Path, tmp_path: Path) -> None:
    cache = tmp_path / "run.npz"
    run = ["run", str(pieces), "--glue", "5e5", "--ground", "--out", str(cache), "--quiet"]
    assert main([*run, "--frames", "60"]) == 0
    assert broken(Recording.load(cache)) == 0
    ball = ["--ball", "0.4,20", "--from", "4,0.8,0.25", "--hit-at-frame", "5", "--frames", "20"]
    assert main([*run, *ball]) == 0
    assert broken(Recording.load(cache)) > 2


def test_contacts_are_those_of_the_break(pieces: Path) -> None:
    """What the report says of a contact decides what it bears: with areas of nearly nothing the
    arch falls apart by itself."""
    scene = mesh_scene(pieces, Wishes(glue=5e5, ground=True))
    whole = frangible.run(scene, frames=30)
    report = pieces.with_suffix(".json")
    facts = json.loads(report.read_text())
    for piece in facts["pieces"]:
        for neighbour in piece["neighbours"]:
            neighbour["area_m2"] *= 1e-4
    report.write_text(json.dumps(facts))
    assert broken(whole) == 0 and broken(frangible.run(scene, frames=30)) > 0


def test_a_folder_of_pieces(pieces: Path, tmp_path: Path) -> None:
    folder = tmp_path / "pieces"
    command = f"break {tmp_path / 'arch.obj'} --pattern voronoi --pieces 20 --quiet --out {folder}/"
    assert main(command.split()) == 0
    scene = mesh_scene(pieces, Wishes(glue=5e5, ground=True)).to_dict()
    scene["bodies"][1]["shape"]["path"] = str(folder)
    recording = frangible.run(scene, frames=2)
    assert broken(recording) == 0


def test_sentences(pieces: Path, tmp_path: Path) -> None:
    with pytest.raises(BuildError, match="pieces: 5, must be left out with glue"):
        mesh_scene(pieces, Wishes(glue=1e5, ground=True, pieces=5))
    one = mesh_scene(tmp_path / "arch.obj", Wishes(glue=1e5, ground=True))
    with pytest.raises(BuildError, match="with a pattern, or on a compound or a mesh of several"):
        frangible.run(one, frames=1)
