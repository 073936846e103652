"""A centre of mass, and an inertia, that a body of a stage has of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Gf, UsdPhysics

from .. import _frangible
from ..recording import Float64
from .usd_bodies import StageBody
from .usd_colliders import Fit
from .usd_frames import Frame, frame_of, quaternion, rotation_of, tidy_list
from .usd_mass import Units
from .usd_notes import Notes

#: A centre of mass that is this near to the shape's is the shape's [parts of the size].
NEAR = 1e-4
#: What becomes of those that are not taken.
_INSTEAD = "follows from the shape instead"


def own_mass(
    fields: dict[str, Any],
    body: StageBody,
    shape: Frame,
    fits: list[Fit],
    units: Units,
    notes: Notes,
) -> dict[str, Any] | None:
    """``mass_properties`` of a dynamic body with these fields; `None`, with a note, where it cannot
    have them. ``shape`` is the frame of its shape, and ``fits`` are the shapes of its colliders."""
    for collider in body.colliders:
        if collider.prim != body.prim and any(_said(collider.prim)):
            notes.add("centre of mass or inertia of a collider", collider.prim.GetPath(), _INSTEAD)
    center, moments = _said(body.prim)
    if center is None and moments is None:
        return None
    own: dict[str, Any] = {}
    place = None
    if center is not None:
        world = center @ body.world[:3, :3] + body.world[3, :3]
        place = (world - shape.origin) @ shape.rotation.T
        own["center"] = tidy_list(place)
    if moments is not None:
        own["moments"] = tidy_list(moments * units.kilograms * units.metres**2)
        axes = UsdPhysics.MassAPI(body.prim).GetPrincipalAxesAttr().Get()
        if axes is not None and axes.GetLength() > 0.0:
            turn = [*axes.GetImaginary(), axes.GetReal()]
            in_world = rotation_of(turn) @ frame_of(body.world).rotation
            own["axes"] = quaternion(in_world @ shape.rotation.T)
    if place is not None and _is_middle(fields["shape"], place):
        del own["center"]
    if not own:
        return None
    what = "centre of mass of its own" if "center" in own else "inertia of its own"
    if (reason := _refusal(fields, own, shape, fits)) is not None:
        notes.add(what, body.name, f"{_INSTEAD}: {reason}")
        return None
    if own.get("axes") == [0.0, 0.0, 0.0, 1.0]:
        del own["axes"]
    return own


def write_own_mass(prim: Any, body: dict[str, Any]) -> None:
    """Say the mass properties of a body's own at its prim, whose transform has its sizes."""
    own, shape = body.get("mass_properties"), body["shape"]
    if not own:
        return
    api = UsdPhysics.MassAPI(prim)
    if own.get("mass") is not None:
        api.CreateMassAttr(float(own["mass"]))
    if own.get("center") is not None:
        place = np.array(own["center"], np.float64)
        if shape["kind"] == "box":
            place = place / np.array(shape["size"], np.float64)
        if shape["kind"] == "cone":
            # USD's is placed by the middle of its height.
            place = place - [0.0, 0.25 * float(shape["height"]), 0.0]
        api.CreateCenterOfMassAttr(Gf.Vec3f(*place.tolist()))
    if own.get("moments") is not None:
        x, y, z, w = (float(number) for number in own.get("axes") or (0.0, 0.0, 0.0, 1.0))
        api.CreateDiagonalInertiaAttr(Gf.Vec3f(*(float(moment) for moment in own["moments"])))
        api.CreatePrincipalAxesAttr(Gf.Quatf(w, x, y, z).GetNormalized())


def _said(prim: Any) -> tuple[Float64 | None, Float64 | None]:
    """Centre of mass and principal moments of a prim, in its own units; `None` where it says
    nothing."""
    if not prim.HasAPI(UsdPhysics.MassAPI):
        return None, None
    api = UsdPhysics.MassAPI(prim)
    found = []
    for attribute in (api.GetCenterOfMassAttr(), api.GetDiagonalInertiaAttr()):
        value = np.array(attribute.Get(), np.float64) if attribute.HasAuthoredValue() else None
        found.append(value if value is not None and np.isfinite(value).all() else None)
    center, moments = found
    return center, moments if moments is not None and moments.any() else None


def _is_middle(shape: dict[str, Any], place: Float64) -> bool:
    """True if a centre of mass is the shape's, as far as that is known without sampling it."""
    if shape["kind"] == "mesh":
        return False
    try:
        found = _frangible.World.build({"bodies": [{"shape": shape}]}, 1)
    except _frangible.BuildError:
        return False
    size = float(found.volumes[0]) ** (1.0 / 3.0)
    off = np.abs(found.positions[0] - place).max()
    return bool(off <= NEAR * max(size, np.abs(place).max()))


def _refusal(
    fields: dict[str, Any], own: dict[str, Any], frame: Frame, fits: list[Fit]
) -> str | None:
    """Why the engine does not take it; `None` if it does."""
    if "material" in fields or "breaking" in fields or "bonds" in fields:
        return "the body breaks"
    shape = fields["shape"]
    tried = dict(own)
    if shape["kind"] == "mesh":
        # Of a mesh its bounds count.
        corners = np.concatenate([one.corners() for one in fits])
        corners = (corners - frame.origin) @ frame.rotation.T
        low, high = corners.min(axis=0), corners.max(axis=0)
        shape = {"kind": "box", "size": (high - low).tolist()}
        if "center" in own:
            tried["center"] = (np.array(own["center"]) - 0.5 * (low + high)).tolist()
    try:
        _frangible.World.build({"bodies": [{"shape": shape, "mass_properties": tried}]}, 1)
    except _frangible.BuildError as error:
        return str(error).partition("mass_properties")[2].lstrip(".: ") or str(error)
    return None
