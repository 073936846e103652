"""UsdPhysics stages as scenes: shapes, masses, materials, units, and what is named as left out."""

import math
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import frangible
import numpy as np
import pytest
from frangible import BuildError, World
from frangible.cli import main
from frangible.io.reading import FileNote
from frangible.scenes import read_scene

pytest.importorskip("pxr")

#: A box of one metre as a mesh, in the stage's unit.
BOX_MESH = """
int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]
int[] faceVertexIndices = [0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3]
point3f[] points = [(-.5, -.5, -.5), (-.5, -.5, .5), (-.5, .5, -.5), (-.5, .5, .5),
                    (.5, -.5, -.5), (.5, -.5, .5), (.5, .5, -.5), (.5, .5, .5)]
uniform token subdivisionScheme = "none"
"""
BODY = 'prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMassAPI"]'
FRACTURE = BODY.replace("PhysicsMassAPI", "FrangibleFractureAPI")
STILL = 'prepend apiSchemas = ["PhysicsCollisionAPI"]'


def stage(text: str, up: str = "Y", metres: float = 1.0, more: str = "") -> str:
    head = f'#usda 1.0\n(\n upAxis = "{up}"\n metersPerUnit = {metres}\n{more}\n)\n'
    return f'{head}def Xform "World"\n{{\n{text}\n}}\n'


def a_prim(kind: str, name: str, text: str = "", api: str = BODY) -> str:
    return f'def {kind} "{name}" (\n{api}\n)\n{{\n{text}\n}}\n'


def moved(*ops: str) -> str:
    """Transform operations, such as ``translate = (1, 2, 3)``, in order."""
    kinds = {"translate": "double3", "scale": "float3", "orient": "quatf"}
    lines = []
    for op in ops:
        name = op.partition(" ")[0]
        lines.append(f"{kinds.get(name, 'float')} xformOp:{op}")
    order = ", ".join(f'"xformOp:{op.partition(" ")[0]}"' for op in ops)
    return "\n".join([*lines, f"uniform token[] xformOpOrder = [{order}]"])


@pytest.fixture
def read(tmp_path: Path) -> Any:
    """Reads a stage from text: the scene, and the sentences of its notes without the file."""

    def read_text(text: str) -> tuple[dict[str, Any], list[str]]:
        path = tmp_path / "stage.usda"
        path.write_text(text)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", FileNote)
            scene = read_scene(path)
        notes = [str(one.message).removeprefix(f"{path}: ") for one in caught]
        World.build(scene, 1)
        return scene, notes

    return read_text


def body(scene: dict[str, Any], name: str) -> dict[str, Any]:
    (found,) = (one for one in scene["bodies"] if one["name"] == f"/World/{name}")
    fields: dict[str, Any] = found
    return fields


def up_of(one: dict[str, Any]) -> list[float]:
    """Where the shape's y points."""
    x, y, z, w = one.get("orientation", [0, 0, 0, 1])
    return [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)]


def test_bodies_wait_as_the_stage_says(read: Any) -> None:
    """Asleep until they are struck, or until a frame of the timeline."""
    asleep = "uniform bool physics:startsAsleep = 1"
    velocity = "vector3f physics:velocity = (1, 0, 0)"
    text = "\n".join(
        [
            a_prim("Cube", "sleeps", asleep + "\n" + moved("translate = (10, 0, 0)")),
            a_prim("Cube", "wakes", moved("translate = (20, 0, 0)")),
            a_prim(
                *("Cube", "at", f"{velocity}\nint frangible:startsAtFrame = 1012\n{asleep}\n"),
            ),
            a_prim(
                *("Cube", "early", "int frangible:startsAtFrame = 3\n"),
            ),
            a_prim(*("Cube", "moves", f"{velocity}\n{asleep}\n" + moved("translate = (30, 0, 0)"))),
            a_prim("Cube", "led", f"bool physics:kinematicEnabled = 1\n{asleep}"),
        ]
    )
    scene, notes = read(stage(text, more="startTimeCode = 1001\nendTimeCode = 1050"))
    assert body(scene, "sleeps")["starts"] == {"when": "struck"}
    assert body(scene, "at")["starts"] == {"frame": 11}
    assert body(scene, "at")["linear_velocity"] == [1, 0, 0]
    assert body(scene, "early")["starts"] == {"frame": 0}
    for name in ("wakes", "moves", "led"):
        assert "starts" not in body(scene, name)
    (moving, led) = sorted(notes)
    assert "starts asleep and moves" in moving and "/World/moves" in moving
    assert "starts awake" in moving
    assert "kinematic body that waits" in led and "follows its transform" in led


