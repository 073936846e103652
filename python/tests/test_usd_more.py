"""What else stages say of bodies: masses of their own, groups that pass through each other,
strength at vertices, and poses between frames."""

import json
import warnings
from pathlib import Path
from typing import Any

import frangible
import numpy as np
import pytest
from frangible import BuildError, World
from frangible.io.reading import FileNote
from frangible.scene_file import save_scene
from frangible.scenes import find_scene, read_scene
from test_usd_scene import BODY, BOX_MESH, FRACTURE, STILL, a_prim, body, moved, read, stage

pytest.importorskip("pxr")

__all__ = ["read"]

OWN_MASS = """
double size = 100
float physics:mass = 7
point3f physics:centerOfMass = (10, 20, 5)
float3 physics:diagonalInertia = (20000, 30000, 40000)
quatf physics:principalAxes = (0.70710678, 0, 0, 0.70710678)
"""
PAIRS = BODY.replace("PhysicsMassAPI", "PhysicsFilteredPairsAPI")


@pytest.mark.parametrize("up", ["Y", "Z"])
def test_a_body_has_the_mass_properties_that_its_stage_says(up: str, read: Any) -> None:
    """In centimetres: the tensor in the world is R diag(I) R^T, whichever frame the shape has."""
    turned = "quatf xformOp:orient = (0.8, 0.6, 0, 0)\n"
    turned += 'uniform token[] xformOpOrder = ["xformOp:orient"]'
    scene, notes = read(stage(a_prim("Cube", "a", OWN_MASS + turned), up, 0.01))
    assert notes == []
    world = World.build(scene, 1)
    assert world.masses[0] == pytest.approx(7)

    from frangible.io.usd_frames import rotation_of

    # Axes of a stage with z up: x stays, z goes up, y comes from the back.
    to_ours = np.eye(3) if up == "Y" else np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    frame = rotation_of([0.6, 0, 0, 0.8]) @ to_ours
    assert world.positions[0] == pytest.approx([0.1, 0.2, 0.05] @ frame, abs=1e-6)
    axes = rotation_of([0, 0, 0.5**0.5, 0.5**0.5]) @ frame
    tensor = axes.T @ np.diag([2.0, 3.0, 4.0]) @ axes
    fields = body(scene, "a")
    for spin in np.eye(3).tolist():
        one = World.build({"bodies": [{**fields, "angular_velocity": spin}]}, 1)
        assert one.energy[0] == pytest.approx(0.5 * np.array(spin) @ tensor @ spin, rel=1e-6)


def test_masses_that_cannot_be_are_named(read: Any) -> None:
    center = "point3f physics:centerOfMass = (0.25, 0, 0)"
    breaks = FRACTURE.replace("PhysicsCollisionAPI", "PhysicsCollisionAPI\", \"PhysicsMassAPI")
    text = a_prim("Sphere", "ball", center)
    text += a_prim("Cube", "thin", "float3 physics:diagonalInertia = (1, 1, 3)" + "\n" + moved(
        "translate = (5, 0, 0)"))  # fmt: skip
    text += a_prim("Cube", "wall", center + "\n" + moved("translate = (9, 0, 0)"), breaks)
    text += a_prim("Cube", "even", "point3f physics:centerOfMass = (0, 0, 0)\n" + moved(
        "translate = (13, 0, 0)"))  # fmt: skip
    scene, notes = read(stage(text))
    assert all("mass_properties" not in one for one in scene["bodies"])
    assert len(notes) == 2
    assert notes[0].startswith("centre of mass of its own (/World/ball and 1 more): follows from")
    assert "at most the sum of the other two" in notes[1] and "/World/thin" in notes[1]


def a_group(name: str, members: list[str], more: str = "") -> str:
    paths = ", ".join(f"</World/{member}>" for member in members)
    included = f"rel collection:colliders:includes = [{paths}]"
    return f'def PhysicsCollisionGroup "{name}"\n{{\n{included}\n{more}\n}}\n'


def passing(scene: dict[str, Any]) -> set[str]:
    """The pairs of bodies that pass through each other, such as ``ab``."""
    found = set()
    for first in scene["bodies"]:
        for second in scene["bodies"]:
            through, groups = first.get("passes_through", []), second.get("groups", [])
            if first is not second and set(through) & set(groups):
                found.add("".join(sorted(one["name"][-1] for one in (first, second))))
    return found


