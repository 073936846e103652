"""Pieces as MJCF and URDF: exact masses and inertia, and nothing flies apart in MuJoCo."""

import json
import os
import subprocess
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from frangible import OutputError, break_mesh
from frangible.cli import main
from frangible.io.pieces_output import open_pieces_output
from support import TOOLS
from test_first_ten_minutes import ARCH

pytest.importorskip("manifold3d")
from frangible.io.convex_parts import convex_parts

#: A Python that has mujoco.
MUJOCO = os.environ.get("MUJOCO_PYTHON")
DENSITY = 2400.0
#: One by one by one metre.
BOX = "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1)) + (
    "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("robot")
    for name, mesh in (("arch", ARCH), ("box", BOX)):
        (folder / f"{name}.obj").write_text(mesh)
        for ending in ("xml", "urdf"):
            command = ["break", str(folder / f"{name}.obj"), "--pattern", "voronoi", "--quiet"]
            command += ["--pieces", "12", "--density", "2400"]
            # Shards that join a neighbour make it hollow.
            command += ["--smallest", "1e-2"] if name == "arch" else []
            assert main([*command, "--out", str(folder / f"{name}.{ending}")]) == 0
    return folder


def expected(folder: Path, name: str) -> dict[str, dict[str, Any]]:
    report = json.loads((folder / f"{name}.json").read_text())
    return {piece["name"]: piece for piece in report["pieces"]}


@pytest.mark.parametrize("name", ["arch", "box"])
def test_masses_and_inertia_are_those_of_the_pieces(folder: Path, name: str) -> None:
    pieces = expected(folder, name)
    model = ElementTree.parse(folder / f"{name}.xml")
    robot = ElementTree.parse(folder / f"{name}.urdf")
    bodies = {body.get("name"): body for body in model.iter("body")}
    links = {link.get("name"): link for link in robot.iter("link") if link.get("name") != "world"}
    assert set(bodies) == set(links) == set(pieces)
    for key, piece in pieces.items():
        tensor = DENSITY * np.array(piece["unit_inertia_m5"])
        six = [tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[0, 2], tensor[1, 2]]
        inertial = bodies[key].find("inertial")
        assert inertial is not None
        assert float(inertial.get("mass", "")) == DENSITY * piece["volume_m3"]
        full = [float(number) for number in inertial.get("fullinertia", "").split()]
        assert full == pytest.approx(six, rel=1e-12, abs=1e-15)
        place = [float(number) for number in bodies[key].get("pos", "").split()]
        assert place == piece["center_m"]
        mass, inertia = (links[key].find(f"inertial/{tag}") for tag in ("mass", "inertia"))
        assert mass is not None and inertia is not None
        assert float(mass.get("value", "")) == DENSITY * piece["volume_m3"]
        names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        assert [float(inertia.get(one, "")) for one in names] == full


def test_every_mesh_that_is_named_is_there(folder: Path) -> None:
    for name in ("arch", "box"):
        model = ElementTree.parse(folder / f"{name}.xml")
        named = {mesh.get("file") for mesh in model.iter("mesh")}
        assert named == set(os.listdir(folder / f"{name}_meshes"))
        robot = ElementTree.parse(folder / f"{name}.urdf")
        for mesh in robot.iter("mesh"):
            assert (folder / mesh.get("filename", "")).is_file()


def test_colliders_are_convex_and_cover_the_piece(folder: Path) -> None:
    from frangible import Pattern

    pieces = break_mesh(folder / "arch.obj", Pattern.named("voronoi", cells=4))
    counts = []
    for piece in pieces.pieces:
        parts = convex_parts(piece)
        counts.append(len(parts))
        volume = 0.0
        for vertices, triangles in parts:
            corners = vertices[triangles]
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            volume += np.einsum("ij,ij->i", corners[:, 0], normals).sum() / 6.0
            # No corner is outside of any face.
            out = np.einsum("ij,kij->ki", normals, vertices[:, None] - corners[:, 0])
            size = np.linalg.norm(normals, axis=1) * np.ptp(vertices, axis=0).max()
            assert np.all(out <= 1e-6 * size)
        assert piece.volume * (1 - 1e-5) <= volume <= piece.volume * 1.2
    # The arch is hollow: some of its pieces are not convex.
    assert max(counts) > 1


def test_pieces_that_are_too_small_are_told_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = BOX.splitlines()
    places = [line.replace("1", "0.001") for line in lines if line.startswith("v")]
    (tmp_path / "small.obj").write_text("\n".join([*places, *lines[len(places) :]]) + "\n")
    command = ["break", str(tmp_path / "small.obj"), "--pattern", "voronoi", "--pieces", "60"]
    assert main([*command, "--out", str(tmp_path / "small.xml"), "--quiet"]) == 0
    assert "kg m^2, which MuJoCo refuses; --smallest merges" in capsys.readouterr().err


def test_a_folder_with_anything_else_stays(tmp_path: Path) -> None:
    (tmp_path / "a_meshes").mkdir()
    (tmp_path / "a_meshes" / "letter.txt").write_text("dear")
    with pytest.raises(OutputError, match="letter.txt"):
        open_pieces_output(str(tmp_path / "a.xml"))


@pytest.mark.skipif(MUJOCO is None, reason="needs MUJOCO_PYTHON, a Python with mujoco")
@pytest.mark.parametrize("file", ["box.xml", "arch.xml", "box.urdf"])
def test_mujoco_has_the_same_pieces_and_they_stay_calm(folder: Path, file: str) -> None:
    command = [str(MUJOCO), str(TOOLS / "settle_in_mujoco.py"), str(folder / file)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout)
    pieces = expected(folder, Path(file).stem)
    assert set(seen["bodies"]) == set(pieces) and seen["free"] == len(pieces)
    # y of the mesh is z of a URDF.
    turn = np.eye(3) if file.endswith("xml") else np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    for key, piece in pieces.items():
        body = seen["bodies"][key]
        assert body["mass"] == pytest.approx(DENSITY * piece["volume_m3"], rel=1e-9)
        tensor = DENSITY * np.array(piece["unit_inertia_m5"])
        # Of the body's own frame, which a URDF turns as a whole.
        scale = np.abs(tensor).max()
        assert np.array(body["inertia"]) == pytest.approx(tensor, abs=1e-6 * scale)
        assert body["center"] == pytest.approx(turn @ piece["center_m"], abs=1e-9)
    # Pieces may fall as far as the mesh is high, and no faster; for ever where nothing is below.
    height = max(piece["high_m"][1] for piece in pieces.values())
    height -= min(piece["low_m"][1] for piece in pieces.values())
    fall = np.sqrt(2 * 9.81 * height) if file.endswith("xml") else 9.81
    assert seen["fastest"] < 1.05 * fall
    # Convex pieces touch, and those of an arch overlap by a little.
    assert seen["depth"] < (1e-6 if file.startswith("box") else 0.03)
