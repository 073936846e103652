"""Meshes of a USD stage before they are written as one file."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..recording import Float64, Int64


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
