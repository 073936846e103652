"""Meshes and drawn patterns in USD files."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from frangible import BuildError, Pattern, break_mesh, mesh_info, run
from frangible.cli import main
from frangible.usd_mesh import readable_mesh
from pxr import Gf, Usd, UsdGeom

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
    assert (facts["low_m"], facts["high_m"]) == (pytest.approx([-1, 4.75, -3.5]), pytest.approx([1, 5.25, -2.5]))


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
def test_a_mesh_in_usd_is_simulated(saved: Any, capsys: pytest.CaptureFixture[str], ending: str) -> None:
    path = saved(lambda stage: cube(stage, "/Cube") and None, f"drawn.{ending}")
    assert main(["run", "impact", "--mesh", path, "--frames", "1", "--threads", "1", "--json"]) == 0
    assert '"frames": 1' in capsys.readouterr().out
    recording = run("impact", mesh=path, frames=1, threads=1)
    assert "mesh" in [body.name for body in recording.bodies]


@pytest.mark.parametrize("lost", [None, 3])
def test_a_pattern_is_drawn_in_usd(saved: Any, capsys: pytest.CaptureFixture[str], lost: int | None) -> None:
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
        assert f"{path}: a gap of 0.78 m^3 (9.8 % of the box) around (-0.7236, 0.086, 0.5948)" in capsys.readouterr().err


def test_a_mesh_in_usd_breaks_and_is_described(saved: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = saved(lambda stage: cube(stage, "/Cube") and None)
    pieces = break_mesh(path, Pattern.named("voronoi", cells=6))
    assert pieces.name == "drawn" and len(pieces.pieces) > 2
    assert main(["break", path, "--pattern", "slices", "--cells", "4", "--exact", "--out", str(tmp_path / "pieces.usdc")]) == 0
    capsys.readouterr()
    assert main(["info", path]) == 0
    assert re.search(r"^volume_m3 +8$", capsys.readouterr().out, re.MULTILINE)


@pytest.mark.parametrize(
    ("fill", "sentence"),
    [
        (lambda stage: UsdGeom.Xform.Define(stage, "/Empty"), "has no mesh that can be seen"),
        (lambda stage: cube(stage, "/Cube").CreateFaceVertexIndicesAttr([0, 1, 99]), "the faces of /Cube do not fit its points"),
        (lambda stage: cube(stage, "/Cube").CreatePointsAttr([(0, 0, float("inf"))] * 8), "coordinates must be finite"),
    ],
)
def test_a_bad_mesh_gets_a_sentence_with_its_path(saved: Any, fill: Callable[[Any], Any], sentence: str) -> None:
    path = saved(lambda stage: fill(stage) and None)
    with pytest.raises(BuildError, match=sentence) as error:
        info(path)
    assert str(error.value).startswith(f"{path}: ")


def test_what_is_no_usd_file_is_said_to_be_none(tmp_path: Path) -> None:
    path = tmp_path / "noise.usdc"
    path.write_bytes(b"noise")
    with pytest.raises(BuildError, match="is not a readable USD file"):
        info(str(path))
