"""Where a ball that flies straight first touches a mesh."""

from __future__ import annotations

from typing import Any

import numpy as np

from .recording import Float64


def first_touch(
    points: Float64, triangles: Any, through: Float64, direction: Float64, radius: float
) -> float | None:
    """Place of the ball's centre on its line at the first touch, from a point of the line along its
    unit direction [m]; `None` if it misses.

    The surface at a distance of the radius from the mesh is made of triangles beside its
    triangles, cylinders around its edges and balls around its vertices: the line first meets one of
    those.
    """
    corners = (points - through)[triangles.astype(np.int64)]
    found = [
        _faces(corners, direction, radius),
        _edges(corners, direction, radius),
        _vertices(points - through, direction, radius),
    ]
    places = np.concatenate(found)
    return float(places.min()) if len(places) else None


def _faces(corners: Float64, direction: Float64, radius: float) -> Float64:
    """Both sides of each triangle, moved out by the radius."""
    sides = corners[:, 1:] - corners[:, :1]
    normals = np.cross(sides[:, 0], sides[:, 1])
    lengths = np.linalg.norm(normals, axis=1)
    is_flat = lengths > 0.0
    corners, normals = corners[is_flat], normals[is_flat] / lengths[is_flat, None]
    slope = normals @ direction
    faces_it = slope != 0.0
    corners, normals, slope = corners[faces_it], normals[faces_it], slope[faces_it]
    # The side that the ball comes to.
    normals, slope = -np.sign(slope)[:, None] * normals, -np.abs(slope)
    places = (radius - np.einsum("ij,ij->i", -corners[:, 0], normals)) / slope
    feet = places[:, None] * direction - radius * normals
    turns = [
        np.einsum(
            "ij,ij->i",
            np.cross(corners[:, (k + 1) % 3] - corners[:, k], feet - corners[:, k]),
            normals,
        )
        for k in range(3)
    ]
    inside = (np.min(turns, axis=0) >= 0.0) | (np.max(turns, axis=0) <= 0.0)
    return np.asarray(places[inside])


def _edges(corners: Float64, direction: Float64, radius: float) -> Float64:
    """A cylinder around each edge, without its ends."""
    starts = corners.reshape(-1, 3)
    ways = np.roll(corners, -1, axis=1).reshape(-1, 3) - starts
    lengths = np.linalg.norm(ways, axis=1)
    starts, ways, lengths = (of[lengths > 0.0] for of in (starts, ways, lengths))
    axes = ways / lengths[:, None]
    # Across the axis.
    across = direction - (axes @ direction)[:, None] * axes
    offset = -starts + np.einsum("ij,ij->i", starts, axes)[:, None] * axes
    a = np.einsum("ij,ij->i", across, across)
    b = np.einsum("ij,ij->i", across, offset)
    c = np.einsum("ij,ij->i", offset, offset) - radius**2
    inner = b**2 - a * c
    meets = (inner >= 0.0) & (a > 0.0)
    places = (-b[meets] - np.sqrt(inner[meets])) / a[meets]
    along = np.einsum("ij,ij->i", places[:, None] * direction - starts[meets], axes[meets])
    return np.asarray(places[(along >= 0.0) & (along <= lengths[meets])])


def _vertices(points: Float64, direction: Float64, radius: float) -> Float64:
    """A ball around each vertex."""
    along = points @ direction
    aside = np.einsum("ij,ij->i", points, points) - along**2
    near = aside <= radius**2
    return np.asarray(along[near] - np.sqrt(radius**2 - aside[near]))
