"""Shapes of USD that are formulas, as meshes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import UsdGeom

from .._frangible import BuildError

#: Points (v, 3) in the prim's frame, corners of each polygon, and their points, counter-clockwise
#: from outside.
Faces = tuple[npt.NDArray[np.float64], npt.NDArray[np.int64], npt.NDArray[np.int64]]

#: Sides of what is round: no face is farther from the surface than a thousandth of the radius.
SIDES = 96
#: Bands of half a ball from the pole to the equator, as wide as a side is long.
BANDS = SIDES // 4


def length_of(path: str, prim: Any, name: str, time: Any) -> float:
    """An attribute that must be a number > 0."""
    value = float(prim.GetAttribute(name).Get(time))
    if not (math.isfinite(value) and value > 0.0):
        raise BuildError(f"{path}: the {name} of {prim.GetPath()}: {value}, must be a number > 0")
    return value


def faces_of(path: str, prim: Any, time: Any) -> Faces | None:
    """A cube, ball, cylinder, cone, capsule or plane; `None` for any other prim. Round shapes have
    their exact volume."""

    def length(name: str) -> float:
        return length_of(path, prim, name, time)

    def radii() -> tuple[float, float]:
        if prim.GetAttribute("radius"):
            return length("radius"), length("radius")
        return length("radiusBottom"), length("radiusTop")

    axis = str(prim.GetAttribute("axis").Get(time)) if prim.GetAttribute("axis") else "Z"
    match str(prim.GetTypeName()):
        case "Cube":
            return _cube(length("size"))
        case "Plane":
            return _plane(length("width"), length("length"), axis)
        case "Sphere":
            radius = length("radius")
            return _lathe(
                _arc(radius, -1.0, 0.0, 0.0) + _arc(radius, 0.0, 1.0, 0.0)[1:],
                "Z",
                4 / 3 * math.pi * radius**3,
            )
        case "Cone":
            radius, height = length("radius"), length("height")
            profile = [(0.0, -height / 2), (radius, -height / 2), (0.0, height / 2)]
            return _lathe(profile, axis, math.pi / 3 * radius**2 * height)
        case "Cylinder" | "Cylinder_1":
            (a, b), height = radii(), length("height")
            profile = [(0.0, -height / 2), (a, -height / 2), (b, height / 2), (0.0, height / 2)]
            return _lathe(profile, axis, _frustum(a, b, height))
        case "Capsule" | "Capsule_1":
            (a, b), height = radii(), length("height")
            profile = _arc(a, -1.0, 0.0, -height / 2) + _arc(b, 0.0, 1.0, height / 2)
            return _lathe(profile, axis, _frustum(a, b, height) + 2 / 3 * math.pi * (a**3 + b**3))
    return None


def _frustum(a: float, b: float, height: float) -> float:
    """Volume of a cone's part between two radii."""
    return math.pi / 3 * height * (a * a + a * b + b * b)


def _arc(radius: float, begin: float, end: float, centre: float) -> list[tuple[float, float]]:
    """Points (distance from the axis, place along it) of a quarter of a circle; 1 is its upper
    pole."""
    turns = [math.pi / 2 * (begin + (end - begin) * band / BANDS) for band in range(BANDS + 1)]
    # The poles are on the axis, without rounding.
    return [
        (
            0.0 if abs(turn) == math.pi / 2 else radius * math.cos(turn),
            centre + radius * math.sin(turn),
        )
        for turn in turns
    ]


def _lathe(profile: Sequence[tuple[float, float]], axis: str, volume: float) -> Faces:
    """The solid of revolution of a profile from the lower to the upper pole, made wider until it
    has that volume."""
    # Rings of points around z; a pole is one point.
    radii, places = np.array(profile, np.float64).T
    areas = 0.5 * SIDES * math.sin(2 * math.pi / SIDES)
    slabs = (
        areas / 3.0 * np.diff(places) * (radii[:-1] ** 2 + radii[:-1] * radii[1:] + radii[1:] ** 2)
    )
    radii = radii * math.sqrt(volume / slabs.sum())
    turns = 2 * np.pi / SIDES * np.arange(SIDES)
    circle = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    rings = [
        np.column_stack([radius * circle, np.full(SIDES, place)])
        if radius > 0.0
        else np.array([[0.0, 0.0, place]])
        for radius, place in zip(radii.tolist(), places.tolist(), strict=True)
    ]
    points = np.concatenate(rings)

    # A band of faces between each ring and the next one.
    polygons: list[npt.NDArray[np.int64]] = []
    first = 0
    for below, above in zip(rings[:-1], rings[1:], strict=True):
        low = first + np.arange(len(below))
        high = first + len(below) + np.arange(len(above))
        if len(below) == len(above):
            polygons += list(np.stack([low, np.roll(low, -1), np.roll(high, -1), high], axis=1))
        elif len(above) == 1:
            polygons += list(
                np.stack([low, np.roll(low, -1), np.broadcast_to(high, low.shape)], axis=1)
            )
        else:
            polygons += list(
                np.stack([high, np.broadcast_to(low, high.shape), np.roll(high, -1)], axis=1)
            )
        first += len(below)
    counts = np.array([len(polygon) for polygon in polygons], np.int64)
    return _along(points, axis), counts, np.concatenate(polygons).astype(np.int64)


def _along(points: npt.NDArray[np.float64], axis: str) -> npt.NDArray[np.float64]:
    """Points around z turned until they are around an axis."""
    columns = {UsdGeom.Tokens.x: [2, 0, 1], UsdGeom.Tokens.y: [1, 2, 0]}.get(axis)
    return points if columns is None else points[:, columns]


def _cube(size: float) -> Faces:
    points = size * np.array(
        [[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
    )
    corners = [0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3]
    return points, np.full(6, 4, np.int64), np.array(corners, np.int64)


def _plane(width: float, length: float, axis: str) -> Faces:
    """A rectangle that faces along an axis: its width is along x, or z if it faces along x; its
    length along y, or z."""
    x, y = 0.5 * width, 0.5 * length
    if axis == UsdGeom.Tokens.x:
        points = [[0.0, -y, -x], [0.0, y, -x], [0.0, y, x], [0.0, -y, x]]
    elif axis == UsdGeom.Tokens.y:
        points = [[-x, 0.0, -y], [-x, 0.0, y], [x, 0.0, y], [x, 0.0, -y]]
    else:
        points = [[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]]
    return np.array(points), np.array([4], np.int64), np.arange(4, dtype=np.int64)
