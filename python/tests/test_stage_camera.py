"""The camera of a USD stage, from the stage through a cache to pictures and back."""

from pathlib import Path

import numpy as np
import pytest
from frangible import Recording
from frangible.cli import main
from frangible.convention import Convention
from frangible.render.camera import CameraError, MovingCamera, camera_for

pytest.importorskip("pxr")

#: In centimetres, z up: a block falls, and a camera 6 m in front of it goes a metre to the right
#: in ten frames.
STAGE = """#usda 1.0
(
    metersPerUnit = 0.01
    upAxis = "Z"
    startTimeCode = 1
    endTimeCode = 11
    timeCodesPerSecond = 24
)
def Xform "World"
{
    def Cube "Block" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"])
    {
        double size = 100
    }
    def Camera "Wide"
    {
        float horizontalAperture = 20
        float verticalAperture = 10
        float focalLength = 20
        matrix4d xformOp:transform.timeSamples = {
            1: ((1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0), (0, -600, 0, 1)),
            11: ((1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0), (100, -600, 0, 1))
        }
        uniform token[] xformOpOrder = ["xformOp:transform"]
    }
    def Camera "Close"
    {
        float focalLength = 80
        double3 xformOp:translate = (0, 0, 900)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
"""


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("camera")
    (folder / "set.usda").write_text(STAGE)
    run = ["run", str(folder / "set.usda"), "--quiet"]
    assert main([*run, "--out", str(folder / "set.npz"), "--out", str(folder / "out.usda")]) == 0
    return folder / "set.npz"


def test_the_cache_carries_the_cameras_of_its_stage(cache: Path) -> None:
    cameras = Recording.load(cache).convention.cameras
    assert [camera.name for camera in cameras] == ["/World/Wide", "/World/Close"]
    wide = cameras[0]
    assert len(wide.eyes) == 11 and len(cameras[1].eyes) == 1
    # Metres, y up: what lies towards -y in the stage lies towards the viewer.
    assert wide.eyes[0] == pytest.approx((0.0, 0.0, 6.0), abs=1e-9)
    assert wide.eyes[10] == pytest.approx((1.0, 0.0, 6.0), abs=1e-9)
    assert wide.lenses[0] == pytest.approx((0.5, 0.25))


def test_the_picture_sees_at_least_what_the_lens_does(cache: Path) -> None:
    recording = Recording.load(cache)
    moving = camera_for(recording, "stage", 4.0)
    assert isinstance(moving, MovingCamera)
    first, later = moving.at(0.0), moving.at(5.5)
    assert first.axes == pytest.approx(np.array([[1, 0, 0], [0, 1, 0], [0, 0, -1]]), abs=1e-9)
    assert later.eye == pytest.approx([0.55, 0.0, 6.0])
    # A picture that is wider than the lens has its height, a narrower one its width.
    assert first.half_height == pytest.approx(0.25)
    assert camera_for(recording, "stage", 1.0).at(0).half_height == pytest.approx(0.5)
    above = camera_for(recording, "stage:/World/Close", 1.5).at(3)
    assert above.axes[2] == pytest.approx([0, -1, 0], abs=1e-9)
    # The lamp stays where it is while the camera moves.
    assert later.first is not None and later.first.eye == pytest.approx(first.eye)


def test_the_command_draws_with_it(cache: Path, tmp_path: Path) -> None:
    from PIL import Image

    out = str(tmp_path / "a.png")
    options = ["--camera", "stage", "--frame", "0", "--size", "128x64", "--quiet"]
    assert main(["render", str(cache), "--out", out, *options]) == 0
    image = np.asarray(Image.open(out)).astype(int)
    # The block is 1 m wide, its front 5.5 m away, in a picture that is as wide as the distance.
    differs = np.abs(image[32] - image[32, 0]).sum(axis=1) > 40
    assert differs.sum() == pytest.approx(128 / 5.5, abs=3)
    assert np.flatnonzero(differs).mean() == pytest.approx(63.5, abs=1.5)


def test_a_stage_that_is_written_again_has_its_cameras(cache: Path) -> None:
    from pxr import Usd, UsdGeom

    before = Usd.Stage.Open(str(cache.with_name("set.usda")))
    after = Usd.Stage.Open(str(cache.with_name("out.usda")))
    for path in ("/World/Wide", "/World/Close"):
        for time in (1.0, 4.5, 11.0):
            one, other = (
                UsdGeom.Camera(stage.GetPrimAtPath(path)).GetCamera(time)
                for stage in (before, after)
            )
            assert np.array(other.transform) == pytest.approx(np.array(one.transform), abs=1e-4)
            assert other.GetFieldOfView(one.FOVHorizontal) == pytest.approx(
                one.GetFieldOfView(one.FOVHorizontal), abs=1e-4
            )


def test_a_camera_that_is_not_there_is_a_sentence(
    cache: Path, scripted: Recording, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(CameraError, match="comes from no USD stage that has a camera"):
        camera_for(scripted, "stage", 1.0)
    assert main(["render", str(cache), "--camera", "stage:/No", "--out", "a.png"]) == 2
    said = capsys.readouterr().err
    assert "stage:/No, must be one of stage:/World/Wide, stage:/World/Close" in said


@pytest.mark.parametrize(
    "cameras",
    ["3", "[{}]", '[{"name": "a", "fps": 24, "eyes": [], "orientations": [], "lenses": []}]'],
)
def test_damaged_cameras_are_named(cameras: str) -> None:
    text = f'{{"up_axis": "y", "metres": 1, "first_frame": 0, "cameras": {cameras}}}'
    with pytest.raises(ValueError, match="cameras"):
        Convention.from_json(text)
