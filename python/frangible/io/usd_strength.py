"""Where a body of a stage is strong and where weak: attributes of the schema, and a primvar of its
mesh."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Sdf, UsdGeom, Vt

from ..recording import Float64
from .usd_bodies import StageBody
from .usd_frames import Frame, tidy_list
from .usd_mesh import StageReader
from .usd_notes import Notes
from .usd_stage import short_number

#: Places in the shape's own frame [m], and a factor of strength at each.
POINTS, FACTORS = "frangible:strengthPoints", "frangible:strengthFactors"
#: The primvar of a mesh: a factor of strength at each vertex.
PRIMVAR = "strength"
#: Factors that the engine takes.
LEAST, LARGEST = 1e-6, 1e6
#: More vertices are gathered in cells: a blow asks all points.
MOST_POINTS = 4096

#: Items of ``strength_points`` of a scene.
StrengthPoints = list[dict[str, Any]]


def strength_points_of(prim: Any) -> StrengthPoints:
    """What the attributes of the schema say; none where they do not fit each other."""
    places, factors = (prim.GetAttribute(name).Get() or [] for name in (POINTS, FACTORS))
    if len(places) != len(factors):
        return []
    return [
        {"point": [float(number) for number in place], "factor": float(factor)}
        for place, factor in zip(places, factors, strict=True)
    ]


def write_strength_points(prim: Any, points: StrengthPoints) -> None:
    """Say them with the attributes of the schema."""
    types = Sdf.ValueTypeNames
    places = np.array([point["point"] for point in points], np.float64).reshape(-1, 3)
    factors = np.array([point["factor"] for point in points], np.float64)
    prim.CreateAttribute(POINTS, types.Point3dArray, False).Set(Vt.Vec3dArray.FromNumpy(places))
    prim.CreateAttribute(FACTORS, types.DoubleArray, False).Set(Vt.DoubleArray.FromNumpy(factors))


def add_vertex_strength(
    fracture: dict[str, Any], body: StageBody, shape: Frame, path: str, time: Any, notes: Notes
) -> None:
    """Add the strengths at vertices of a body's meshes to how it breaks; ``shape`` is the frame of
    its shape. Points of the schema itself count instead."""
    places, factors = [], []
    for collider in body.colliders:
        primvar = UsdGeom.PrimvarsAPI(collider.prim).GetPrimvar(PRIMVAR)
        if not collider.prim.IsA(UsdGeom.Mesh) or not primvar or not primvar.HasValue():
            continue
        at = collider.prim.GetPath()
        if not fracture or fracture.get("material", {}) == {"breaks": False}:
            notes.add("strength of vertices of a body that does not break", at)
            continue
        points = StageReader(path, time, is_posed=False).parts_of(collider.prim)[0].points
        values = _at_vertices(primvar, len(points), time)
        if values is None:
            notes.add("strength that is no number for each vertex", at)
            continue
        places.append(points @ collider.world[:3, :3] + collider.world[3, :3])
        factors.append(values)
    if not places:
        return
    local = (np.concatenate(places) - shape.origin) @ shape.rotation.T
    means = _gathered(local, np.concatenate(factors))
    found = [
        {"point": tidy_list(place), "factor": short_number(factor)}
        for place, factor in zip(means[0], means[1].tolist(), strict=True)
    ]
    holder = fracture.setdefault("bonds" if "bonds" in fracture else "breaking", {})
    holder.setdefault("strength_points", found)


def _at_vertices(primvar: Any, count: int, time: Any) -> Float64 | None:
    """(count,) factors that the engine takes; `None` if there is not one for each vertex."""
    try:
        values = np.asarray(primvar.ComputeFlattened(time), np.float64)
    except (TypeError, ValueError):
        return None
    if primvar.GetInterpolation() == UsdGeom.Tokens.constant and values.size == 1:
        values = np.full(count, values.ravel()[0])
    interpolations = (UsdGeom.Tokens.vertex, UsdGeom.Tokens.varying, UsdGeom.Tokens.constant)
    fits = values.shape == (count,) and primvar.GetInterpolation() in interpolations
    if not fits or not np.isfinite(values).all():
        return None
    return np.clip(values, LEAST, LARGEST)


def _gathered(places: Float64, factors: Float64) -> tuple[Float64, Float64]:
    """Places and factors as they are, or means over the cells of a grid if they are many; one
    point where all factors are equal."""
    if np.ptp(factors) == 0.0:
        return places.mean(axis=0, keepdims=True), factors[:1]
    low, size = places.min(axis=0), np.ptp(places, axis=0).max()
    cells = 2 * round(MOST_POINTS ** (1.0 / 3.0))
    while len(places) > MOST_POINTS and cells > 1:
        key = np.floor((places - low) * (cells / size)).astype(np.int64)
        _, owner, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
        if len(count) > MOST_POINTS:
            cells -= 1 + cells // 8
            continue
        sums = [np.bincount(owner.ravel(), weights=column) for column in (*places.T, factors)]
        x, y, z, factor = (total / count for total in sums)
        return np.stack([x, y, z], axis=1), factor
    return places, factors