@pytest.mark.parametrize(
    ("kind", "text", "shape"),
    [
        ("Cube", "double size = 2", {"kind": "box", "size": [2, 2, 2]}),
        (
            "Cube",
            "double size = 2\n" + moved("scale = (1, 2, 3)"),
            {"kind": "box", "size": [2, 4, 6]},
        ),
        ("Sphere", "double radius = 0.5", {"kind": "sphere", "radius": 0.5}),
        (
            "Cylinder",
            'double radius = 0.5\ndouble height = 3\nuniform token axis = "X"',
            {"kind": "cylinder", "radius": 0.5, "height": 3},
        ),
        (
            "Cylinder",
            "double radius = 0.5\ndouble height = 3\n" + moved("scale = (2, 2, 3)"),
            {"kind": "cylinder", "radius": 1, "height": 9},
        ),
        (
            "Capsule",
            'double radius = 0.5\ndouble height = 2\nuniform token axis = "Y"',
            {"kind": "capsule", "radius": 0.5, "height": 2},
        ),
        (
            "Cone",
            "double radius = 0.5\ndouble height = 2",
            {"kind": "cone", "radius": 0.5, "height": 2},
        ),
    ],
)
def test_shapes_are_what_they_are(kind: str, text: str, shape: dict[str, Any], read: Any) -> None:
    scene, notes = read(stage(a_prim(kind, "a", text)))
    found = body(scene, "a")
    assert found["shape"] == shape and notes == []
    axis = {"X": [1, 0, 0], "Y": [0, 1, 0]}.get(text[-2:-1], [0, 0, 1])
    if kind in ("Cylinder", "Capsule", "Cone"):
        assert up_of(found) == pytest.approx(axis, abs=1e-12)
    place = [0, 0, -0.25 * 2] if kind == "Cone" else [0, 0, 0]
    assert found.get("position", [0, 0, 0]) == pytest.approx(place)


@pytest.mark.parametrize(
    ("kind", "text", "volume"),
    [
        ("Sphere", "double radius = 1\n" + moved("scale = (1, 2, 3)"), 4 / 3 * math.pi * 6),
        (
            "Cylinder",
            "double radius = 1\ndouble height = 2\n" + moved("scale = (1, 2, 3)"),
            math.pi * 2 * 6,
        ),
        ("Cube", "double size = 1\n" + moved("scale = (1, 2, 3)", "rotateX = 30"), 6),
        ("Mesh", 'uniform token physics:approximation = "convexHull"' + BOX_MESH, 1),
        ("Mesh", 'uniform token physics:approximation = "boundingCube"' + BOX_MESH, 1),
        (
            "Mesh",
            'uniform token physics:approximation = "boundingSphere"' + BOX_MESH,
            4 / 3 * math.pi * 0.75**1.5,
        ),
        ("Mesh", 'uniform token physics:approximation = "none"' + BOX_MESH, 1),
        ("Mesh", 'uniform token physics:approximation = "sdf"' + BOX_MESH, 1),
        ("Mesh", BOX_MESH + moved("scale = (1, 2, -3)"), 6),
        ("Mesh", BOX_MESH + moved("scale = (1, 2, 3)", "rotateX = 30"), 6),
    ],
)
def test_volumes_of_other_shapes(kind: str, text: str, volume: float, read: Any) -> None:
    """By the mass that the engine gives them at a density."""
    scene, _ = read(stage(a_prim(kind, "a", f"float physics:density = 10\n{text}")))
    assert body(scene, "a")["density"] == 10
    (mass,) = World.build(scene, 1).masses
    # A hull of the round is inside it; what is sampled has the grid's volume.
    assert mass == pytest.approx(10 * volume, rel=0.06)
    with_mass, _ = read(stage(a_prim(kind, "a", f"float physics:mass = 3\n{text}")))
    (mass,) = World.build(with_mass, 1).masses
    assert mass == pytest.approx(3, rel=0.01)