@pytest.mark.parametrize(
    ("groups", "pairs"),
    [
        ([("g", "ab", "rel physics:filteredGroups = </World/g>")], {"ab"}),
        ([("g", "a", "rel physics:filteredGroups = </World/h>"), ("h", "bc", "")], {"ab", "ac"}),
        (
            [
                ("g", "a", "bool physics:invertFilteredGroups = 1\nrel physics:filteredGroups = "
                 "</World/h>"),
                ("h", "b", ""),
                ("i", "c", ""),
            ],
            {"ac"},
        ),
        (
            [
                ("g", "a", 'string physics:mergeGroup = "m"'),
                ("h", "b", 'string physics:mergeGroup = "m"\nrel physics:filteredGroups = '
                 "</World/i>"),
                ("i", "c", ""),
            ],
            {"ac", "bc"},
        ),
        # Nobody is in the other one.
        ([("g", "ab", "rel physics:filteredGroups = </World/h>"), ("h", "", "")], set()),
        ([("g", "a", "rel physics:filteredGroups = </World/nowhere>")], set()),
    ],
)  # fmt: skip
def test_collision_groups_are_groups(
    groups: list[tuple[str, str, str]], pairs: set[str], read: Any
) -> None:
    text = "".join(
        a_prim("Cube", name, moved(f"translate = ({3 * i}, 0, 0)")) for i, name in enumerate("abcd")
    )
    text += "".join(a_group(name, list(members), more) for name, members, more in groups)
    scene, notes = read(stage(text))
    assert passing(scene) == pairs
    World.build(scene, 1)
    assert notes == [
        "filtered group that is not there (/World/g): left out"
        for *_, more in groups
        if "nowhere" in more
    ]


def test_filtered_bodies_fall_through_each_other(tmp_path: Path) -> None:
    """A box falls past a filtered one at rest, by the formula of free fall; another stays on it.
    The same by the scene that was written as a stage."""
    scene = {
        "frames_per_second": 24,
        "bodies": [
            {"name": "slab", "motion": "static", "shape": {"kind": "box", "size": [9, 1, 9]},
             "groups": ["floor"]},
            {"name": "stays", "shape": {"kind": "box", "size": [1, 1, 1]}, "position": [3, 1, 0]},
            {"name": "falls", "shape": {"kind": "box", "size": [1, 1, 1]}, "position": [0, 1, 0],
             "passes_through": ["floor"]},
        ],
    }  # fmt: skip
    path = tmp_path / "scene.usda"
    save_scene(scene, path)
    assert "physics:filteredPairs = </World/slab>" in path.read_text()
    read_back = read_scene(path)
    assert json.dumps(read_back["bodies"]) == json.dumps(scene["bodies"])
    # As other programs read it.
    own = path.read_text().replace("frangible:exact", "nobody:knows")
    (tmp_path / "plain.usda").write_text(own)
    for name in ("scene.usda", "plain.usda"):
        recording = frangible.run(tmp_path / name, frames=24, threads=1)
        heights = {one.name[-5:]: one.positions[-1][1] for one in recording.bodies}
        assert heights["stays"] == pytest.approx(1.0, abs=1e-3)
        assert heights["falls"] == pytest.approx(1.0 - 0.5 * 9.81, abs=1e-6)


def test_pairs_of_bodies_and_of_colliders_do_not_collide(read: Any) -> None:
    arm = a_prim("Cube", "shape", "", STILL)
    text = a_prim("Xform", "a", arm + "rel physics:filteredPairs = </World/b>", PAIRS)
    text += a_prim("Cube", "b", moved("translate = (3, 0, 0)"))
    text += a_prim("Cube", "c", "rel physics:filteredPairs = </World/a/shape>\n" + moved(
        "translate = (6, 0, 0)"), PAIRS)  # fmt: skip
    scene, notes = read(stage(text))
    assert notes == [] and passing(scene) == {"ab", "ac"}


