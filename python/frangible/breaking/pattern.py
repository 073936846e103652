"""Patterns as files and pictures."""

from __future__ import annotations

import numpy as np

from .._frangible import Pattern
from ..io.output import check_destination
from ..io.whole import whole_file
from ..recording import Body, Recording

#: How far cells are pulled apart: the way of a cell's centre from the middle of the box, relative
#: to what it was.
PULLED_APART = 1.35
#: What a pattern is written as, and the extra that it takes.
ENDINGS = {".json": None, ".png": "render"}


def check_pattern_file(path: str) -> None:
    """Check that a pattern or its picture can be written there; `OutputError` if not."""
    check_destination(path, ENDINGS)


def write_pattern(pattern: Pattern, path: str) -> None:
    """Write the pattern, or for a .png its picture with the cells pulled apart."""
    with whole_file(path) as part:
        if path.lower().endswith(".png"):
            _write_picture(pattern, part)
        else:
            pattern.save(part)


def _write_picture(pattern: Pattern, path: str) -> None:
    from ..render.picture import write_png

    write_png(exploded(pattern), path, 0)


def exploded(pattern: Pattern, apart: float = PULLED_APART) -> Recording:
    """One frame of the cells, each pulled away from the middle of the box; mortar in the colour of
    cracks."""
    bodies = [_piece(pattern, cell, apart) for cell in range(len(pattern))]
    return Recording(shot="pattern", method="", fps=1.0, frames=0, bodies=bodies)


def _piece(pattern: Pattern, cell: int, apart: float) -> Body:
    vertices, triangles = pattern.region_mesh(cell)
    low, high = (
        (vertices.min(axis=0), vertices.max(axis=0))
        if len(vertices)
        else (np.zeros(3), np.zeros(3))
    )
    centre = (low + high) / 2
    return Body(
        id=cell + 1,
        name=f"cell{cell}",
        # As pieces of one body they differ in tint.
        parent=0,
        source=0,
        birth_frame=0,
        death_frame=None,
        mass=float(np.prod(high - low)),
        look=None,
        vertices=(vertices - centre).astype(np.float32),
        triangles=triangles,
        interior=np.full(len(triangles), pattern.is_joint(cell)),
        coordinates=np.zeros((len(triangles), 3, 2), np.float32),
        positions=apart * centre[None],
        orientations=np.array([[0.0, 0.0, 0.0, 1.0]]),
    )


def describe_pattern(pattern: Pattern) -> dict[str, object]:
    """Facts to print, in order."""
    faces, corners, volumes, inner = pattern.shapes()
    share = volumes / volumes.sum()
    return {
        "cells": len(pattern),
        "joints": sum(pattern.is_joint(cell) for cell in range(len(pattern))),
        "inner_cells": int(inner.sum()),
        "mean_faces": float(faces.mean()),
        "mean_corners": float(corners.mean()),
        "largest_share": float(share.max()),
        "smallest_share": float(share.min()),
    }