def test_a_stage_in_centimetres_and_z_up_arrives_right(read: Any) -> None:
    """Told apart from the importer: places of corners in the world."""
    text = a_prim(
        "Cube",
        "wall",
        "double size = 100\n" + moved("translate = (10, 20, 300)", "scale = (2, 1, 3)"),
    )
    text += a_prim(
        "Cylinder",
        "post",
        "double radius = 10\ndouble height = 200\n" + moved("translate = (0, -100, 100)"),
    )
    text += a_prim("Plane", "ground", 'uniform token axis = "Z"', STILL)
    text += 'def PhysicsScene "physics"\n{\n}\n'
    scene, notes = read(stage(text, up="Z", metres=0.01))
    assert notes == [] and scene["gravity"] == [0, -9.81, 0]
    wall, post, ground = (body(scene, name) for name in ("wall", "post", "ground"))
    assert wall["shape"]["size"] == [2, 1, 3] and wall["position"] == [0.1, 3, -0.2]
    assert up_of(post) == pytest.approx([0, 1, 0]) and post["position"] == [0, 1, 1]
    assert ground["shape"] == {"kind": "half-space"} and up_of(ground) == pytest.approx([0, 1, 0])
    recording = frangible.run(scene, frames=1, threads=1)
    seen = next(one for one in recording.bodies if one.name == "/World/wall")
    corners = seen.vertices_world(0)
    assert corners.min(axis=0) == pytest.approx([-0.9, 1.5, -0.7], abs=1e-6)
    assert corners.max(axis=0) == pytest.approx([1.1, 4.5, 0.3], abs=1e-6)


@pytest.mark.parametrize(("up", "axis"), [("Y", 1), ("Z", 2)])
def test_gravity_is_the_scenes(up: str, axis: int, read: Any) -> None:
    cube = a_prim("Cube", "a")
    text = 'def PhysicsScene "p"\n{{\n{}\n}}\n' + cube.replace("{", "{{").replace("}", "}}")
    scene, _ = read(stage(text.format("float physics:gravityMagnitude = 300"), up, 0.01))
    assert scene["gravity"] == pytest.approx([0, -3, 0])
    direction = "vector3f physics:gravityDirection = (1, 0, 0)"
    scene, _ = read(stage(text.format(direction), up, 0.01))
    assert scene["gravity"] == pytest.approx([9.81, 0, 0])
    along = [0.0, 0.0, 0.0]
    along[axis] = 2.0
    direction = f"vector3f physics:gravityDirection = ({along[0]}, {along[1]}, {along[2]})"
    scene, _ = read(stage(text.format(direction), up, 0.01))
    assert scene["gravity"] == pytest.approx([0, 9.81, 0])
    assert read(stage(cube, up, 0.01))[0]["gravity"] == [0, -9.81, 0]


def test_masses_are_those_of_the_stages_units(read: Any) -> None:
    text = a_prim("Cube", "a", "double size = 200\nfloat physics:mass = 500")
    text += a_prim("Cube", "b", "double size = 100\nfloat physics:density = 0.0024")
    text += a_prim("Cube", "c", "double size = 100")
    scene, notes = read(stage(text, metres=0.01, more="kilogramsPerUnit = 0.001"))
    assert notes == []
    assert body(scene, "a")["density"] == pytest.approx(0.5 / 8)
    assert body(scene, "b")["density"] == pytest.approx(0.0024 * 0.001 / 1e-6)
    assert body(scene, "c")["density"] == 1000


def a_material(name: str, text: str) -> str:
    return a_prim("Material", name, text, 'prepend apiSchemas = ["PhysicsMaterialAPI"]')


