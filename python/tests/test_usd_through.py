"""A UsdPhysics stage through a simulation: what it says is still there in the cache."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from frangible import Recording
from frangible.cli import main
from test_usd import violations

pytest.importorskip("pxr")

#: A wall of two metres with a material and texture coordinates, and a ball, in centimetres, z up.
STAGE = """#usda 1.0
(
    defaultPrim = "Set"
    metersPerUnit = 0.01
    upAxis = "Z"
    startTimeCode = 1001
    endTimeCode = 1013
    timeCodesPerSecond = 24
)
def Xform "Set"
{
    def PhysicsScene "Physics"
    {
    }
    def Scope "Looks"
    {
        def Material "Plaster"
        {
            token outputs:surface.connect = </Set/Looks/Plaster/s.outputs:surface>
            def Shader "s"
            {
                uniform token info:id = "UsdPreviewSurface"
                color3f inputs:diffuseColor = (0.25, 0.5, 0.75)
                token outputs:surface
            }
        }
    }
    def Plane "Floor" (
        prepend apiSchemas = ["PhysicsCollisionAPI"]
    )
    {
        uniform token axis = "Z"
    }
    def Xform "Ruin"
    {
        double3 xformOp:translate = (0, 50, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        def Mesh "Wall" (
            prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI",
                                  "FrangibleFractureAPI", "MaterialBindingAPI"]
        )
        {
            uniform token frangible:material = "concrete"
            uniform token frangible:pattern = "voronoi"
            int frangible:pattern:cells = 30
            double frangible:strength = 2500
            rel material:binding = </Set/Looks/Plaster>
            uniform token subdivisionScheme = "none"
            int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]
            int[] faceVertexIndices = [0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4,
                                       1, 5, 7, 3]
            point3f[] points = [(-1, -1, -1), (-1, -1, 1), (-1, 1, -1), (-1, 1, 1),
                                (1, -1, -1), (1, -1, 1), (1, 1, -1), (1, 1, 1)]
            texCoord2f[] primvars:st = [(0, 0), (0, 1), (0, 0), (0, 1), (1, 0), (1, 1), (1, 0),
                                        (1, 1)] (
                interpolation = "vertex"
            )
            double3 xformOp:translate = (0, 0, 100)
            float3 xformOp:scale = (100, 15, 100)
            uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]
        }
    }
    def Cylinder "Post" (
        prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "MaterialBindingAPI"]
    )
    {
        rel material:binding = </Set/Looks/Plaster>
        double radius = 10
        double height = 100
        double3 xformOp:translate = (500, 0, 50)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Sphere "Ball" (
        prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMassAPI"]
    )
    {
        double radius = 20
        color3f[] primvars:displayColor = [(1, 0.25, 0)]
        float physics:mass = 250
        vector3f physics:velocity = (0, 1500, 0)
        double3 xformOp:translate = (0, -200, 100)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
"""


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("through")
    source = folder / "set.usda"
    source.write_text(STAGE)
    outputs = [folder / "out.usda", folder / "out.npz"]
    arguments = [word for path in outputs for word in ("--out", str(path))]
    assert main(["run", str(source), "--quiet", "--threads", "1", *arguments]) == 0
    return folder


def opened(path: Path) -> Any:
    from pxr import Usd

    return Usd.Stage.Open(str(path))


def test_the_stage_leaves_as_it_came(written: Path) -> None:
    from pxr import UsdGeom

    stage = opened(written / "out.usda")
    assert violations(stage) == []
    assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.01
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (1001, 1013)
    assert stage.GetTimeCodesPerSecond() == 24
    assert stage.GetDefaultPrim().GetPath() == "/Set"

    # Everything is where it was, in the stage's own unit and axes.
    for path, source in (("/Set/Ruin/Wall", "/Set/Ruin/Wall"), ("/Set/Post", "/Set/Post")):
        boxes = []
        for one, prim, time in (
            (stage, path, 1001.0),
            (opened(written / "set.usda"), source, 1001.0),
        ):
            cache = UsdGeom.BBoxCache(time, [UsdGeom.Tokens.default_])
            box = cache.ComputeWorldBound(one.GetPrimAtPath(prim)).ComputeAlignedRange()
            boxes.append(np.array([box.GetMin(), box.GetMax()]))
        # What is sampled is a little larger.
        assert boxes[0] == pytest.approx(boxes[1], abs=2.0), path


def test_paths_materials_and_texture_coordinates_live_on(written: Path) -> None:
    from pxr import UsdGeom, UsdShade

    stage = opened(written / "out.usda")
    pieces = [
        prim
        for prim in stage.GetPrimAtPath("/Set/Ruin/Wall").GetChildren()
        if prim.IsA(UsdGeom.Mesh)
    ]
    assert len(pieces) > 5
    names: set[str] = set()
    for piece in pieces:
        for prim in [piece, *piece.GetChildren()]:
            bound = UsdShade.MaterialBindingAPI(prim).GetDirectBinding().GetMaterial()
            if bound:
                names.add(bound.GetPrim().GetName())
    assert "Plaster" in names and any("inside" in name for name in names)
    plaster = next(prim for prim in stage.Traverse() if prim.GetName() == "Plaster")
    surface = UsdShade.Material(plaster).ComputeSurfaceSource()[0]
    assert tuple(surface.GetInput("diffuseColor").Get()) == (0.25, 0.5, 0.75)

    # On the faces of the wall, u and v are its x and z in metres.
    recording = Recording.load(written / "out.npz")
    wall = next(body for body in recording.bodies if body.name == "/Set/Ruin/Wall")
    corners = wall.vertices_world(0)[wall.triangles]
    front = np.abs(np.ptp(corners[:, :, 2], axis=1)) < 1e-6
    assert front.any()
    expected = np.stack([corners[..., 0] + 1.0, corners[..., 1]], axis=-1)[front] / 2.0
    assert wall.coordinates[front] == pytest.approx(expected, abs=0.02)


def test_gltf_has_the_last_names(written: Path) -> None:
    recording = Recording.load(written / "out.npz")
    recording.save(written / "out.glb")
    content = (written / "out.glb").read_bytes()
    assert b'"Wall"' in content and b'"Ball"' in content and b"Set_Ruin" not in content


def test_shapes_that_are_no_meshes_look_as_they_did(written: Path) -> None:
    from pxr import UsdGeom, UsdShade

    stage = opened(written / "out.usda")
    (post,) = stage.GetPrimAtPath("/Set/Post").GetChildren()
    bound = UsdShade.MaterialBindingAPI(post).ComputeBoundMaterial()[0]
    assert bound.GetPrim().GetName() == "Plaster"
    (ball,) = stage.GetPrimAtPath("/Set/Ball").GetChildren()
    colours = np.array(UsdGeom.Mesh(ball).GetDisplayColorAttr().Get())
    assert colours == pytest.approx(np.broadcast_to([1, 0.25, 0], colours.shape), abs=0.01)


def test_a_stage_is_opened_a_few_times_however_many_bodies_it_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was once for each body: minutes for some thousand."""
    from pxr import Usd

    begin = STAGE.index("    def Cylinder")
    post = STAGE[begin : STAGE.index("    def Sphere")]
    posts = "".join(
        post.replace('"Post"', f'"Post{i}"').replace("(500, 0, 50)", f"({500 + 50 * i}, 0, 50)")
        for i in range(40)
    )
    path = tmp_path / "posts.usda"
    path.write_text(STAGE.replace(post, posts))
    opened_paths = []
    open_once = Usd.Stage.Open

    def counted(name: str) -> Any:
        opened_paths.append(name)
        return open_once(name)

    monkeypatch.setattr(Usd.Stage, "Open", staticmethod(counted))
    out = tmp_path / "out.npz"
    assert main(["run", str(path), "--frames", "1", "--quiet", "--out", str(out)]) == 0
    looks = [body.skin for body in Recording.load(out).bodies if "Post" in body.name]
    assert len(looks) == 40 and all(skin is not None for skin in looks)
    assert len(opened_paths) < 8


def test_the_ball_arrives_when_it_should(written: Path) -> None:
    """1.5 m before it touches, at 15 m/s."""
    recording = Recording.load(written / "out.npz")
    assert recording.convention.up_axis == "z" and recording.convention.first_frame == 1001
    broken = [report["frame"] for report in recording.reports if report["fractures"]]
    gap = (200 + 50 - 15 - 20) / 100
    assert broken[0] == int(np.ceil(gap / 15 * 24))
    assert {body.look for body in recording.bodies if body.parent is not None} == {"concrete"}


def test_a_mesh_in_centimetres_leaves_as_it_came(tmp_path: Path) -> None:
    from pxr import UsdGeom

    path = tmp_path / "block.obj"
    path.write_text(
        "v 0 0 0\nv 100 0 0\nv 0 100 0\nv 0 0 100\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    )
    out = tmp_path / "out.usda"
    wishes = ["--unit", "cm", "--up", "z", "--ground", "--frames", "1", "--quiet"]
    assert main(["run", str(path), *wishes, "--out", str(out)]) == 0
    stage = opened(out)
    assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z
    (prim,) = stage.GetPrimAtPath("/World/block").GetChildren()
    mesh = UsdGeom.Mesh(prim)
    matrix = np.array(mesh.ComputeLocalToWorldTransform(0.0))
    points = np.array(mesh.GetPointsAttr().Get()) @ matrix[:3, :3] + matrix[3, :3]
    assert points.min(axis=0) == pytest.approx([0, 0, 0], abs=2)
    assert points.max(axis=0) == pytest.approx([100, 100, 100], abs=4)


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"up_axis": "x", "metres": 1, "first_frame": 0}']
)
def test_a_damaged_convention_is_named(
    text: str, written: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with np.load(written / "out.npz") as arrays:
        damaged = {**arrays, "convention": np.array(text)}
    np.savez(tmp_path / "bad.npz", **damaged)
    assert main(["info", str(tmp_path / "bad.npz")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "is not a readable .npz cache" in line


#: A hammer in centimetres, z up, that stands for five frames, reaches a wall of glass after five
#: more, and goes on through it.
HAMMER = """#usda 1.0
(
    metersPerUnit = 0.01
    upAxis = "Z"
    startTimeCode = 1
    endTimeCode = 15
    timeCodesPerSecond = 24
)
def PhysicsScene "Physics"
{
    float physics:gravityMagnitude = 0
}
def Cube "Hammer" (
    prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]
)
{
    double size = 20
    bool physics:kinematicEnabled = 1
    double3 xformOp:translate.timeSamples = { 6: (-100, 0, 100), 16: (100, 0, 100) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Cube "Pane" (
    prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "FrangibleFractureAPI"]
)
{
    uniform token frangible:material = "glass"
    uniform token frangible:pattern = "voronoi"
    int frangible:pattern:cells = 12
    double size = 1
    float3 xformOp:scale = (2, 150, 150)
    double3 xformOp:translate = (16, 0, 100)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]
}
"""


def test_an_animated_hammer_breaks_a_pane_in_the_frame_of_its_arrival(tmp_path: Path) -> None:
    path = tmp_path / "hammer.usda"
    path.write_text(HAMMER)
    out = tmp_path / "out.npz"
    assert main(["run", str(path), "--quiet", "--out", str(out)]) == 0
    recording = Recording.load(out)
    # It moves by 20 cm in a frame from code 6 on: its front is at
    # 10 cm after 10 frames, and that of the pane is at 15 cm.
    broken = [report["frame"] for report in recording.reports if report["fractures"]]
    assert broken[0] == 11, broken
    hammer = next(body for body in recording.bodies if body.name == "/Hammer")
    ways = [hammer.pose(frame)[0][0] for frame in (0, 5, 10, 14)]
    assert ways == pytest.approx([-1.0, -1.0, 0.0, 0.8], abs=1e-12)
    assert len(recording.alive(14)) > 5
