"""Scenes as UsdPhysics stages: without loss, and as other programs read them."""

import json
import math
import re
import warnings
from pathlib import Path
from typing import Any

import frangible
import numpy as np
import pytest
from frangible import BuildError, OutputError, Scene, World
from frangible.cli import main
from frangible.scene_file import save_scene
from frangible.scenes import read_scene
from test_scenes import SCENES, a_scene, valued
from test_usd import violations

pytest.importorskip("pxr")

#: Shots of every shape and of what else a scene can say.
SHOTS = ["wall-ball", "pane", "masonry", "bonded-pillar", "timber", "cradle", "card-house", "arch"]


def scenes() -> dict[str, dict[str, Any]]:
    found = {shot: json.loads(frangible.shot_scene(shot)) for shot in SHOTS}
    found["all"] = a_scene()
    shapes = [
        {"kind": "capsule", "radius": 0.3, "height": 1.1},
        {"kind": "cone", "radius": 0.3, "height": 1.1},
        {"kind": "cylinder", "radius": 0.1, "height": 0.7},
    ]
    turn = [0.1, 0.2, 0.3, 0.9]
    bodies = [
        {"name": "round", "shape": shape, "position": [0.1, 3.3 * i, 1 / 3], "orientation": turn}
        for i, shape in enumerate(shapes)
    ]
    ground = {"kind": "heightfield", "heights": [[0, 0.1], [0.2, 0.3]], "spacing": [0.7, 3]}
    sheet = {
        "kind": "triangles",
        "positions": [[0, 0, 0], [1, 0, 0], [0, 0, 1 / 3]],
        "triangles": [[0, 1, 2]],
        "sides": "two",
    }
    still = {"motion": "static", "friction": 0.3, "restitution": 0.1}
    found["shapes"] = {
        "gravity": [1, -2, 3],
        "frames_per_second": 24,
        "frames": 7,
        "sleep": True,
        "solver": {"quality": "film"},
        "materials": {"granite": {"like": "concrete", "density": 2700}},
        "bodies": [
            *bodies,
            {"shape": ground, **still},
            {"shape": sheet, "name": "a b/c", **still},
            {
                "name": "led",
                "motion": "kinematic",
                "shape": {"kind": "box", "size": [0.1, 0.2, 1 / 3]},
                "linear_velocity": [0.1, 0, -1 / 3],
                "angular_velocity": [0, 2, 0.1],
                "position": [20, 0, 0],
            },
            {
                "name": "hangs",
                "shape": {"kind": "sphere", "radius": 0.25},
                "position": [30, 0, 0],
                "starts": {"when": "struck"},
            },
            {
                "name": "later",
                "shape": {"kind": "sphere", "radius": 0.25},
                "position": [32, 0, 0],
                "linear_velocity": [0, 1, 0],
                "starts": {"frame": 5},
            },
            {
                "name": "block",
                "material": "granite",
                "shape": {"kind": "box", "size": [1, 1, 1]},
                "position": [40, 0, 0],
                "breaking": {"pieces": 30},
            },
        ],
    }
    return found


@pytest.mark.parametrize("name", scenes())
@pytest.mark.parametrize("ending", [".usda", ".usdc"])
def test_scenes_come_back_without_loss(name: str, ending: str, tmp_path: Path) -> None:
    scene = scenes()[name]
    path = tmp_path / f"scene{ending}"
    save_scene(scene, path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        back = read_scene(path)
    assert json.dumps(valued(back)) == json.dumps(valued(scene))
    # A file of another name is the same.
    other = tmp_path / f"other{ending}"
    path.rename(other)
    assert json.dumps(read_scene(other)) == json.dumps(back)
    assert World.build(back, 1).state_hash() == World.build(scene, 1).state_hash()


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.name)
def test_scenes_of_the_docs_come_back(path: Path, tmp_path: Path) -> None:
    scene = Scene.load(path)
    scene.save(tmp_path / "scene.usda")
    assert Scene.load(tmp_path / "scene.usda") == scene


