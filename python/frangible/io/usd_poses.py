"""Poses of kinematic bodies whose transforms are animated."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Gf, Usd, UsdGeom

from ..recording import Float64
from .usd_frames import Frame, frame_of, quaternion


#: A sample this near to a whole frame is that frame's [frames].
SAME = 1e-6


def is_animated(prim: Any) -> bool:
    """True if the transform of a prim, or of one above it, changes."""
    while prim and not prim.IsPseudoRoot():
        if prim.IsA(UsdGeom.Xformable):
            xform = UsdGeom.Xformable(prim)
            if xform.TransformMightBeTimeVarying():
                return True
            if xform.GetResetXformStack():
                return False
        prim = prim.GetParent()
    return False


def _frames_of(prim: Any, start: float, frames: int) -> list[float]:
    """All whole frames, and those of samples of the transforms at and above a prim."""
    samples: set[float] = set()
    while prim and not prim.IsPseudoRoot():
        if prim.IsA(UsdGeom.Xformable):
            xform = UsdGeom.Xformable(prim)
            interval = Gf.Interval(start, start + frames)
            samples.update(float(time) - start for time in xform.GetTimeSamplesInInterval(interval))
            if xform.GetResetXformStack():
                break
        prim = prim.GetParent()
    between = [sample for sample in samples if abs(sample - round(sample)) > SAME]
    return sorted([*range(frames + 1), *between])


def keyframes(
    prim: Any, shape: Frame, own: Frame, units: Float64, start: float, frames: int
) -> list[dict[str, Any]]:
    """Place and orientation of a body's shape in each frame, from the first one on, and where the
    stage has samples between frames. ``shape`` and ``own`` are the frames of the shape and of the
    prim in the first one."""
    # The shape stays where it is on the prim.
    rotation = shape.rotation @ own.rotation.T
    origin = (shape.origin - own.origin) @ own.rotation.T
    found = []
    cache = UsdGeom.XformCache()
    before = np.array([0.0, 0.0, 0.0, 1.0])
    for frame in _frames_of(prim, start, frames):
        cache.SetTime(Usd.TimeCode(start + frame))
        world = np.array(cache.GetLocalToWorldTransform(prim), np.float64) @ units
        now = frame_of(world)
        turn = np.array(quaternion(rotation @ now.rotation))
        # Neighbours have the same sign.
        turn = -turn if turn @ before < 0.0 else turn
        before = turn
        place = origin @ now.rotation + now.origin
        found.append({"frame": frame, "position": place.tolist(), "orientation": turn.tolist()})
    return found
