"""Colliders of UsdPhysics as shapes of a scene."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import UsdGeom, UsdPhysics

from ..recording import Float64
from .usd_bodies import Collider
from .usd_frames import Frame, frame_of, scales, tidy, tidy_list
from .usd_mesh import StageReader
from .usd_notes import Notes
from .usd_shapes import length_of

#: The most corners of a convex hull: those outermost in as many directions.
MOST_CORNERS = 256
#: Points are in a plane if they are thinner than this part of their size.
FLAT = 1e-6
#: Approximations that are taken for what they are; all others are the mesh itself.
_KNOWN = ("none", "convexHull", "boundingCube", "boundingSphere")
#: Shapes that are formulas of a scene, too.
_CLOSED = ("Cube", "Sphere", "Plane", "Cylinder", "Capsule", "Cone")
#: Rotations, for rows, that take y to an axis.
_FROM_Y = {
    "X": np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    "Y": np.eye(3),
    "Z": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
}


@dataclass(frozen=True, slots=True)
class Fit:
    """The shape of a collider in a rigid frame of the world."""

    #: Fields of a shape of a scene; "mesh" has only its kind.
    shape: dict[str, Any]
    frame: Frame
    #: (n, 3) corners in the world, of a closed form those of the mesh that is drawn for it.
    corners: Callable[[], Float64]

    @property
    def kind(self) -> str:
        return str(self.shape["kind"])


def fit(collider: Collider, path: str, time: Any, moves: bool, notes: Notes) -> Fit | None:
    """The shape of a collider of the stage of a path; `None`, with a note, if there is none."""
    prim, world = collider.prim, collider.world

    def own() -> Float64:
        parts = StageReader(path, time, is_posed=False).parts_of(prim)
        return parts[0].points if parts else np.zeros((0, 3))

    def corners() -> Float64:
        points: Float64 = own() @ world[:3, :3] + world[3, :3]
        return points

    if not prim.IsA(UsdGeom.Mesh):
        found = _closed_form(path, prim, world, corners, time)
        if found is not None and found.kind == "half-space" and moves:
            notes.add("plane that moves", prim.GetPath())
            return None
        if found is not None:
            return found
    points = own()
    if not len(points):
        notes.add(f"collider of type {prim.GetTypeName()}", prim.GetPath())
        return None
    if prim.IsA(UsdGeom.Mesh):
        return _mesh(prim, world, points, moves, notes)
    return _hull(prim, world, points @ world[:3, :3] + world[3, :3], moves, notes)


def _mesh(prim: Any, world: Float64, own: Float64, moves: bool, notes: Notes) -> Fit | None:
    points: Float64 = own @ world[:3, :3] + world[3, :3]
    said = str(UsdPhysics.MeshCollisionAPI(prim).GetApproximationAttr().Get() or "none")
    if said not in _KNOWN:
        notes.add(f"approximation {said}", prim.GetPath(), "the mesh itself collides")
    lengths = scales(world)
    if said == "convexHull" or (said != "none" and said in _KNOWN and lengths is None):
        return _hull(prim, world, points, moves, notes)
    if said in ("boundingCube", "boundingSphere"):
        assert lengths is not None
        low, high = own.min(axis=0), own.max(axis=0)
        middle = 0.5 * (low + high) @ world[:3, :3] + world[3, :3]
        frame = Frame(frame_of(world).rotation, middle)
        if said == "boundingSphere":
            radius = float(np.linalg.norm(points - middle, axis=1).max())
            return Fit({"kind": "sphere", "radius": radius}, frame, lambda: points)
        return Fit(
            {"kind": "box", "size": tidy_list((high - low) * lengths)}, frame, lambda: points
        )
    return Fit({"kind": "mesh"}, frame_of(world), lambda: points)


def _hull(prim: Any, world: Float64, points: Float64, moves: bool, notes: Notes) -> Fit | None:
    frame = frame_of(world)
    if _is_flat(points):
        if moves:
            notes.add("flat convex hull that moves", prim.GetPath())
            return None
        return Fit({"kind": "mesh"}, frame, lambda: points)
    local = (points - frame.origin) @ frame.rotation.T
    return Fit({"kind": "hull", "points": _rows(outermost(local))}, frame, lambda: points)


def _is_flat(points: Float64) -> bool:
    sizes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(sizes[-1] <= FLAT * sizes[0]) or len(points) < 4


def outermost(points: Float64) -> Float64:
    """Points that are enough for the convex hull: all, or the outermost in `MOST_CORNERS`
    directions that cover the sphere evenly."""
    single: Float64 = np.unique(points, axis=0)
    if len(single) <= MOST_CORNERS:
        return single
    index = np.arange(MOST_CORNERS) + 0.5
    height = 1.0 - 2.0 * index / MOST_CORNERS
    turn = index * math.pi * (3.0 - math.sqrt(5.0))
    width = np.sqrt(1.0 - height**2)
    directions = np.stack([width * np.cos(turn), height, width * np.sin(turn)], axis=1)
    found: Float64 = single[np.unique(np.argmax(single @ directions.T, axis=0))]
    return found


def _closed_form(
    path: str, prim: Any, world: Float64, corners: Callable[[], Float64], time: Any
) -> Fit | None:
    """A shape that is a formula; `None` if its scale makes it another one."""
    lengths = scales(world)
    if lengths is None:
        return None

    def number(name: str) -> float:
        return length_of(path, prim, name, time)

    frame = frame_of(world)
    kind = str(prim.GetTypeName())
    if kind not in _CLOSED:
        return None
    if kind == "Cube":
        return Fit({"kind": "box", "size": tidy_list(number("size") * lengths)}, frame, corners)
    if kind == "Sphere":
        if not _are_equal(lengths):
            return None
        radius = tidy(number("radius") * lengths[0])
        return Fit({"kind": "sphere", "radius": radius}, frame, corners)

    # Around an axis, which becomes y.
    axis = str(prim.GetAttribute("axis").Get(time)) if prim.GetAttribute("axis") else "Z"
    row = "XYZ".index(axis)
    rotation = _FROM_Y[axis] @ frame.rotation
    upward = world[row, :3] / lengths[row]
    if rotation[1] @ upward < 0.0:
        rotation = np.diag([1.0, -1.0, -1.0]) @ rotation
    along, across = lengths[row], np.delete(lengths, row)
    origin = frame.origin
    if kind == "Plane":
        return Fit({"kind": "half-space"}, Frame(rotation, origin), corners)
    if not _are_equal(across):
        return None
    radius, height = tidy(number("radius") * across[0]), tidy(number("height") * along)
    if kind == "Capsule" and not _are_equal(lengths):
        return None
    if kind == "Cone":
        # Its centre of mass is below the middle of its height.
        origin = origin - 0.25 * height * rotation[1]
    shape = {"kind": kind.lower(), "radius": radius, "height": height}
    return Fit(shape, Frame(rotation, origin), corners)


def _are_equal(lengths: Float64) -> bool:
    return bool(np.ptp(lengths) <= 1e-6 * lengths.max())


def _rows(points: Float64) -> list[list[float]]:
    return [tidy_list(point) for point in points]
