"""UsdPhysics stages that others wrote: each loads, and says in one sentence each what it holds that
a scene does not."""

import json
import warnings
from pathlib import Path
from typing import Any

import frangible
import numpy as np
import pytest
from frangible import World
from frangible.cli import main
from frangible.io.reading import FileNote
from frangible.scenes import read_scene

pytest.importorskip("pxr")

STAGES = Path(__file__).parent / "stages"

#: What is said of each.
SAID: dict[str, list[str]] = {
    "openusd/BoxOnBox": [],
    "openusd/BoxOnQuad": [],
    "openusd/DistanceJoint": [
        "type DistancePhysicsJoint, which USD does not know (/World/DistanceJoint): left out"
    ],
    "openusd/GroupFiltering": [],
    "openusd/Joints": ["joint (/World/D6Joint): its bodies move freely"],
    "openusd/PairFiltering": [],
    "openusd/SpheresWithMaterial": [],
    "newton/box_on_plane": [
        "filtered group that is not there (/box_on_plane/Collisions): left out",
        "static friction of its own (/box_on_plane/Materials/Steel): the dynamic one",
    ],
    "newton/boxes_hinged": [
        "joint (/boxes_hinged/Joints/joint_1): its bodies move freely",
        "static friction of its own (/boxes_hinged/Materials/Steel and 1 more): the dynamic one",
    ],
    "newton/cube_cylinder": [
        "approximation convexDecomposition (/World/Cylinder_dynamic/cylinder_reverse/mesh_0): the "
        "mesh itself collides",
        "approximation meshSimplification (/World/Cube_static/cube2/mesh_0): the mesh itself "
        "collides",
        "length of 1000000 frames (endTimeCode): three seconds instead",
    ],
    "newton/negative_scale_mesh_pair": [],
    "newton/sensor_contact_scene": [
        "articulation (/env/Anchor): its bodies move freely",
        "joint (/env/Hinge and 1 more): its bodies move freely",
        "rigid body without a collider (/env/Anchor): left out",
    ],
}


def path_of(name: str) -> Path:
    return STAGES / f"{name}.usda"


def read(name: str) -> tuple[dict[str, Any], list[str]]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", FileNote)
        scene = read_scene(path_of(name))
    prefix = f"{path_of(name)}: "
    return scene, [str(one.message).removeprefix(prefix) for one in caught]


def test_all_stages_are_tried() -> None:
    found = {str(path.relative_to(STAGES).with_suffix("")) for path in STAGES.rglob("*.usda")}
    assert found == set(SAID) and len(found) >= 10


@pytest.mark.parametrize("name", SAID)
def test_a_stage_is_simulated_and_the_rest_of_it_named(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    scene, notes = read(name)
    assert notes == SAID[name]
    path = path_of(name)
    assert main(["run", str(path), "--frames", "20", "--json", "--quiet", "--threads", "1"]) == 0
    captured = capsys.readouterr()
    assert captured.err.splitlines() == [f"frangible: {path}: {note}" for note in notes]
    summary = json.loads(captured.out)
    assert summary["bodies"]["end"] == len(scene["bodies"])
    assert summary["energy_J"]["max_frame_gain"] <= 1e-9 * summary["energy_J"]["scale"]
    # Bodies that joints hold in the stage fall onto others here.
    assert summary["penetration_m"]["max"] < 0.1


@pytest.mark.parametrize("name", SAID)
def test_bodies_are_those_that_usd_itself_finds(name: str) -> None:
    """Bodies, poses, kinds and sizes by the library's own reader of physics."""
    from pxr import Usd, UsdPhysics

    load = getattr(UsdPhysics, "LoadUsdPhysicsFromRange", None)
    if load is None:
        pytest.skip("this version has no reader for Python")
    stage = Usd.Stage.Open(str(path_of(name)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        found = load(stage, ["/"])
    scene, _ = read(name)
    ours = {body["name"]: body for body in scene["bodies"] if body.get("motion") != "static"}
    kinds = UsdPhysics.ObjectType
    paths, bodies = found.get(kinds.RigidBody, ([], []))
    theirs = {str(path): body for path, body in zip(paths, bodies, strict=True)}
    without = {path for path, body in theirs.items() if not len(body.collisions)}
    assert set(ours) == set(theirs) - without

    from frangible.io.usd_stage import metres_from_stage

    frame = metres_from_stage(name, stage)
    for path, body in ours.items():
        place = frame @ np.array(theirs[path].position)
        if len(theirs[path].collisions) == 1 and body["shape"]["kind"] != "mesh":
            continue
        assert body.get("position", [0, 0, 0]) == pytest.approx(place, abs=1e-6), path
    unit = float(np.linalg.norm(frame[0]))
    for path, cube in zip(*found.get(kinds.CubeShape, ([], [])), strict=True):
        size = 2 * unit * np.array(cube.halfExtents)
        sizes = [body["shape"]["size"] for body in scene["bodies"] if body["shape"].get("size")]
        assert any(np.allclose(size, one, rtol=1e-5) for one in sizes), path
    for path, sphere in zip(*found.get(kinds.SphereShape, ([], [])), strict=True):
        radii = [body["shape"].get("radius") for body in scene["bodies"]]
        assert unit * sphere.radius in [pytest.approx(radius) for radius in radii if radius], path


def test_a_box_of_pixars_falls_as_it_should() -> None:
    """From 5 m at 2 m/s sideways in centimetres, on a box whose top is at 10 cm."""
    recording = frangible.run(path_of("openusd/BoxOnBox"), frames=60, threads=1)
    box = next(body for body in recording.bodies if body.name == "/World/BoxActor")
    assert box.mass == pytest.approx(1000 * 0.25**3)
    time = np.arange(len(box.positions)) / 24
    flight = time < 0.9
    # 2, 1, 2 cm/s along x, y, z of the stage.
    expected = np.stack([0.02 * time, 5 + 0.02 * time - 0.5 * 9.81 * time**2, -0.01 * time], axis=1)
    assert box.positions[flight] == pytest.approx(expected[flight], abs=1e-6)
    assert box.positions[-1][1] == pytest.approx(0.1 + 0.125, abs=0.02)


def test_mirrored_meshes_weigh_the_same() -> None:
    scene, _ = read("newton/negative_scale_mesh_pair")
    first, second = World.build(scene, 1).masses
    assert first == pytest.approx(second, rel=1e-9)
