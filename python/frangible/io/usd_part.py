"""Meshes of a USD stage before they are written as one file."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..recording import Bool, Float64, Int64


@dataclass(frozen=True, slots=True)
class Part:
    """One mesh or shape of a stage, or one instance of it."""

    #: The prim's path; of an instance of an instancer with its number behind it.
    name: str
    #: The prim that materials are bound to, and primvars are of.
    prim: Any
    #: (v, 3) [m], y up; in the prim's order.
    points: Float64
    #: Corners of each polygon (f,), and their points, counter-clockwise from outside.
    counts: Int64
    corners: Int64
    #: The number in the prim's own order of each polygon, and of each corner.
    faces: Int64
    order: Int64
    #: The matrix that its points were multiplied with so far, as rows.
    linear: Float64 = field(default_factory=lambda: np.eye(3))


def moved(part: Part, matrix: Float64) -> Part:
    """A part under a transform; USD multiplies rows. A transform that mirrors turns the polygons
    round, too."""
    # The core refuses numbers that are not finite.
    with np.errstate(invalid="ignore", over="ignore"):
        points = part.points @ matrix[:3, :3] + matrix[3, :3]
        is_mirrored = bool(np.linalg.det(matrix[:3, :3]) < 0.0)
    placed = replace(part, points=points, linear=part.linear @ matrix[:3, :3])
    return turned(placed) if is_mirrored else placed


def turned(part: Part) -> Part:
    """The part with its corners in the opposite order."""
    ends = np.cumsum(part.counts)
    swap = np.repeat(2 * ends - part.counts - 1, part.counts) - np.arange(len(part.corners))
    return replace(part, corners=part.corners[swap], order=part.order[swap])


def kept(part: Part, keep: Bool) -> Part:
    """The part with some of its polygons."""
    corners = np.repeat(keep, part.counts)
    return replace(
        part,
        counts=part.counts[keep],
        corners=part.corners[corners],
        faces=part.faces[keep],
        order=part.order[corners],
    )
