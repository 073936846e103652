"""Density of a body from the masses and densities of UsdPhysics."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import UsdPhysics, UsdShade

from .. import _frangible
from .usd_bodies import StageBody
from .usd_colliders import Fit
from .usd_mesh import StageReader
from .usd_notes import Notes
from .usd_stage import short_number

#: Of what says nothing, as UsdPhysics has it [kg/m^3].
WATER = 1000.0


@dataclass(frozen=True, slots=True)
class Units:
    """Of a stage."""

    metres: float
    kilograms: float

    def density(self, number: float) -> float:
        """[kg/m^3]."""
        return short_number(number) * self.kilograms / self.metres**3


def density(
    body: StageBody,
    fits: list[Fit],
    shape: dict[str, Any],
    path: str,
    time: Any,
    units: Units,
    notes: Notes,
) -> float | None:
    """One density for a whole body [kg/m^3]; `None` if it has no volume."""  # fmt: skip
    mass = _number(body.prim, "mass")
    if mass is None:
        # Nothing needs a volume where all colliders are of one density.
        found = [_density_of(collider.prim, body.prim, units) for collider in body.colliders]
        if all(_number(collider.prim, "mass") is None for collider in body.colliders):
            if len(set(found)) == 1:
                return found[0]
    volumes = [volume(fit, body, index, path, time) for index, fit in enumerate(fits)]
    whole = sum(volumes)
    if not whole > 0.0:
        return None
    if mass is not None:
        exact = whole if len(fits) == 1 else shape_volume(shape) or whole
        return short_number(mass) * units.kilograms / exact
    masses = []
    for collider, its_volume in zip(body.colliders, volumes, strict=True):
        own = _number(collider.prim, "mass")
        masses.append(
            its_volume * _density_of(collider.prim, body.prim, units)
            if own is None
            else own * units.kilograms
        )
    notes.add("colliders of several densities in a body", body.name, "share their mass evenly")
    return sum(masses) / whole


def _number(prim: Any, name: str) -> float | None:
    """A quantity of the mass schema; 0 stands for none."""
    if not prim.HasAPI(UsdPhysics.MassAPI):
        return None
    value = prim.GetAttribute(f"physics:{name}").Get()
    return float(value) if value is not None and 0.0 < value < math.inf else None


def _density_of(prim: Any, body: Any, units: Units) -> float:
    """Of a collider: said at the prim or the nearest one above it in the body, or by its material,
    or water's."""
    above = prim
    while above and above.GetPath().HasPrefix(body.GetPath()):
        if (said := _number(above, "density")) is not None:
            return units.density(said)
        above = above.GetParent()
    material = physics_material(prim)
    if material is not None:
        value = UsdPhysics.MaterialAPI(material).GetDensityAttr().Get()
        if value is not None and 0.0 < value < math.inf:
            return units.density(float(value))
    return WATER


def physics_material(prim: Any) -> Any | None:
    """The prim of the physics material that is bound to a collider."""
    bound = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial("physics")[0]
    if not bound or not bound.GetPrim().HasAPI(UsdPhysics.MaterialAPI):
        return None
    return bound.GetPrim()


def volume(fit: Fit, body: StageBody, index: int, path: str, time: Any) -> float:
    """Of a collider [m^3]; 0 of a mesh that encloses nothing."""
    if fit.kind != "mesh":
        return shape_volume(fit.shape) or 0.0
    collider = body.colliders[index]
    part = StageReader(path, time, is_posed=False).parts_of(collider.prim)[0]
    # Polygons as fans.
    firsts = np.cumsum(part.counts) - part.counts
    fans = [
        (first, first + step, first + step + 1)
        for first, count in zip(firsts.tolist(), part.counts.tolist(), strict=True)
        for step in range(1, count - 1)
    ]
    if not fans:
        return 0.0
    points = part.points @ collider.world[:3, :3] + collider.world[3, :3]
    corners = points[part.corners[np.array(fans)]] - points.mean(axis=0)
    crosses = np.cross(corners[:, 0], corners[:, 1])
    return abs(float(np.einsum("ij,ij->i", crosses, corners[:, 2]).sum())) / 6.0


def shape_volume(shape: dict[str, Any]) -> float | None:
    """Of a shape that is no mesh, as the core measures it [m^3]; `None` if it has none."""
    # A meshless shape is built in no time.
    scene = {"bodies": [{"shape": shape, "density": 1.0}]}
    try:
        return float(_frangible.World.build(scene, 1).masses[0])
    except _frangible.BuildError:
        return None
