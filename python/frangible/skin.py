"""Attributes of a surface from a mesh file: materials, colours, normals, and the names above it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .materials import Material

#: The material of a triangle that has none of the file's.
NO_MATERIAL = -1


@dataclass(frozen=True, slots=True, eq=False)
class Skin:
    """Of the triangles (t,) of a body or a piece. Their texture coordinates are the body's own
    field."""

    #: Shared by all bodies that broke off from the same mesh.
    materials: tuple[Material, ...]
    #: (t,) index of each triangle's material, `NO_MATERIAL` for what the body's look decides.
    material: npt.NDArray[np.int32]
    #: (t, 3, 4) linear red, green, blue and opacity of the corners, to be multiplied with the
    #: material's; `None` without any.
    colours: npt.NDArray[np.float32] | None = None
    #: (t, 3, 3) unit normals of the corners, body frame, zero where the file gives none; `None`
    #: without any.
    normals: npt.NDArray[np.float32] | None = None
    #: Names of the nodes above it in its file, the root's first.
    path: tuple[str, ...] = ()