def test_physics_materials_give_friction_restitution_and_density(read: Any) -> None:
    text = a_material(
        "rubber",
        "float physics:dynamicFriction = 0.9\nfloat physics:staticFriction = 0.9\n"
        "float physics:restitution = 0.7\nfloat physics:density = 1100",
    )
    text += a_material("ice", "float physics:dynamicFriction = 0.1")
    binding = "rel material:binding:physics = </World/{}>"
    text += a_prim("Cube", "a", binding.format("rubber"))
    text += a_prim("Cube", "b", "rel material:binding = </World/rubber>")
    text += a_prim("Cube", "c", binding.format("ice") + "\nrel material:binding = </World/rubber>")
    text += a_prim("Cube", "d", "float physics:density = 3\n" + binding.format("rubber"))
    text += a_prim("Cube", "e")
    scene, notes = read(stage(text))
    keys = ("friction", "restitution", "density")
    found = {one["name"][-1]: tuple(one[key] for key in keys) for one in scene["bodies"]}
    assert found == {
        "a": (0.9, 0.7, 1100),
        "b": (0.9, 0.7, 1100),
        "c": (0.1, 0, 1000),
        "d": (0.9, 0.7, 3),
        "e": (0.5, 0, 1000),
    }
    assert notes == ["static friction of its own (/World/ice): the dynamic one"]


def test_several_colliders_are_a_compound(read: Any) -> None:
    legs = a_prim("Cube", "leg", moved("translate = (1, -1, 0)", "rotateZ = 30"), STILL)
    top = a_prim("Cube", "top", moved("scale = (2, 0.1, 2)"), STILL)
    text = a_prim("Xform", "table", legs + top + moved("translate = (0, 5, 0)", "rotateY = 90"))
    scene, notes = read(stage(text))
    table = body(scene, "table")
    leg, plate = table["shape"]["parts"]
    assert plate == {"kind": "box", "size": [4, 0.2, 4]} and notes == []
    assert leg["size"] == [2, 2, 2] and leg["position"] == pytest.approx([1, -1, 0], abs=1e-12)
    assert leg["orientation"] == pytest.approx(
        [0, 0, math.sin(math.pi / 12), math.cos(math.pi / 12)]
    )
    assert table["position"] == [0, 5, 0]
    # Where the leg is in the world: 1 along the table's x, which is the world's -z.
    recording = frangible.run(scene, frames=1, threads=1)
    corners = recording.bodies[0].vertices_world(0)
    assert corners[:, 2].min() < -2 and corners[:, 0].max() == pytest.approx(2, abs=1e-6)

    ball = a_prim("Sphere", "ball", "double radius = 0.2", STILL)
    scene, notes = read(stage(a_prim("Xform", "table", ball + top)))
    kinds = [part["kind"] for part in body(scene, "table")["shape"]["parts"]]
    assert kinds == ["hull", "box"]
    assert notes == ["round colliders beside others (/World/table): are their convex hulls"]

    mesh = a_prim("Mesh", "block", BOX_MESH + moved("translate = (0, 2, 0)"), STILL)
    scene, _ = read(stage(a_prim("Xform", "table", "float physics:mass = 50\n" + mesh + top)))
    assert body(scene, "table")["shape"]["kind"] == "mesh"
    assert World.build(scene, 1).masses[0] == pytest.approx(50, rel=0.05)


def test_masses_of_colliders_add_up(read: Any) -> None:
    mass = 'prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMassAPI"]'
    a = a_prim("Cube", "a", "double size = 1\nfloat physics:mass = 3", mass)
    b = a_prim(
        "Cube",
        "b",
        "double size = 1\nfloat physics:density = 7\n" + moved("translate = (3, 0, 0)"),
        mass,
    )
    api = 'prepend apiSchemas = ["PhysicsRigidBodyAPI"]'
    scene, notes = read(stage(a_prim("Xform", "both", a + b, api)))
    assert World.build(scene, 1).masses[0] == pytest.approx(10)
    assert "colliders of several densities in a body" in notes[0]


