"""Scenes as dataclasses: the fields of the schema, and the same worlds as from dictionaries."""

import json
import typing
from pathlib import Path
from typing import Any

import frangible
import numpy as np
import pytest
from frangible import (
    Anchor,
    Body,
    Bonds,
    Box,
    BoxPart,
    Breaking,
    BuildError,
    Compound,
    HalfSpace,
    Material,
    OutputError,
    Scene,
    Slices,
    Sphere,
    Strength,
    Voronoi,
    World,
    scene_types,
)
from frangible.cli.scene_module import class_name, scene_module
from frangible.description import Description
from test_scenes import SCENES, a_scene, valued

SCHEMA = frangible.scene_schema()


def test_the_module_is_what_the_schema_makes() -> None:
    stored = Path(frangible.__file__).with_name("scene_types.py").read_text(encoding="utf-8")
    rule = "write it anew: frangible schema --python > python/frangible/scene_types.py"
    assert stored == scene_module(SCHEMA), rule


def objects() -> list[tuple[str, dict[str, Any], type[Description]]]:
    """Each object of the schema with its class; of unions each kind."""
    found = [("scene", SCHEMA, Scene)]
    for name, part in SCHEMA["$defs"].items():
        for one in part.get("oneOf", [part]):
            if "properties" not in one:
                continue
            kind = one["properties"].get("kind", {}).get("const")
            found.append((f"{name} {kind}", one, getattr(scene_types, class_name(name, kind))))
    return found


@pytest.mark.parametrize(("name", "part", "cls"), objects(), ids=lambda value: str(value)[:40])
def test_each_object_has_a_class_with_its_fields(
    name: str, part: dict[str, Any], cls: type[Description]
) -> None:
    """Told apart from how the module was made: by names only."""
    fields = [field for field in part["properties"] if field != "kind"]
    types = typing.get_type_hints(cls)
    assert sorted(fields) == sorted(set(types) - {"KIND", "_"}), name
    assert part["properties"].get("kind", {}).get("const") == cls.KIND


def a_described_scene() -> Scene:
    """What `a_scene` of the tests of dictionaries says."""
    wall = Body(
        Box([2, 2, 0.3], resolution=frangible.Resolution()),
        name="wall",
        position=np.array([0, 1, 0]),
        orientation=(0, 0, 0, 1),
        density=2400,
        look="concrete",
        breaking=Breaking(
            strength=Strength(3e6, 30e9, 100),
            pattern=Voronoi(cells=12, grading=[0, 0, 0], seed=3),
            generations=1,
        ),
    )
    hull = Body(
        frangible.Hull([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        name="hull",
        position=[5, 1, 0],
    )
    stool = Body(
        Compound([BoxPart([1, 0.1, 1]), BoxPart([0.1, 1, 0.1])]), name="stool", position=[-5, 1, 0]
    )
    glue = Bonds(1e6, 1e6, pattern=Slices(cells=4), anchors=[Anchor([-2, 4, -1], [-0.5, 6, 1])])
    beam = Body(Box([2, 0.2, 0.2]), name="beam", position=[0, 5, 0], bonds=glue)
    ground = Body(HalfSpace(), name="ground", motion="static")
    return Scene(
        [ground, wall, hull, stool, beam],
        name="all",
        gravity=[0, -9.81, 0],
        frames_per_second=30.0,
    )


def test_a_described_scene_is_the_dictionary() -> None:
    expected = valued(a_scene())
    assert a_described_scene().to_dict() == expected
    assert Scene.from_dict(a_scene()).to_dict() == expected
    assert Scene.from_dict(a_scene()) == Scene.from_dict(expected)


def test_a_described_scene_builds_the_same_world() -> None:
    hashes = set()
    for scene in (a_scene(), a_described_scene(), Scene.from_dict(a_scene())):
        world = World.build(scene, 1)
        world.step()
        hashes.add(world.state_hash())
    assert len(hashes) == 1


@pytest.mark.parametrize("shot", ["wall", "masonry", "nut", "bonded-pillar", "rain-25"])
def test_scenes_of_shots_are_read_and_written_without_loss(shot: str) -> None:
    scene = json.loads(frangible.shot_scene(shot))
    assert Scene.from_dict(scene).to_dict() == valued(scene)


def test_paths_of_a_saved_scene_are_of_its_folder(tmp_path: Path) -> None:
    inner, outer = tmp_path / "set" / "a.obj", tmp_path / "b.obj"
    inner.parent.mkdir()
    scene = Scene([Body(frangible.Mesh(str(path))) for path in (inner, outer)])
    for ending in (".json", ".toml"):
        path = inner.parent / f"scene{ending}"
        scene.save(path)
        assert '"a.obj"' in path.read_text() and str(outer) in path.read_text()
        assert Scene.load(path) == scene
    assert isinstance(scene.bodies[0].shape, frangible.Mesh)
    assert scene.bodies[0].shape.path == str(inner), "the scene itself is as before"


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.name)
@pytest.mark.parametrize("ending", [".json", ".toml"])
def test_scenes_are_loaded_and_saved(path: Path, ending: str, tmp_path: Path) -> None:
    scene = Scene.load(path)
    scene.save(tmp_path / f"copy{ending}")
    assert Scene.load(tmp_path / f"copy{ending}") == scene
    with pytest.raises(OutputError, match="must end in .json, .toml, .usd, .usda or .usdc"):
        scene.save(tmp_path / "copy.txt")


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (
            {"bodys": []},
            r"^bodys: unknown field \(did you mean 'bodies'\?\), must be one of bodies",
        ),
        ({"bodies": [{"name": "a"}]}, r"^bodies\[0\].shape: missing, must be given"),
        ({"bodies": [{"shape": {"kind": "bx"}}]}, r"^bodies\[0\].shape.kind: 'bx' \(did you mean"),
        ({"bodies": [{"shape": {}}]}, r"^bodies\[0\].shape.kind: missing, must be one of half-sp"),
        (
            {"bodies": [{"shape": {"kind": "sphere", "radius": 1, "size": 2}}]},
            r"^bodies\[0\].shape.size: unknown field, must be one of radius, resolution",
        ),
        ({"materials": {"a": {"lke": "x"}}, "bodies": []}, r"^materials.a.lke: unknown field"),
    ],
)
def test_what_is_no_scene_is_named(change: dict[str, Any], sentence: str) -> None:
    with pytest.raises(BuildError, match=sentence):
        Scene.from_dict(change)


def test_a_run_takes_a_described_scene() -> None:
    scene = Scene(
        bodies=[
            Body(HalfSpace(), motion="static"),
            Body(Box([2, 2, 0.3]), name="wall", position=[0, 1, 0], material="concrete"),
            Body(Sphere(0.2), position=[0, 1, 1], linear_velocity=[0, 1, -20], material="steel"),
        ],
        materials={"granite": Material(like="concrete", density=2700, look="stone")},
    )
    recording = frangible.run(scene, frames=4, threads=1)
    assert recording.frames == 4 and any(report["fractures"] for report in recording.reports)
    assert {body.look for body in recording.bodies} == {None, "concrete", "metal"}