def test_what_the_stage_says_itself_is_the_scene(tmp_path: Path) -> None:
    """Without what is kept beside: the stage as another program reads it builds the same world."""
    for name, scene in scenes().items():
        path = tmp_path / "scene.usda"
        save_scene(scene, path)
        text = path.read_text()
        bare = re.sub(r"\n\s*string exact = .*", "", text)
        path.write_text(bare)
        assert "exact" not in bare
        back = read_scene(path)
        expected, found = World.build(scene, 1), World.build(back, 1)
        # The frames of bodies may be others, and meshes of singles.
        assert len(expected.ids) == len(found.ids), name
        assert found.waiting.tolist() == expected.waiting.tolist(), name
        assert found.positions == pytest.approx(expected.positions, abs=1e-5), name
        finite = np.isfinite(expected.masses)
        assert found.masses[finite] == pytest.approx(expected.masses[finite], rel=1e-5), name
        assert found.velocities == pytest.approx(expected.velocities, abs=1e-5), name
        turned = expected.angular_velocities
        assert found.angular_velocities == pytest.approx(turned, abs=1e-5), name
        breaking = [body["name"] for body in back["bodies"] if "breaking" in body]
        breaks = [body for body in scene["bodies"] if body.get("breaking")]
        assert len(breaking) == len(breaks), name


def test_another_program_reads_the_same_bodies(tmp_path: Path) -> None:
    """USD's own reader of physics as the oracle."""
    from pxr import Usd, UsdPhysics

    scene = scenes()["shapes"]
    save_scene(scene, tmp_path / "scene.usda")
    stage = Usd.Stage.Open(str(tmp_path / "scene.usda"))
    load = getattr(UsdPhysics, "LoadUsdPhysicsFromRange", None)
    if load is None:
        pytest.skip("this version has no reader for Python")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        found = load(stage, ["/"])
    paths, bodies = found[UsdPhysics.ObjectType.RigidBody]
    moving = [body for body in scene["bodies"] if body.get("motion") != "static"]
    assert len(paths) == len(moving)
    by_path = {str(path): body for path, body in zip(paths, bodies, strict=True)}
    led = by_path["/World/led"]
    assert led.kinematicBody and list(led.position) == pytest.approx([20, 0, 0])
    assert list(led.linearVelocity) == pytest.approx([0.1, 0, -1 / 3])
    assert list(led.angularVelocity) == pytest.approx([0, math.degrees(2), math.degrees(0.1)])
    _, cones = found[UsdPhysics.ObjectType.ConeShape]
    assert (cones[0].radius, cones[0].halfHeight) == pytest.approx((0.3, 0.55))
    _, planes = found[UsdPhysics.ObjectType.MeshShape]
    assert len(planes) == 2
    (_, (gravity,)) = found[UsdPhysics.ObjectType.Scene]
    direction = np.array(gravity.gravityDirection) * gravity.gravityMagnitude
    assert direction == pytest.approx([1, -2, 3], rel=1e-6)


@pytest.mark.parametrize("name", ["shapes", "all", "bonded-pillar"])
def test_no_validator_of_usd_objects_to_a_scene(name: str, tmp_path: Path) -> None:
    """Its rules of physics among them."""
    from pxr import Usd

    save_scene(scenes()[name], tmp_path / "scene.usda")
    assert violations(Usd.Stage.Open(str(tmp_path / "scene.usda"))) == []


def test_what_is_changed_in_the_stage_counts(tmp_path: Path) -> None:
    path = tmp_path / "scene.usda"
    save_scene(json.loads(frangible.shot_scene("wall-ball")), path)
    before = read_scene(path)
    text = path.read_text()
    changed = text.replace("float physics:density = 2400", "float physics:density = 1200", 1)
    assert changed != text
    path.write_text(changed)
    after = read_scene(path)
    differing = [
        (one["name"], field)
        for one, other in zip(before["bodies"], after["bodies"], strict=True)
        for field in {**one, **other}
        if one.get(field) != other.get(field)
    ]
    assert differing == [("wall", "density")]
    assert {one["name"]: one.get("density") for one in after["bodies"]}["wall"] == 1200


def test_the_command_writes_a_scene(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "wall.usda"
    assert main(["scene", "wall-ball", "--out", str(path)]) == 0
    ends = []
    for name in ("wall-ball", str(path)):
        arguments = ["--json", "--quiet", "--threads", "1", "--frames", "20"]
        assert main(["run", name, *arguments]) == 0
        captured = capsys.readouterr()
        assert captured.err == ""
        ends.append(json.loads(captured.out)["state_hash"])
    assert ends[0] == ends[1]
    with pytest.raises(OutputError, match="must end in .json, .toml, .usd, .usda or .usdc"):
        save_scene({"bodies": []}, tmp_path / "a.txt")
    with pytest.raises(BuildError, match="bodies: missing"):
        save_scene({}, tmp_path / "a.usda")
    assert not (tmp_path / "a.usda").exists()
