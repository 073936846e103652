"""Volumes of a mesh, of its grid and of what is written, and the sentence where they differ."""

from __future__ import annotations

import math

import numpy as np

from ..recording import Float64, UInt32

#: Volumes may differ by so much without a word.
SILENT_WITHIN = 0.01
#: Voxels that a part has to be thick for its volume to come out.
VOXELS_THICK = 3.0
#: A grid of more along the longest side is not worth asking for.
MOST_VOXELS = 1024


def volumes_differ(
    mesh: tuple[Float64, UInt32],
    whole: float,
    on_grid: float,
    written: float | None,
    voxels: float,
    how: str = "--voxels {}",
) -> str | None:
    """The sentence that grid or written surface hold another volume [m^3] than the mesh; `None` if
    they do not.

    ``how`` says how to ask for more voxels along the longest side.
    """
    held = {"the grid holds": on_grid} | (
        {} if written is None else {"the pieces' surfaces enclose": written}
    )
    differing = [
        f"{what} {volume:.4g} m^3 ({volume / whole - 1.0:+.1%})"
        for what, volume in held.items()
        if abs(volume / whole - 1.0) > SILENT_WITHIN
    ]
    if not differing:
        return None
    vertices, triangles = mesh
    corners = vertices[triangles]
    area = 0.5 * float(
        np.linalg.norm(
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
        ).sum()
    )
    longest = float(np.ptp(vertices, axis=0).max())
    thickness = 2.0 * whole / area
    needed = math.ceil(VOXELS_THICK * longest / thickness)
    sentence = (
        f"the mesh encloses {whole:.4g} m^3, but {' and '.join(differing)}: a voxel is "
        f"{longest / voxels:.3g} m wide"
    )
    if voxels < needed <= MOST_VOXELS:
        sentence += (
            f", and {how.format(needed)} would resolve its parts, about {thickness:.3g} m thick"
        )
    return sentence