def test_motion(read: Any) -> None:
    text = a_prim("Cube", "off", "bool physics:rigidBodyEnabled = 0")
    text += a_prim("Cube", "led", "bool physics:kinematicEnabled = 1\ndouble size = 1")
    text += a_prim("Cube", "still", "double size = 1", STILL)
    text += a_prim("Cube", "ghost", "bool physics:collisionEnabled = 0")
    velocity = (
        "vector3f physics:velocity = (1, 2, 3)\nvector3f physics:angularVelocity = (180, 0, 0)"
    )
    inner = a_prim("Cube", "flies", velocity + "\n" + moved("rotateX = 90"))
    text += a_prim("Xform", "turned", inner + moved("rotateY = 90"), "")
    scene, notes = read(stage(text))
    motions = {one["name"]: one.get("motion", "dynamic") for one in scene["bodies"]}
    assert motions == {
        "/World/off": "static",
        "/World/led": "kinematic",
        "/World/still": "static",
        "/World/turned/flies": "dynamic",
    }
    flies = body(scene, "turned/flies")
    # The parent's x is the world's -z.
    assert flies["linear_velocity"] == pytest.approx([3, 2, -1])
    assert flies["angular_velocity"] == pytest.approx([0, 0, -math.pi])
    assert notes == ["rigid body without a collider (/World/ghost): left out"]


def test_bodies_in_bodies(read: Any) -> None:
    inner = a_prim("Cube", "inner", "double size = 1\n" + moved("translate = (2, 0, 0)"))
    free = a_prim(
        "Cube",
        "free",
        "double size = 1\nuniform token[] xformOpOrder = "
        '["!resetXformStack!", "xformOp:translate"]\ndouble3 xformOp:translate = (0, 9, 0)',
    )
    text = a_prim("Cube", "outer", inner + free + moved("translate = (0, 1, 0)"))
    scene, notes = read(stage(text))
    assert [one["name"] for one in scene["bodies"]] == ["/World/outer", "/World/outer/free"]
    assert body(scene, "outer/free")["position"] == [0, 9, 0]
    assert len(body(scene, "outer")["shape"]["parts"]) == 2
    assert notes == ["rigid body in a rigid body (/World/outer/inner): a part of the outer one"]


def test_references_sublayers_and_instances(tmp_path: Path, read: Any) -> None:
    crate = a_prim("Mesh", "crate", BOX_MESH + "float physics:mass = 5")
    (tmp_path / "crate.usda").write_text(f'#usda 1.0\n(\n defaultPrim = "crate"\n)\n{crate}')
    (tmp_path / "floor.usda").write_text(stage(a_prim("Cube", "floor", "double size = 1", STILL)))
    text = "".join(
        f'def "box{i}" (\n instanceable = true\n references = @crate.usda@\n)\n{{\n'
        f"{moved(f'translate = ({3 * i}, 5, 0)')}\n}}\n"
        for i in range(2)
    )
    scene, notes = read(stage(text, more="subLayers = [@floor.usda@]"))
    assert [one["name"] for one in scene["bodies"]] == [
        "/World/floor",
        "/World/box0",
        "/World/box1",
    ]
    assert notes == []
    world = World.build(scene, 1)
    assert world.positions[2] == pytest.approx([3, 5, 0], abs=1e-6)
    assert world.masses[1:] == pytest.approx([5, 5], rel=0.01)


def test_instances_of_an_instancer_are_bodies(read: Any) -> None:
    proto = a_prim("Mesh", "rock", BOX_MESH + moved("scale = (2, 2, 2)"))
    text = (
        'def PointInstancer "rocks"\n{\n'
        "rel prototypes = </World/rocks/protos/rock>\nint[] protoIndices = [0, 0, 0]\n"
        "point3f[] positions = [(0, 0, 0), (5, 0, 0), (0, 5, 0)]\nint64[] invisibleIds = [1]\n"
        f'def Scope "protos"\n{{\n{proto}\n}}\n{moved("translate = (0, 0, 7)")}\n}}\n'
    )
    scene, notes = read(stage(text))
    names = [one["name"] for one in scene["bodies"]]
    assert names == ["/World/rocks/protos/rock[0]", "/World/rocks/protos/rock[2]"]
    assert notes == []
    world = World.build(scene, 1)
    assert world.positions == pytest.approx(np.array([[0, 0, 7], [0, 5, 7]]), abs=1e-6)
    assert world.masses == pytest.approx([8000, 8000], rel=0.02)


