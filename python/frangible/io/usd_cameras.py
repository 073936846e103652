"""Cameras of a USD stage: where they are at each of its time codes, and what their lenses show."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pxr import Gf, Usd, UsdGeom

from ..convention import Convention
from ..recording import Float64, without_sign_flips
from ..stage_camera import StageCamera
from .usd_frames import frame_of, quaternion, rotation_of
from .usd_poses import is_animated

#: A longer range of times is not followed to its end [frames].
LONGEST = 10_000


def stage_cameras(stage: Any, units: Float64) -> tuple[StageCamera, ...]:
    """All cameras with a perspective, the one first that the stage's render settings name.

    ``units`` (4, 4) turns rows of the stage into metres, y up.
    """
    prims = [
        prim
        for prim in stage.Traverse(Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate))
        if prim.IsA(UsdGeom.Camera)
    ]
    chosen = _rendered_with(stage)
    prims.sort(key=lambda prim: str(prim.GetPath()) not in chosen)
    cameras = (_camera(stage, UsdGeom.Camera(prim), units) for prim in prims)
    return tuple(camera for camera in cameras if camera is not None)


def _rendered_with(stage: Any) -> set[str]:
    """Paths of the cameras that the stage's render settings name."""
    path = stage.GetMetadata("renderSettingsPrimPath")
    prim = stage.GetPrimAtPath(path) if path else None
    relation = prim.GetRelationship("camera") if prim else None
    return {str(target) for target in relation.GetTargets()} if relation else set()


def _camera(stage: Any, camera: Any, units: Float64) -> StageCamera | None:
    start = stage.GetStartTimeCode() if stage.HasAuthoredTimeCodeRange() else 0.0
    end = stage.GetEndTimeCode() if stage.HasAuthoredTimeCodeRange() else start
    frames = round(end - start) if math.isfinite(end - start) else 0
    prim = camera.GetPrim()
    moves = is_animated(prim) or any(
        attribute.ValueMightBeTimeVarying() for attribute in prim.GetAttributes()
    )
    eyes, turns, lenses = [], [], []
    for frame in range(min(frames, LONGEST) + 1 if moves else 1):
        seen = camera.GetCamera(Usd.TimeCode(start + frame))
        if seen.projection != seen.Perspective:
            return None
        frame_world = frame_of(np.array(seen.transform, np.float64) @ units)
        eyes.append(tuple(float(number) for number in frame_world.origin))
        turns.append(quaternion(frame_world.rotation))
        # Both in the same unit, a tenth of the stage's.
        twice = 2.0 * float(seen.focalLength)
        if not twice > 0.0:
            return None
        lenses.append(
            (float(seen.horizontalAperture) / twice, float(seen.verticalAperture) / twice)
        )
    rows = without_sign_flips(np.array(turns))
    fps = float(stage.GetTimeCodesPerSecond())
    orientations = tuple(tuple(map(float, row)) for row in rows)
    known = StageCamera(str(prim.GetPath()), fps, tuple(eyes), orientations, tuple(lenses))
    return known if all(min(lens) > 0.0 for lens in lenses) else None


def write_camera(
    stage: Any, path: str, camera: StageCamera, convention: Convention, fps: float
) -> None:
    """A camera below a root that turns metres, y up, into the stage's unit and axes. ``fps`` are
    the stage's time codes per second."""
    prim = UsdGeom.Camera.Define(stage, path)
    # The usual film is 20.955 units wide; apertures and focal length are in one unit.
    wide, high = camera.lenses[0]
    aperture = 20.955
    prim.CreateHorizontalApertureAttr(aperture)
    prim.CreateVerticalApertureAttr(aperture * high / wide)
    focal = prim.CreateFocalLengthAttr()
    matrix = prim.AddTransformOp()
    for row, (eye, turn, lens) in enumerate(
        zip(camera.eyes, camera.orientations, camera.lenses, strict=True)
    ):
        full = np.eye(4)
        # The root's scale is no camera's.
        full[:3, :3], full[3, :3] = convention.metres * rotation_of(list(turn)), eye
        time = Usd.TimeCode(convention.first_frame + row * fps / camera.fps)
        at = time if len(camera.eyes) > 1 else Usd.TimeCode.Default()
        matrix.Set(Gf.Matrix4d(*full.ravel().tolist()), at)
        focal.Set(aperture / (2.0 * lens[0]), at)
