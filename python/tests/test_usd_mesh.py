"""Meshes and drawn patterns in USD files."""

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from frangible import BuildError, Pattern, break_mesh, mesh_info, run
from frangible.cli import main
from frangible.io.mesh_files import readable_mesh
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

#: A cube of edge 2 around the origin, its faces counter-clockwise from outside.
CORNERS = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
FACES = [0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3]


def cube(stage: Any, path: str) -> Any:
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(CORNERS)
    mesh.CreateFaceVertexCountsAttr([4] * 6)
    mesh.CreateFaceVertexIndicesAttr(FACES)
    return mesh


@pytest.fixture
def saved(tmp_path: Path) -> Callable[[Callable[[Any], None], str], str]:
    def save(fill: Callable[[Any], None], name: str = "drawn.usda") -> str:
        stage = Usd.Stage.CreateNew(str(tmp_path / name))
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
        UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        fill(stage)
        stage.Save()
        return str(tmp_path / name)

    return save


def info(path: str) -> dict[str, Any]:
    with readable_mesh(path) as file:
        return mesh_info(file)


@pytest.mark.parametrize("ending", ["usd", "usda", "usdc"])
def test_units_axes_and_transforms_are_applied(saved: Any, ending: str) -> None:
    def fill(stage: Any) -> None:
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        UsdGeom.SetStageMetersPerUnit(stage, 0.01)
        UsdGeom.Xform.Define(stage, "/Rig").AddTranslateOp().Set(Gf.Vec3d(0, 300, 500))
        cube(stage, "/Rig/Cube").AddScaleOp().Set(Gf.Vec3f(100, 50, 25))

    facts = info(saved(fill, f"drawn.{ending}"))
    assert facts["volume_m3"] == pytest.approx(2.0 * 1.0 * 0.5)
    # What was up, along z, is up along y; what was in front, along y, is at -z.
    assert facts["center_m"] == pytest.approx([0.0, 5.0, -3.0])
    assert (facts["low_m"], facts["high_m"]) == (
        pytest.approx([-1, 4.75, -3.5]),
        pytest.approx([1, 5.25, -2.5]),
    )


def test_what_is_mirrored_or_left_handed_is_turned_right_side_out(saved: Any) -> None:
    def fill(stage: Any) -> None:
        cube(stage, "/Mirrored").AddScaleOp().Set(Gf.Vec3f(-1, 1, 1))
        left = cube(stage, "/Left")
        left.CreateFaceVertexIndicesAttr(np.array(FACES).reshape(-1, 4)[:, ::-1].ravel().tolist())
        left.CreateOrientationAttr(UsdGeom.Tokens.leftHanded)
        left.AddTranslateOp().Set(Gf.Vec3d(5, 0, 0))

    assert info(saved(fill))["volume_m3"] == pytest.approx(16.0)


def test_instances_count_and_what_is_not_seen_does_not(saved: Any) -> None:
    def fill(stage: Any) -> None:
        cube(stage, "/Model/Cube")
        for at in range(2):
            copy = UsdGeom.Xform.Define(stage, f"/Copy{at}")
            copy.AddTranslateOp().Set(Gf.Vec3d(4 * at + 4, 0, 0))
            copy.GetPrim().GetReferences().AddInternalReference("/Model")
            copy.GetPrim().SetInstanceable(True)
        UsdGeom.Imageable(cube(stage, "/Hidden")).MakeInvisible()
        cube(stage, "/Guide").CreatePurposeAttr(UsdGeom.Tokens.guide)

    assert info(saved(fill))["volume_m3"] == pytest.approx(3 * 8.0)


@pytest.mark.parametrize("ending", ["usda", "usdc"])
def test_a_mesh_in_usd_is_simulated(
    saved: Any, capsys: pytest.CaptureFixture[str], ending: str
) -> None:
    path = saved(lambda stage: cube(stage, "/Cube") and None, f"drawn.{ending}")
    assert main(["run", "impact", "--mesh", path, "--frames", "1", "--threads", "1", "--json"]) == 0
    assert '"frames": 1' in capsys.readouterr().out
    recording = run("impact", mesh=path, frames=1, threads=1)
    assert "mesh" in [body.name for body in recording.bodies]


