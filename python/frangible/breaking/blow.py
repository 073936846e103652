"""Where a blow meets a mesh, and from which side."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .. import _frangible
from ..recording import Float64, UInt32

#: How far outside of the mesh's bounding box a blow may lie without a word; of its diagonal.
NEAR = 0.05


def unit_direction(normal: Sequence[float]) -> Float64:
    """A direction of length 1."""
    direction = np.array(normal, np.float64)
    length = np.linalg.norm(direction)
    if not np.all(np.isfinite(direction)) or length == 0.0:
        raise _frangible.BuildError(f"normal: {_listed(direction)}, must be finite and not zero")
    unit: Float64 = direction / length
    return unit


def finite_point(at: Sequence[float]) -> Float64:
    """A place in the mesh's frame [m]."""
    point = np.array(at, np.float64)
    if not np.all(np.isfinite(point)):
        raise _frangible.BuildError(f"at: {_listed(point)}, must be finite")
    return point


def landing_point(mesh: tuple[Float64, UInt32], normal: Float64) -> Float64:
    """Where a line against the normal through the middle of the bounding box first meets the mesh;
    without that, its vertex that is farthest along the normal."""
    vertices, triangles = mesh
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))

    # A triangle is met if the line passes its three edges on the same side.
    a, b, c = (vertices[triangles[:, corner]] - middle for corner in range(3))
    sides = np.stack(
        [np.cross(a, b) @ normal, np.cross(b, c) @ normal, np.cross(c, a) @ normal], axis=1
    )
    met = np.all(sides >= 0.0, axis=1) | np.all(sides <= 0.0, axis=1)
    facing = np.einsum("ij,ij->i", np.cross(b - a, c - a), np.broadcast_to(normal, a.shape))
    met &= facing != 0.0
    if not met.any():
        farthest: Float64 = vertices[np.argmax(vertices @ normal)]
        return farthest
    area_normals = np.cross(b - a, c - a)[met]
    heights = np.einsum("ij,ij->i", a[met], area_normals) / facing[met]
    landing: Float64 = middle + heights.max() * normal
    return landing


def far_off(mesh: tuple[Float64, UInt32], point: Float64, pieces: int) -> list[str]:
    """Sentences about a blow that does not meet the mesh, and a pattern that does not cut it."""
    low, high = mesh[0].min(axis=0), mesh[0].max(axis=0)
    off = float(np.linalg.norm(point - np.clip(point, low, high)))
    notes = []
    if off > NEAR * np.linalg.norm(high - low):
        where = f"{off:.3g} m outside of the mesh's bounding box"
        notes.append(f"the blow at {_listed(point)} lies {where}")
    if pieces == 1:
        notes.append("no crack of the pattern passes through the mesh, which stays in one piece")
    return notes


def _listed(vector: Float64) -> str:
    return f"({', '.join(f'{component:g}' for component in vector)})"