def test_frames_and_rate_are_the_stages(read: Any) -> None:
    cube = a_prim("Cube", "a")
    times = "startTimeCode = 10\nendTimeCode = 58\ntimeCodesPerSecond = 48"
    scene, _ = read(stage(cube, more=times))
    assert (scene["frames"], scene["frames_per_second"]) == (48, 48)
    scene, _ = read(stage(cube))
    assert "frames" not in scene and scene["frames_per_second"] == 24
    scene, notes = read(stage(cube, more="startTimeCode = 0\nendTimeCode = 1000000"))
    assert "frames" not in scene
    assert notes == ["length of 1000000 frames (endTimeCode): three seconds instead"]


def test_what_a_scene_cannot_hold_is_named_once(read: Any) -> None:
    text = a_prim("Cube", "a") + a_prim(
        "Cube", "b", 'rel physics:filteredPairs = </World/a>\n' + moved("translate = (5, 0, 0)"),
        BODY.replace("PhysicsMassAPI", "PhysicsFilteredPairsAPI"),
    )  # fmt: skip
    for i in range(3):
        text += f'def PhysicsFixedJoint "joint{i}"\n{{\nrel physics:body0 = </World/a>\n}}\n'
    text += 'def PhysicsFixedJoint "off"\n{\nbool physics:jointEnabled = 0\n}\n'
    text += 'def PhysicsCollisionGroup "group"\n{\n}\n'
    text += a_prim("NurbsPatch", "patch", "", STILL)
    text += a_prim("Cube", "px", "", 'prepend apiSchemas = ["PhysxRigidBodyAPI"]')
    text += 'def DistancePhysicsJoint "odd"\n{\n}\n'
    _, notes = read(stage(text))
    assert notes == [
        "collider of type NurbsPatch (/World/patch): left out",
        "joint (/World/joint0 and 2 more): its bodies move freely",
        "settings of PhysX (/World/px): left out",
        "shape that does not collide (/World/px): left out",
        "type DistancePhysicsJoint, which USD does not know (/World/odd): left out",
    ]


def test_an_animated_kinematic_body(read: Any) -> None:
    path = "double3 xformOp:translate.timeSamples = { 0: (0, 1, 0), 24: (6, 1, 0) }\n"
    path += 'uniform token[] xformOpOrder = ["xformOp:translate"]'
    text = a_prim("Cube", "hammer", f"bool physics:kinematicEnabled = 1\n{path}")
    text += a_prim("Cube", "door", path, STILL)
    scene, notes = read(stage(text, more="startTimeCode = 0\nendTimeCode = 24"))
    still = "animated collider that is no kinematic body (/World/door): stays where it is first"
    assert len(body(scene, "hammer")["path"]) == 25 and notes == [still]
    assert body(scene, "hammer")["position"] == [0, 1, 0]


def test_poses_of_an_animated_body_are_those_of_its_shape() -> None:
    """A cone, whose shape is not placed by its prim's origin, on a turning arm in a z-up stage."""
    from frangible.io.usd_frames import affine, frame_of, rotation_of
    from frangible.io.usd_poses import keyframes
    from pxr import Gf, Usd, UsdGeom

    made = Usd.Stage.CreateInMemory()
    arm = UsdGeom.Xform.Define(made, "/arm")
    turn = arm.AddRotateZOp()
    turn.Set(0.0, 1.0)
    turn.Set(360.0, 41.0)
    cone = UsdGeom.Cone.Define(made, "/arm/cone")
    cone.AddTranslateOp().Set(Gf.Vec3d(200.0, 0.0, 50.0))
    units = affine(0.01 * np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]]), np.zeros(3))
    world = np.array(UsdGeom.Xformable(cone).ComputeLocalToWorldTransform(1.0)) @ units
    own = frame_of(world)
    shape = frame_of(affine(np.eye(3), np.array([0.0, 0.0, -0.5])) @ own.matrix())
    poses = keyframes(cone.GetPrim(), shape, own, units, 1.0, 40)
    assert [pose["frame"] for pose in poses] == list(range(41))
    for pose in poses:
        angle = 2 * math.pi * pose["frame"] / 40
        # In the world, y up: the arm turns about y, from x towards -z.
        middle = [2 * math.cos(angle), 0.5 - 0.5, -2 * math.sin(angle)]
        assert pose["position"] == pytest.approx(middle, abs=1e-9)
        # Of the cone's own axes: z is up, x points outward.
        axes = rotation_of(pose["orientation"])
        assert axes[2] == pytest.approx([0, 1, 0], abs=1e-9)
        assert axes[0] == pytest.approx([math.cos(angle), 0, -math.sin(angle)], abs=1e-9)
    for one, next_one in zip(poses[:-1], poses[1:], strict=True):
        assert np.dot(one["orientation"], next_one["orientation"]) > 0.9


