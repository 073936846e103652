"""Where a body of a stage is strong and where weak: attributes of the schema, and a primvar of its
mesh."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from pxr import Sdf, UsdGeom, Vt

from ..recording import Float64, Int64
from .shown_meshes import fan
from .usd_bodies import StageBody
from .usd_frames import Frame, tidy_list
from .usd_mesh import StageReader
from .usd_notes import Notes
from .usd_part import Part, moved
from .usd_stage import metres_from_stage, open_stage, short_number, time_code

#: Places in the shape's own frame [m], and a factor of strength at each.
POINTS, FACTORS = "frangible:strengthPoints", "frangible:strengthFactors"
#: Triangles between these places.
TRIANGLES = "frangible:strengthTriangles"
#: The primvar of a mesh: a factor of strength at each vertex.
PRIMVAR = "strength"
#: What such a primvar is instead, in notes.
NO_NUMBERS = "strength that is no number for each vertex"
#: Factors that the engine takes.
LEAST, LARGEST = 1e-6, 1e6
#: Of more vertices means over cells are taken, without triangles: a scene names every point.
MOST_POINTS = 32768

#: ``strength_points`` and ``strength_triangles`` of a scene.
Strength = dict[str, list[Any]]


def strength_points_of(prim: Any) -> Strength:
    """What the attributes of the schema say; nothing where they do not fit each other."""
    places, factors, triangles = (
        prim.GetAttribute(name).Get() or [] for name in (POINTS, FACTORS, TRIANGLES)
    )
    if not len(places) or len(places) != len(factors):
        return {}
    points = [
        {"point": [float(number) for number in place], "factor": float(factor)}
        for place, factor in zip(places, factors, strict=True)
    ]
    corners = [[int(number) for number in triangle] for triangle in triangles]
    fits = all(0 <= number < len(points) for triangle in corners for number in triangle)
    triangles = {"strength_triangles": corners} if corners and fits else {}
    return {"strength_points": points, **triangles}


def write_strength_points(prim: Any, said: Mapping[str, Any]) -> None:
    """Say those of a scene's ``breaking`` with the attributes of the schema."""
    points = said.get("strength_points")
    if not points:
        return
    types = Sdf.ValueTypeNames
    places = np.array([point["point"] for point in points], np.float64).reshape(-1, 3)
    factors = np.array([point["factor"] for point in points], np.float64)
    prim.CreateAttribute(POINTS, types.Point3dArray, False).Set(Vt.Vec3dArray.FromNumpy(places))
    prim.CreateAttribute(FACTORS, types.DoubleArray, False).Set(Vt.DoubleArray.FromNumpy(factors))
    if triangles := said.get("strength_triangles"):
        corners = Vt.Vec3iArray.FromNumpy(np.array(triangles, np.int32).reshape(-1, 3))
        prim.CreateAttribute(TRIANGLES, types.Int3Array, False).Set(corners)


def add_vertex_strength(
    fracture: dict[str, Any], body: StageBody, shape: Frame, path: str, time: Any, notes: Notes
) -> None:
    """Add the strengths at vertices of a body's meshes to how it breaks; ``shape`` is the frame of
    its shape. Points of the schema itself count instead."""
    painted = _Painted()
    for collider in body.colliders:
        primvar = UsdGeom.PrimvarsAPI(collider.prim).GetPrimvar(PRIMVAR)
        if not collider.prim.IsA(UsdGeom.Mesh) or not primvar or not primvar.HasValue():
            continue
        at = collider.prim.GetPath()
        if not fracture or fracture.get("material", {}) == {"breaks": False}:
            notes.add("strength of vertices of a body that does not break", at)
            continue
        part = StageReader(path, time, is_posed=False).parts_of(collider.prim)[0]
        values = _at_vertices(primvar, len(part.points), time)
        if values is None:
            notes.add(NO_NUMBERS, at)
            continue
        places = part.points @ collider.world[:3, :3] + collider.world[3, :3]
        painted.add(part, (places - shape.origin) @ shape.rotation.T, values)
    if found := painted.found():
        holder = fracture.setdefault("bonds" if "bonds" in fracture else "breaking", {})
        if "strength_points" not in holder:
            holder.update(found)


def strength_of_stage(path: str) -> tuple[Strength, list[str]]:
    """The strengths at vertices of all meshes that `write_stage` writes, in its frame; 1 at those
    that have none, and nothing if none has any. With notes on what is left out."""
    with open_stage(path) as stage:
        reader = StageReader(path, time_code(stage, None), is_posed=False)
        units = np.eye(4)
        units[:3, :3] = metres_from_stage(path, stage).T
        painted, notes = _Painted(), []
        has_any = False
        for part in reader.gather(stage.GetPseudoRoot()):
            primvar = UsdGeom.PrimvarsAPI(part.prim).GetPrimvar(PRIMVAR)
            values = None
            if part.prim.IsA(UsdGeom.Mesh) and primvar and primvar.HasValue():
                values = _at_vertices(primvar, len(part.points), reader.time)
                if values is None:
                    notes.append(f"{NO_NUMBERS} ({part.name}): left out")
            has_any = has_any or values is not None
            factors = np.ones(len(part.points)) if values is None else values
            painted.add(part, moved(part, units).points, factors)
        return (painted.found() if has_any else {}), notes


class _Painted:
    """Places of vertices, their factors, and the triangles between them."""

    def __init__(self) -> None:
        self.places: list[Float64] = []
        self.factors: list[Float64] = []
        self.triangles: list[Int64] = []

    def add(self, part: Part, places: Float64, factors: Float64) -> None:
        """The vertices of a part."""
        corners, _ = fan(part.counts)
        self.triangles.append(part.corners[corners] + sum(len(places) for places in self.places))
        self.places.append(places)
        self.factors.append(factors)

    def found(self) -> Strength:
        """As scenes have them; nothing of no vertices."""
        if not sum(len(places) for places in self.places):
            return {}
        places, factors = np.concatenate(self.places), np.concatenate(self.factors)
        means = _gathered(places, factors)
        found: Strength = {
            "strength_points": [
                {"point": tidy_list(place), "factor": short_number(factor)}
                for place, factor in zip(means[0], means[1].tolist(), strict=True)
            ]
        }
        if len(means[0]) == len(places) and (triangles := np.concatenate(self.triangles)).size:
            found["strength_triangles"] = triangles.tolist()
        return found


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
