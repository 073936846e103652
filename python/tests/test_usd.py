"""USD files: valid by Pixar's own rules, and true to the recording."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from frangible import Recording
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdShade, UsdValidation


def violations(stage: Any) -> list[str]:
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    return [
        f"{error.GetName()}: {error.GetMessage()}"
        for error in UsdValidation.ValidationContext(validators).Validate(stage)
    ]


@pytest.fixture(scope="module", params=["usda", "usdc"])
def stage(
    request: pytest.FixtureRequest, scripted: Recording, tmp_path_factory: pytest.TempPathFactory
) -> Any:
    path = tmp_path_factory.mktemp("usd") / f"slab.{request.param}"
    scripted.save(path)
    return Usd.Stage.Open(str(path))


def test_no_validator_of_usd_objects(stage: Any) -> None:
    assert violations(stage) == []


def test_the_validators_do_object_to_a_face_that_is_not_there(
    scripted: Recording, tmp_path: Path
) -> None:
    scripted.save(tmp_path / "wrong.usda")
    stage = Usd.Stage.Open(str(tmp_path / "wrong.usda"))
    UsdGeom.Subset(stage.GetPrimAtPath("/World/slab/slab_4/inside")).GetIndicesAttr().Set([12])
    assert violations(stage)


def test_extents_are_those_of_the_points(stage: Any) -> None:
    for mesh in (UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)):
        assert mesh.GetExtentAttr().Get() == UsdGeom.PointBased.ComputeExtent(
            mesh.GetPointsAttr().Get()
        )


def test_the_wall_is_valid_too(wall: Recording, tmp_path: Path) -> None:
    wall.save(tmp_path / "wall.usdc")
    stage = Usd.Stage.Open(str(tmp_path / "wall.usdc"))
    assert violations(stage) == []
    meshes = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    assert len(meshes) == len(wall.bodies)


def test_units_and_times_are_stated(stage: Any) -> None:
    assert stage.GetDefaultPrim().GetPath() == "/World"
    assert UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert stage.GetMetadata("kilogramsPerUnit") == 1.0
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()) == (
        0.0,
        6.0,
        24.0,
    )


def test_fragments_lie_under_their_source(stage: Any) -> None:
    meshes = [str(prim.GetPath()) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
    assert meshes == [
        "/World/ground/ground",
        *(f"/World/slab/slab{suffix}" for suffix in ("", "_2", "_4", "_5")),
    ]


def test_every_frame_shows_what_the_recording_shows(stage: Any, scripted: Recording) -> None:
    paths = {
        0: "/World/ground/ground",
        1: "/World/slab/slab",
        **{i: f"/World/slab/slab_{i}" for i in (2, 4, 5)},
    }
    for frame in range(scripted.frames + 1):
        for body in scripted.bodies:
            prim = UsdGeom.Imageable(stage.GetPrimAtPath(paths[body.id]))
            assert (prim.ComputeVisibility(frame) == UsdGeom.Tokens.inherited) == body.alive(
                frame
            ), (body.id, frame)
            if body.alive(frame):
                world = prim.ComputeLocalToWorldTransform(frame)
                points = UsdGeom.Mesh(prim).GetPointsAttr().Get()
                shown = np.array([world.Transform(Gf.Vec3d(point)) for point in points])
                assert shown == pytest.approx(body.vertices_world(frame), abs=1e-6)


def test_what_does_not_live_has_no_size(stage: Any, scripted: Recording) -> None:
    # Blender does not heed a visibility that changes; nor may a piece grow slowly before its birth.
    paths = {1: "/World/slab/slab", **{i: f"/World/slab/slab_{i}" for i in (2, 4, 5)}}
    for time in (0.0, 0.5, 1.0, 2.0, 2.5, 2.75, 3.0, 3.5, 5.0, 6.0):
        for body in (scripted.body(body_id) for body_id in paths):
            shown = UsdGeom.Imageable(stage.GetPrimAtPath(paths[body.id]))
            matrix = np.array(shown.ComputeLocalToWorldTransform(time))[:3, :3]
            alive = body.alive(int(np.floor(time)))
            assert np.linalg.det(matrix) == pytest.approx(float(alive), abs=1e-6), (body.id, time)


def test_what_does_not_move_has_no_samples(stage: Any) -> None:
    def samples(path: str, attribute: str) -> list[float]:
        return list(stage.GetPrimAtPath(path).GetAttribute(attribute).GetTimeSamples())

    assert samples("/World/ground/ground", "xformOp:translate") == []
    # What breaks goes on for a frame, and pieces come from where they were as a part of it.
    assert samples("/World/slab/slab", "xformOp:translate") == [0.0, 1.0, 2.0, 3.0]
    assert samples("/World/slab/slab", "xformOp:orient") == []
    assert samples("/World/slab/slab_2", "xformOp:orient") == [2.0, 3.0, 4.0, 5.0, 6.0]


def test_a_shutter_across_a_break_sees_everything_move(stage: Any, scripted: Recording) -> None:
    def place(path: str, time: float) -> Any:
        matrix = UsdGeom.Xformable(stage.GetPrimAtPath(path)).GetLocalTransformation(time)
        return np.array(matrix.ExtractTranslation())

    before = scripted.body(4).before
    assert before is not None
    assert place("/World/slab/slab_4", 2.0) == pytest.approx(before[:3])
    slab = scripted.body(1).positions
    assert place("/World/slab/slab", 3.0) == pytest.approx(2.0 * slab[-1] - slab[-2])


def test_velocities_are_those_of_the_way_to_each_frame(stage: Any, scripted: Recording) -> None:
    turning = stage.GetPrimAtPath("/World/slab/slab_2")
    # A quarter of a turn in a frame, 24 frames a second; in degrees, as in UsdPhysics.
    spin = turning.GetAttribute("physics:angularVelocity")
    assert np.array(spin.Get(5.0)) == pytest.approx([0.0, 90.0 * 24, 0.0], rel=1e-5)
    body = scripted.body(2)
    velocity = turning.GetAttribute("physics:velocity")
    for row in range(1, len(body.positions)):
        expected = (body.positions[row] - body.positions[row - 1]) * scripted.fps
        assert np.array(velocity.Get(3.0 + row)) == pytest.approx(expected, abs=1e-4)
    # A cache is no scene: nothing simulates it when somebody presses play.
    assert not turning.HasAPI(UsdPhysics.RigidBodyAPI)
    assert not stage.GetPrimAtPath("/World/ground/ground").HasAttribute("physics:velocity")


def test_the_hint_of_extents_holds_all_frames(stage: Any, scripted: Recording) -> None:
    low, high = UsdGeom.ModelAPI(stage.GetDefaultPrim()).GetExtentsHintAttr().Get()
    for frame in range(scripted.frames + 1):
        for body in scripted.alive(frame):
            places = body.vertices_world(frame)
            assert np.all(places >= np.array(low) - 1e-4)
            assert np.all(places <= np.array(high) + 1e-4)


def test_motion_is_in_a_layer_of_its_own(scripted: Recording, tmp_path: Path) -> None:
    scripted.save(tmp_path / "slab.usda")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["slab.geometry.usda", "slab.usda"]
    motion, shapes = ((tmp_path / name).read_text() for name in ("slab.usda", "slab.geometry.usda"))
    assert "points" not in motion and "faceVertex" not in motion and "Material" not in motion
    assert "./slab.geometry.usda" in motion
    assert "timeSamples" not in shapes and "xformOp" not in shapes
    # Each opens alone, and says its unit and axes.
    alone = Usd.Stage.Open(str(tmp_path / "slab.geometry.usda"))
    assert alone.GetDefaultPrim().GetPath() == "/World"
    assert UsdGeom.GetStageMetersPerUnit(alone) == 1.0


def test_motion_without_its_surfaces_is_a_sentence(
    scripted: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from frangible.cli import main

    scripted.save(tmp_path / "slab.usdc")
    (tmp_path / "slab.geometry.usdc").unlink()
    assert main(["info", str(tmp_path / "slab.usdc")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith("slab.usdc: needs the file ./slab.geometry.usdc beside it")


def test_one_file_holds_all(scripted: Recording, tmp_path: Path) -> None:
    from frangible.cli import main

    scripted.save(tmp_path / "slab.usdz")
    assert [path.name for path in tmp_path.iterdir()] == ["slab.usdz"]
    stage = Usd.Stage.Open(str(tmp_path / "slab.usdz"))
    assert sum(prim.IsA(UsdGeom.Mesh) for prim in stage.Traverse()) == len(scripted.bodies)
    assert violations(stage) == []
    assert main(["info", str(tmp_path / "slab.usdz")]) == 0


def test_cracks_have_a_material_of_their_own(stage: Any) -> None:
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/slab/slab_4"))
    outside, inside = UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets()
    assert list(inside.GetIndicesAttr().Get()) == [0, 1, 2, 3]
    assert list(outside.GetIndicesAttr().Get()) == [4, 5, 6, 7, 8, 9, 10, 11]

    def material(prim: Any) -> str:
        return str(UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0].GetPath())

    assert material(mesh) == material(outside) == "/World/Materials/slab"
    assert material(inside) == "/World/Materials/inside"


def test_corners_have_places_in_the_texture(stage: Any, scripted: Recording) -> None:
    primvar = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/slab/slab_4")).GetPrimvar("st")
    assert (primvar.GetInterpolation(), str(primvar.GetTypeName())) == (
        "faceVarying",
        "texCoord2f[]",
    )
    assert np.array(primvar.Get()) == pytest.approx(scripted.body(4).coordinates.reshape(-1, 2))


def test_glass_is_clear_and_the_rest_is_not(stage: Any) -> None:
    def opacity(path: str) -> float:
        prim = UsdGeom.Mesh(stage.GetPrimAtPath(path))
        material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
        return float(material.ComputeSurfaceSource()[0].GetInput("opacity").Get())

    assert opacity("/World/slab/slab_5") < 0.2
    assert opacity("/World/slab/slab_4") == 1.0