def test_strengths_at_vertices_are_strength_points(read: Any) -> None:
    values = "float[] primvars:strength = [1, 2, 3, 4, 5, 6, 7, 1e9] ( interpolation = \"vertex\" )"
    text = a_prim("Mesh", "a", f"{BOX_MESH}\n{values}", FRACTURE)
    scene, notes = read(stage(text, "Z", 2.0))
    assert notes == []
    fields = body(scene, "a")
    points = fields["breaking"]["strength_points"]
    assert [point["factor"] for point in points] == [1, 2, 3, 4, 5, 6, 7, 1e6]
    assert points[4]["point"] == [1, -1, -1] and fields["material"] == "concrete"
    # One number for all, on a glued body; and what has no place in a scene.
    glue = "double frangible:glue:tensileStrength = 1e6\n"
    one = 'float[] primvars:strength = [0.5] ( interpolation = "constant" )'
    text = a_prim("Mesh", "a", f"{BOX_MESH}\n{glue}\n{one}", FRACTURE)
    faces = values.replace("vertex", "faceVarying")
    text += a_prim("Mesh", "b", f"{BOX_MESH}\n{faces}\n" + moved("translate = (5, 0, 0)"), FRACTURE)
    text += a_prim("Mesh", "c", f"{BOX_MESH}\n{values}\n" + moved("translate = (9, 0, 0)"))
    scene, notes = read(stage(text))
    points = body(scene, "a")["bonds"]["strength_points"]
    assert points == [{"point": [0, 0, 0], "factor": 0.5}]
    assert notes == [
        "strength of vertices of a body that does not break (/World/c): left out",
        "strength that is no number for each vertex (/World/b): left out",
    ]


def test_dense_meshes_have_means_of_their_strengths() -> None:
    from frangible.io.usd_strength import MOST_POINTS, _gathered

    places = np.random.default_rng(3).random((50_000, 3))
    means, factors = _gathered(places, places[:, 0] + 1.0)
    assert MOST_POINTS / 8 < len(means) <= MOST_POINTS
    assert factors == pytest.approx(means[:, 0] + 1.0)


def test_strength_points_are_said_with_the_schema(tmp_path: Path) -> None:
    points = [
        {"point": [0.1, 0.2, 1 / 3], "factor": 0.1},
        {"point": [0.0, 0.0, 0.0], "factor": 2.0},
    ]
    breaking = {"strength": 5.0, "pattern": {"kind": "voronoi"}, "strength_points": points}
    box = {"kind": "box", "size": [1, 1, 1]}
    scene = {"bodies": [{"name": "b", "shape": box, "breaking": breaking}]}
    path = tmp_path / "scene.usda"
    save_scene(scene, path)
    text = path.read_text()
    assert "point3d[] frangible:strengthPoints" in text
    path.write_text(text.replace("frangible:exact", "nobody:knows"))
    assert read_scene(path)["bodies"][0]["breaking"]["strength_points"] == points


HAMMER = """
bool physics:kinematicEnabled = 1
double3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 4.25: (4, 0, 0), 10: (4, 0, 0) }
uniform token[] xformOpOrder = ["xformOp:translate"]
"""


def test_poses_between_frames_are_the_stages_own(tmp_path: Path, read: Any) -> None:
    times = "startTimeCode = 0\nendTimeCode = 10\ntimeCodesPerSecond = 24"
    text = stage(a_prim("Cube", "a", HAMMER), more=times)
    scene, notes = read(text)
    frames = [key["frame"] for key in body(scene, "a")["path"]]
    assert notes == [] and frames == [0, 1, 2, 3, 4, 4.25, 5, 6, 7, 8, 9, 10]
    # With four frames for each of the stage's it stops exactly where it does.
    path = tmp_path / "hammer.usda"
    path.write_text(text)
    fine, frames_fine, _ = find_scene(path, fps=96)
    world = World.build(fine, 1)
    assert frames_fine == 40
    for frame in range(1, 25):
        world.step()
        exact = 4 * min(1.0, frame / 4 / 4.25)
        assert world.positions[0].tolist() == pytest.approx([exact, 0, 0], abs=1e-12)


def test_another_rate_keeps_the_times_of_a_scene() -> None:
    box = {"kind": "box", "size": [1, 1, 1]}
    scene = {
        "frames_per_second": 24,
        "frames": 48,
        "bodies": [
            {"shape": box, "motion": "kinematic", "path": [{"frame": 12, "position": [0, 0, 0]}]},
            {"shape": box, "starts": {"frame": 20}},
        ],
    }
    found, frames, _ = find_scene(scene, fps=60)
    assert frames == found["frames"] == 120 and found["frames_per_second"] == 60
    assert found["bodies"][0]["path"][0]["frame"] == 30
    assert found["bodies"][1]["starts"]["frame"] == 50
    assert scene["bodies"][1]["starts"] == {"frame": 20}


def test_a_syntax_error_quotes_its_line(tmp_path: Path) -> None:
    path = tmp_path / "bad.usda"
    path.write_text(stage(a_prim("Cube", "a", "double size = = 2")))
    with pytest.raises(BuildError) as error:
        read_scene(path)
    number = path.read_text().splitlines().index("double size = = 2") + 1
    first, second = str(error.value).splitlines()
    assert first.startswith(f"{path}, line {number}: ") and first.endswith("must be USD text")
    assert second == f"  {number} | double size = = 2"


