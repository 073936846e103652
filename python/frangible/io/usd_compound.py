"""The shape of a body that has several colliders."""

from __future__ import annotations

import json
from typing import Any

from ..recording import Float64
from .usd_colliders import Fit, outermost
from .usd_frames import Frame, quaternion, tidy_list
from .usd_notes import Notes


#: Corners of hulls of round shapes in their frames, by the shapes' fields: many are alike.
Hulls = dict[str, Float64]


def body_shape(
    fits: list[Fit], own: Frame, at: object, hulls: Hulls, notes: Notes
) -> tuple[dict[str, Any], Frame]:
    """The shape of a body in its frame: that of the only collider, a compound of boxes and hulls,
    or the mesh of all if one of them is a mesh. ``own`` is the frame of its prim."""
    if any(fit.kind == "mesh" for fit in fits):
        return {"kind": "mesh"}, own
    if len(fits) == 1:
        return fits[0].shape, fits[0].frame
    if any(fit.kind not in ("box", "hull") for fit in fits):
        notes.add("round colliders beside others", at, "are their convex hulls")
    return {"kind": "compound", "parts": [_part(fit, own, hulls) for fit in fits]}, own


def _part(fit: Fit, own: Frame, hulls: Hulls) -> dict[str, Any]:
    rotation = fit.frame.rotation @ own.rotation.T
    origin = (fit.frame.origin - own.origin) @ own.rotation.T
    part = dict(fit.shape)
    if fit.kind not in ("box", "hull"):
        key = json.dumps(fit.shape)
        if key not in hulls:
            local = (fit.corners() - fit.frame.origin) @ fit.frame.rotation.T
            hulls[key] = outermost(local)
        part = {"kind": "hull", "points": [tidy_list(point) for point in hulls[key]]}
    if origin.any():
        part["position"] = tidy_list(origin)
    if (turn := quaternion(rotation)) != [0.0, 0.0, 0.0, 1.0]:
        part["orientation"] = turn
    return part