def test_fracture_settings_are_a_schema(read: Any) -> None:
    text = a_prim("Cube", "plain", "", FRACTURE)
    text += a_prim(
        "Cube",
        "all",
        'uniform token frangible:material = "glass"\nuniform token frangible:look = "stone"\n'
        "double frangible:tensileStrength = 3e6\ndouble frangible:youngsModulus = 30e9\n"
        "double frangible:fractureEnergy = 100\n"
        'uniform token frangible:pattern = "voronoi"\nint frangible:pattern:cells = 30\n'
        "int frangible:pattern:seed = 7\ndouble frangible:pattern:clustering = 1.5\n"
        "double3 frangible:pattern:half_extent = (1, 1, 0.5)\n"
        "int frangible:pieces = 40\nint frangible:generations = 2\ndouble frangible:smallest = 0.1",
        FRACTURE,
    )
    text += a_prim("Cube", "weak", "double frangible:strength = 50", FRACTURE)
    text += a_prim(
        "Mesh",
        "fine",
        "int frangible:voxels = 20" + BOX_MESH + moved("scale = (1, 3, 2)"),
        FRACTURE,
    )
    glue = "double frangible:glue:tensileStrength = 2e6\n"
    glued = glue + 'uniform token frangible:pattern = "slices"\nint frangible:pattern:cells = 3'
    text += a_prim("Cube", "glued", glued, FRACTURE)
    glue = glue.replace("2e6", "1e6") + "double frangible:glue:shearStrength = 3e6\n"
    glue += 'uniform token frangible:material = "glass"'
    text += a_prim("Cube", "pane", glue, FRACTURE)
    text += a_prim("Cube", "whole", "bool frangible:breaks = 0", FRACTURE)
    text += a_prim("Cube", "dense", "double size = 1\nfloat physics:density = 2000",
                   FRACTURE.replace('"FrangibleFractureAPI"',
                                    '"FrangibleFractureAPI", "PhysicsMassAPI"'))  # fmt: skip
    scene, notes = read(stage(text))
    assert notes == []
    found = {one["name"].rpartition("/")[2]: one for one in scene["bodies"]}
    assert found["plain"]["material"] == "concrete"
    assert not {"density", "friction", "breaking"} & set(found["plain"])
    assert found["all"]["material"] == "glass" and found["all"]["look"] == "stone"
    assert found["all"]["breaking"] == {
        "strength": {"tensile_strength": 3e6, "youngs_modulus": 3e10, "fracture_energy": 100},
        "pattern": {
            "kind": "voronoi",
            "cells": 30,
            "seed": 7,
            "clustering": 1.5,
            "half_extent": [1, 1, 0.5],
        },
        "pieces": 40,
        "generations": 2,
        "smallest": 0.1,
    }
    assert found["fine"]["shape"]["resolution"] == {"voxels": [1, 20, 1]}
    assert found["glued"]["bonds"] == {
        "pattern": {"kind": "slices", "cells": 3},
        "tensile_strength": 2e6,
        "shear_strength": 2e6,
    }
    assert found["pane"]["bonds"]["pattern"]["kind"] == "radial"
    assert found["pane"]["bonds"]["shear_strength"] == 3e6
    assert found["weak"]["breaking"] == {"strength": 50}
    assert found["whole"]["material"] == {"like": "concrete", "breaks": False}
    assert found["dense"]["density"] == 2000