def test_all_of_it_comes_back_without_loss(tmp_path: Path) -> None:
    own = {"mass": 7.5, "center": [0.1, 0, 1 / 3], "moments": [2, 3, 4], "axes": [0.1, 0.2, 0, 1]}
    shapes = [
        {"kind": "box", "size": [1, 2, 1 / 3]},
        {"kind": "hull", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]},
    ]
    bodies = [
        {"name": kind, "shape": shape, "position": [5 * i, 0, 0], "mass_properties": own}
        for i, (kind, shape) in enumerate(zip("ab", shapes, strict=True))
    ]
    cone = {"kind": "cone", "radius": 0.5, "height": 1.0}
    whole = {"mass": 2.0, "moments": [1, 0.5, 1], "center": [0, 0, 0]}
    bodies += [
        {"name": "c", "shape": cone, "position": [20, 0, 0], "mass_properties": whole},
        {"name": "d", "shape": shapes[0], "position": [30, 0, 0], "groups": ["x"],
         "passes_through": ["x"]},
    ]  # fmt: skip
    path = tmp_path / "scene.usda"
    save_scene({"bodies": bodies}, path)
    with warnings.catch_warnings():
        warnings.simplefilter("error", FileNote)
        assert json.dumps(read_scene(path)["bodies"]) == json.dumps(bodies)
    # Other programs find the same masses.
    path.write_text(path.read_text().replace("frangible:exact", "nobody:knows"))
    with warnings.catch_warnings():
        warnings.simplefilter("error", FileNote)
        back = read_scene(path)
    exact, found = World.build({"bodies": bodies}, 1), World.build(back, 1)
    assert found.masses == pytest.approx(exact.masses)
    assert found.positions == pytest.approx(exact.positions, abs=1e-6)


def test_shapes_below_a_collider_that_is_none_collide(read: Any) -> None:
    """A Scope with the schema, as in stages of Omniverse: all shapes below it, where none of them
    says so itself; in a body they are the body's."""
    shapes = a_prim("Cube", "a", moved("translate = (3, 0, 0)"), "")
    shapes += a_prim("Xform", "x", a_prim("Sphere", "b", moved("translate = (6, 0, 0)"), ""), "")
    off = "bool physics:collisionEnabled = 0\n"
    text = a_prim("Scope", "floor", shapes, STILL)
    text += a_prim("Scope", "air", off + a_prim("Cube", "c", "", ""), STILL)
    text += a_prim("Xform", "body", a_prim("Xform", "shapes", shapes, STILL), BODY.replace(
        ', "PhysicsCollisionAPI"', ""))  # fmt: skip
    text += a_prim("Scope", "nothing", "", STILL)
    scene, notes = read(stage(text))
    names = [one["name"].removeprefix("/World/") for one in scene["bodies"]]
    assert names == ["floor/a", "floor/x/b", "body"]
    assert len(body(scene, "body")["shape"]["parts"]) == 2
    assert notes == [
        "collider that is no shape (/World/nothing): left out",
        "round colliders beside others (/World/body): are their convex hulls",
        "shape that does not collide (/World/air/c): left out",
    ]


def test_a_pointer_of_git_lfs_is_named(tmp_path: Path) -> None:
    path = tmp_path / "set.usda"
    path.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 3320\n")
    with pytest.raises(BuildError, match="is a pointer of Git LFS, must be the file"):
        find_scene(path)


def test_bodies_of_a_joint_do_not_collide(read: Any) -> None:
    """But where it says that they do, or is switched off, or leads to the world."""
    text = "".join(
        a_prim("Cube", name, moved(f"translate = ({3 * i}, 0, 0)")) for i, name in enumerate("abcd")
    )
    for first, second, more in (
        ("a", "b", ""),
        ("b", "c", "bool physics:collisionEnabled = 1"),
        ("c", "d", "bool physics:jointEnabled = 0"),
    ):
        ends = f"rel physics:body0 = </World/{first}>\nrel physics:body1 = </World/{second}>"
        text += f'def PhysicsRevoluteJoint "{first}{second}"\n{{\n{ends}\n{more}\n}}\n'
    text += 'def PhysicsFixedJoint "to_world"\n{\nrel physics:body1 = </World/d>\n}\n'
    scene, notes = read(stage(text))
    assert passing(scene) == {"ab"}
    assert notes == ["joint (/World/ab and 2 more): its bodies move freely"]