@pytest.mark.parametrize("lost", [None, 3])
def test_a_pattern_is_drawn_in_usd(
    saved: Any, capsys: pytest.CaptureFixture[str], lost: int | None
) -> None:
    pattern = Pattern.named("voronoi", cells=8)

    def fill(stage: Any) -> None:
        for cell in set(range(8)) - {lost}:
            vertices, triangles = pattern.region_mesh(cell)
            mesh = UsdGeom.Mesh.Define(stage, f"/Cell{cell}")
            mesh.CreatePointsAttr(vertices.astype(np.float32))
            mesh.CreateFaceVertexCountsAttr([3] * len(triangles))
            mesh.CreateFaceVertexIndicesAttr(triangles.ravel().astype(int).tolist())

    path = saved(fill)
    if lost is None:
        assert main(["pattern", path]) == 0
        assert re.search(r"^cells +8$", capsys.readouterr().out, re.MULTILINE)
    else:
        assert main(["pattern", path]) == 2
        assert (
            f"{path}: a gap of 0.78 m^3 (9.8 % of the box) around (-0.7236, 0.086, 0.5948)"
            in capsys.readouterr().err
        )


def test_a_mesh_in_usd_breaks_and_is_described(
    saved: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = saved(lambda stage: cube(stage, "/Cube") and None)
    pieces = break_mesh(path, Pattern.named("voronoi", cells=6))
    assert pieces.name == "drawn" and len(pieces.pieces) > 2
    assert (
        main(
            [
                "break",
                path,
                "--pattern",
                "slices",
                "--cells",
                "4",
                "--exact",
                "--out",
                str(tmp_path / "pieces.usdc"),
            ]
        )
        == 0
    )
    capsys.readouterr()
    assert main(["info", path]) == 0
    assert re.search(r"^volume_m3 +8$", capsys.readouterr().out, re.MULTILINE)


@pytest.mark.parametrize(
    ("fill", "sentence"),
    [
        (lambda stage: UsdGeom.Xform.Define(stage, "/Empty"), "has no mesh that can be seen"),
        (
            lambda stage: cube(stage, "/Cube").CreateFaceVertexIndicesAttr([0, 1, 99]),
            "the faces of /Cube do not fit its points",
        ),
        (
            lambda stage: cube(stage, "/Cube").CreatePointsAttr([(0, 0, float("inf"))] * 8),
            "coordinates must be finite",
        ),
    ],
)
def test_a_bad_mesh_gets_a_sentence_with_its_path(
    saved: Any, fill: Callable[[Any], Any], sentence: str
) -> None:
    path = saved(lambda stage: fill(stage) and None)
    with pytest.raises(BuildError, match=sentence) as error:
        info(path)
    assert str(error.value).startswith(f"{path}: ")


#: Each kind of shape that is a formula, with its attributes, its volume, and its size along x, y
#: and z.
SHAPES = {
    "cube": (UsdGeom.Cube, {"size": 3.0}, 27.0, (3, 3, 3)),
    "ball": (UsdGeom.Sphere, {"radius": 0.5}, math.pi / 6, (1, 1, 1)),
    "cylinder along x": (
        UsdGeom.Cylinder,
        {"radius": 1.0, "height": 4.0, "axis": "X"},
        4 * math.pi,
        (4, 2, 2),
    ),
    "cylinder": (UsdGeom.Cylinder, {}, 2 * math.pi, (2, 2, 2)),
    "cone along y": (UsdGeom.Cone, {"radius": 1.0, "height": 3.0, "axis": "Y"}, math.pi, (2, 3, 2)),
    "capsule along x": (
        UsdGeom.Capsule,
        {"radius": 0.5, "height": 2.0, "axis": "X"},
        2 * math.pi / 3,
        (3, 1, 1),
    ),
    "a long capsule": (
        UsdGeom.Capsule,
        {"radius": 0.5, "height": 90.0},
        math.pi * (22.5 + 1 / 6),
        (1, 1, 91),
    ),
}


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_are_meshes_of_their_volume_and_size(saved: Any, name: str) -> None:
    kind, attributes, volume, size = SHAPES[name]

    def fill(stage: Any) -> None:
        shape = kind.Define(stage, "/Shape")
        for key, value in attributes.items():
            shape.GetPrim().GetAttribute(key).Set(value)
        shape.AddTranslateOp().Set(Gf.Vec3d(7, -3, 2))
        shape.AddScaleOp().Set(Gf.Vec3f(-2, 2, 2))
        # Only meshes may be left-handed.
        shape.CreateOrientationAttr(UsdGeom.Tokens.leftHanded)

    facts = info(saved(fill))
    assert facts["watertight"] and facts["volume_m3"] == pytest.approx(8 * volume, rel=1e-9)
    assert facts["center_m"][:2] == pytest.approx([7, -3]) or "cone" in name
    assert np.subtract(facts["high_m"], facts["low_m"]) == pytest.approx(
        2 * np.array(size), abs=2e-3 * min(size)
    )


def test_the_tip_of_a_cone_and_the_ends_of_a_capsule_are_where_they_should_be(saved: Any) -> None:
    cone = info(saved(lambda stage: UsdGeom.Cone.Define(stage, "/Cone") and None))
    # Its centre is a quarter of its height above its base.
    assert cone["center_m"] == pytest.approx([0, 0, -0.5])

    def fill(stage: Any) -> None:
        shape = stage.DefinePrim("/Shape", "Capsule_1")
        for key, value in (("radiusTop", 1.0), ("radiusBottom", 0.5), ("height", 2.0)):
            shape.GetAttribute(key).Set(value)

    capsule = info(saved(fill))
    assert (capsule["low_m"][2], capsule["high_m"][2]) == pytest.approx((-1.5, 2.0))


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_a_shape_without_a_size_is_refused(saved: Any, value: float) -> None:
    path = saved(
        lambda stage: UsdGeom.Sphere.Define(stage, "/Ball").CreateRadiusAttr(value) and None
    )
    with pytest.raises(BuildError, match=f"the radius of /Ball: {value}, must be a number > 0"):
        info(path)


def instancer(
    stage: Any, path: str, prototypes: list[str], indices: list[int], positions: list[Any]
) -> Any:
    made = UsdGeom.PointInstancer.Define(stage, path)
    made.CreatePrototypesRel().SetTargets(prototypes)
    made.CreateProtoIndicesAttr(indices)
    made.CreatePositionsAttr(positions)
    return made


def test_instances_of_an_instancer_are_moved_turned_scaled_and_hidden(saved: Any) -> None:
    def fill(stage: Any) -> None:
        UsdGeom.Xform.Define(stage, "/World").AddTranslateOp().Set(Gf.Vec3d(100, 0, 0))
        made = instancer(
            stage,
            "/World/Many",
            ["/World/Many/Proto"],
            [0, 0, 0],
            [(0, 0, 0), (10, 0, 0), (20, 0, 0)],
        )
        made.CreateOrientationsAttr(
            [Gf.Quath(1, 0, 0, 0), Gf.Quath(0.7071, 0, 0, 0.7071), Gf.Quath(1, 0, 0, 0)]
        )
        made.CreateScalesAttr([(1, 1, 1), (3, 1, 1), (1, 1, 1)])
        made.CreateIdsAttr([11, 12, 13])
        made.CreateInvisibleIdsAttr([13])
        cube(stage, "/World/Many/Proto").AddTranslateOp().Set(Gf.Vec3d(2, 0, 0))

    facts = info(saved(fill))
    assert facts["parts"] == 2 and facts["volume_m3"] == pytest.approx(8.0 + 24.0, rel=1e-3)
    # The second is three times as far from its point as the first, and as long, and turned from x
    # to y.
    assert facts["low_m"] == pytest.approx([101, -1, -1], abs=1e-2)
    assert facts["high_m"] == pytest.approx([111, 9, 1], abs=1e-2)


def test_instancers_of_instancers_and_of_prototypes_that_are_not_drawn(saved: Any) -> None:
    def fill(stage: Any) -> None:
        inner = instancer(
            stage,
            "/Outer/Inner",
            ["/Drawer/Cube", "/Outer/Inner/Ball"],
            [0, 1],
            [(0, 0, 0), (0, 5, 0)],
        )
        UsdGeom.Sphere.Define(stage, "/Outer/Inner/Ball")
        instancer(
            stage, "/Outer", [str(inner.GetPath())], [0, 0, 0], [(0, 0, 0), (9, 0, 0), (0, 0, 9)]
        )
        # A prim that is only `over` is a prototype, and nothing by itself.
        cube(stage, "/Drawer/Cube")
        stage.GetPrimAtPath("/Drawer").SetSpecifier(Sdf.SpecifierOver)

    facts = info(saved(fill))
    assert facts["parts"] == 6 and facts["volume_m3"] == pytest.approx(3 * (8 + 4 / 3 * math.pi))


def test_instances_that_do_not_fit_are_refused(saved: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def fill(stage: Any, indices: list[int]) -> None:
        instancer(stage, "/Many", ["/Many/Proto"], indices, [(0, 0, 0), (3, 0, 0)])
        cube(stage, "/Many/Proto")

    for indices in ([0, 1], [0, -1], [0]):
        with pytest.raises(BuildError, match="the instances of /Many do not fit its prototypes"):
            info(
                saved(
                    lambda stage, indices=indices: fill(stage, indices),
                    f"{len(str(indices))}{indices[-1]}.usda",
                )
            )

    def within_itself(stage: Any) -> None:
        instancer(stage, "/A", ["/A/B"], [0], [(0, 0, 0)])
        instancer(stage, "/A/B", ["/A"], [0], [(0, 0, 0)])

    with pytest.raises(BuildError, match="/A/B is an instance of itself"):
        info(saved(within_itself, "self.usda"))

    def crowd(stage: Any) -> None:
        lower = cube(stage, "/Cube").GetPath()
        for level in range(9):
            lower = instancer(
                stage, f"/Level{level}", [str(lower)], [0] * 10, [(0, 0, 0)] * 10
            ).GetPath()

    for limit, most, what in (
        ("MOST_PARTS", 2000, "meshes"),
        ("MOST_TRIANGLES", 20000, "triangles"),
    ):
        monkeypatch.setattr(f"frangible.io.usd_mesh.{limit}", most)
        sentence = f"has [0-9]+ {what} or more, each instance counted, must have at most {most}$"
        with pytest.raises(BuildError, match=sentence):
            info(saved(crowd, f"{what}.usda"))
        monkeypatch.undo()


def test_what_is_left_out_is_named_once_each(
    saved: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    def fill(stage: Any) -> None:
        cube(stage, "/Cube").CreateSubdivisionSchemeAttr(UsdGeom.Tokens.catmullClark)
        for number in range(3):
            UsdGeom.BasisCurves.Define(stage, f"/Hair{number}")
        UsdGeom.Points.Define(stage, "/Dust")
        UsdGeom.Imageable(UsdGeom.NurbsPatch.Define(stage, "/Hidden")).MakeInvisible()
        stage.DefinePrim("/Lost", "Xform").GetReferences().AddReference("lost.usda")

    path = saved(fill)
    assert main(["info", path]) == 0
    assert capsys.readouterr().err.splitlines() == [
        f"frangible: {path}: is not complete: Could not open asset @lost.usda@ for reference "
        f"introduced by @{path}@</Lost>",
        f"frangible: {path}: left out: BasisCurves (/Hair0 and 2 more), Points (/Dust), "
        "subdivision of Mesh (/Cube)",
    ]


def test_what_is_left_out_is_named_where_nothing_else_is(saved: Any) -> None:
    path = saved(lambda stage: UsdGeom.Points.Define(stage, "/Dust") and None)
    with pytest.raises(BuildError, match="has no mesh that can be seen; left out: Points ./Dust."):
        info(path)


def test_what_moves_is_posed_at_a_time(saved: Any) -> None:
    def fill(stage: Any) -> None:
        stage.SetTimeCodesPerSecond(10)
        stage.SetStartTimeCode(5)
        stage.SetEndTimeCode(25)
        way = cube(stage, "/Cube").AddTranslateOp()
        way.Set(Gf.Vec3d(0, 0, 0), 5)
        way.Set(Gf.Vec3d(4, 0, 0), 25)

    path = saved(fill)
    for pose_time, at in ((None, 0.0), (0.0, 0.0), (1.0, 2.0), (9.0, 4.0)):
        with readable_mesh(path, pose_time) as file:
            assert mesh_info(file)["center_m"] == pytest.approx([at, 0, 0], abs=1e-9)


def test_a_skeleton_moves_its_mesh_at_a_time(saved: Any) -> None:
    def fill(stage: Any) -> None:
        stage.SetTimeCodesPerSecond(10)
        stage.SetStartTimeCode(1)
        stage.SetEndTimeCode(11)
        UsdSkel.Root.Define(stage, "/Root")
        skeleton = UsdSkel.Skeleton.Define(stage, "/Root/Skeleton")
        skeleton.AddTranslateOp().Set(Gf.Vec3d(0, 7, 0))
        skeleton.CreateJointsAttr(["joint"])
        skeleton.CreateBindTransformsAttr([Gf.Matrix4d(1)])
        skeleton.CreateRestTransformsAttr([Gf.Matrix4d(1)])
        motion = UsdSkel.Animation.Define(stage, "/Root/Skeleton/Motion")
        motion.CreateJointsAttr(["joint"])
        motion.CreateRotationsAttr([Gf.Quatf(1, 0, 0, 0)])
        motion.CreateScalesAttr([Gf.Vec3h(1, 1, 1)])
        for time, x in ((1, 0.0), (11, 6.0)):
            motion.CreateTranslationsAttr().Set([Gf.Vec3f(x, 0, 0)], time)
        binding = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
        binding.CreateAnimationSourceRel().SetTargets(["/Root/Skeleton/Motion"])
        mesh = cube(stage, "/Root/Cube")
        mesh.AddTranslateOp().Set(Gf.Vec3d(90, 0, 0))
        binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
        binding.CreateSkeletonRel().SetTargets(["/Root/Skeleton"])
        binding.CreateJointIndicesPrimvar(False, 1).Set([0] * 8)
        binding.CreateJointWeightsPrimvar(False, 1).Set([1.0] * 8)

    path = saved(fill)
    # At rest it is where it was drawn, and then where its skeleton is.
    for pose_time, at in ((None, [90, 0, 0]), (0.0, [0, 7, 0]), (0.5, [3, 7, 0]), (1.0, [6, 7, 0])):
        with readable_mesh(path, pose_time) as file:
            assert mesh_info(file)["center_m"] == pytest.approx(at, abs=1e-6)


def test_polygons_that_are_holes_are_none(saved: Any) -> None:
    path = saved(lambda stage: cube(stage, "/Cube").CreateHoleIndicesAttr([1, 4]) and None)
    assert info(path)["triangles"] == 8


def test_a_time_range_makes_no_cache(saved: Any, capsys: pytest.CaptureFixture[str]) -> None:
    def fill(stage: Any) -> None:
        stage.SetStartTimeCode(5)
        stage.SetEndTimeCode(9)
        size = UsdGeom.Cube.Define(stage, "/Cube").CreateSizeAttr()
        size.Set(1.0, 1.0)
        size.Set(3.0, 9.0)

    assert main(["info", saved(fill)]) == 0
    # The size at the first time.
    assert re.search(r"^volume_m3 +8$", capsys.readouterr().out, re.MULTILINE)


@pytest.mark.parametrize("value", [Vt.Float(0.01), 0.01, Vt.Float(0.0), float("nan"), -1])
def test_units_are_read_from_whatever_they_are_stored_as(saved: Any, value: Any) -> None:
    path = saved(lambda stage: UsdGeom.Cube.Define(stage, "/Cube") and None, "drawn.usdc")
    layer = Sdf.Layer.FindOrOpen(path)
    layer.pseudoRoot.SetInfo("metersPerUnit", value)
    layer.Save()
    if value in (0.01, Vt.Float(0.01)):
        assert info(path)["volume_m3"] == pytest.approx(8e-6, rel=1e-12)
    else:
        with pytest.raises(BuildError, match="metersPerUnit: .*, must be a number > 0"):
            info(path)


@pytest.mark.parametrize(
    "reason", [RuntimeError("a\nb"), KeyError("x"), OverflowError("too large"), MemoryError()]
)
def test_whatever_the_library_raises_is_one_sentence(
    saved: Any, monkeypatch: pytest.MonkeyPatch, reason: Exception
) -> None:
    path = saved(lambda stage: cube(stage, "/Cube") and None)

    def fail(*_: object) -> None:
        raise reason

    monkeypatch.setattr(UsdGeom, "XformCache", fail)
    with pytest.raises(BuildError, match="is not a readable USD file|needs more memory") as error:
        info(path)
    assert str(error.value).startswith(f"{path}: ") and "\n" not in str(error.value)


def test_what_is_no_usd_file_is_said_to_be_none(tmp_path: Path) -> None:
    path = tmp_path / "noise.usdc"
    path.write_bytes(b"noise")
    with pytest.raises(BuildError, match="is not a readable USD file"):
        info(str(path))