def test_the_schema_is_registered_for_other_programs() -> None:
    """In a process that has not looked for schemas before."""
    script = """
import json, pathlib
import frangible.io.usd_fracture as fracture
from pxr import Usd
made = Usd.Stage.CreateInMemory()
prim = made.DefinePrim("/a", "Xform")
assert prim.ApplyAPI(fracture.SCHEMA) and prim.HasAPI(fracture.SCHEMA)
assert prim.GetAttribute("frangible:material").Get() == "concrete"
json.loads((pathlib.Path(fracture.FOLDER) / "plugInfo.json").read_text())
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (stage(a_prim("Xform", "a", "", BODY)), ["has no body with a shape", "without a collider"]),
        (stage(a_prim("Cube", "a"), metres=0.0), ["metersPerUnit: 0.0, must be a number > 0"]),
        (
            stage(a_prim("Cube", "a"), more="kilogramsPerUnit = -1"),
            ["kilogramsPerUnit: -1.0, must be a number > 0"],
        ),
        (stage(a_prim("Cube", "a"), more="timeCodesPerSecond = 0"), ["timeCodesPerSecond: 0.0"]),
        (
            stage(a_prim("Mesh", "a", BOX_MESH.replace("0, 1, 3, 2", "0, 1, 3, 99"))),
            ["the faces of /World/a do not fit its points"],
        ),
        (stage(a_prim("Sphere", "a", "double radius = -1")), ["the radius of /World/a: -1.0"]),
        (
            stage(a_prim("Cube", "a", moved("translate = (nan, 1, 1)"))),
            ["the transform of /World/a has a number that is not finite"],
        ),
        (
            stage(a_prim("Cube", "a", moved("scale = (0, 1, 1)"))),
            ["flat convex hull that moves (/World/a): left out"],
        ),
        ("#usda 1.0\nnonsense", [", line 2: ", "must be USD text", "  2 | nonsense"]),
    ],
)
def test_what_is_no_scene_is_named(
    text: str, words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "stage.usda"
    path.write_text(text)
    assert main(["run", str(path), "--quiet"]) == 2
    said = capsys.readouterr().err
    # A line that is quoted comes behind the sentence.
    assert len(said.splitlines()) == 1 + ("  2 | " in said)
    assert said.startswith(f"frangible: {path}") and "Traceback" not in said
    assert [word for word in words if word not in said] == [], said


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (a_prim("Cube", "a", "float physics:mass = 1e38"), ["bodies[0].density: 1.25e37"]),
        (
            a_prim("Cube", "a", "vector3f physics:velocity = (nan, 0, 0)"),
            ["linear_velocity", "NaN"],
        ),
        (
            a_prim("Mesh", "a", BOX_MESH.replace("(.5, .5, .5)", "(nan, 0, 0)")),
            ["stage.usda</World/a>: vertex 7 is (NaN, NaN, NaN)"],
        ),
        (
            a_prim(
                "Mesh",
                "a",
                BOX_MESH.replace("[4, 4, 4, 4, 4, 4]", "[4]").replace(
                    "2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3]", "2]"
                ),
            ),
            ["stage.usda</World/a>: encloses no volume"],
        ),
        (
            a_prim("Cube", "a", 'uniform token frangible:material = "concret"', FRACTURE),
            ["material: \"concret\" (did you mean 'concrete'?)"],
        ),
        (
            a_prim(
                "Cube",
                "a",
                'uniform token frangible:pattern = "voronoi"\nint frangible:pattern:celz = 3',
                FRACTURE,
            ),
            ["breaking.pattern.celz: an unknown field", "did you mean 'cells'?"],
        ),
    ],
)
def test_sentences_about_bodies_of_a_stage_name_them(
    text: str, words: list[str], tmp_path: Path
) -> None:
    path = tmp_path / "stage.usda"
    path.write_text(stage(text))
    with pytest.raises(BuildError) as caught:
        World.build(path, 1)
    said = str(caught.value)
    assert said.startswith("bodies[0]") and '(body "/World/a")' in said and "\n" not in said
    assert [word for word in words if word not in said] == [], said


def test_a_body_that_is_not_there_is_named(tmp_path: Path) -> None:
    path = tmp_path / "stage.usda"
    path.write_text(stage(a_prim("Mesh", "a", BOX_MESH)))
    shape = {"kind": "mesh", "path": f"{path}</World/b>"}
    with pytest.raises(BuildError, match="/World/b is no body with a shape that collides"):
        World.build({"bodies": [{"shape": shape}]}, 1)
    with pytest.raises(BuildError, match="no such file"):
        World.build({"bodies": [{"shape": {"kind": "mesh", "path": "no.usda</a>"}}]}, 1)
