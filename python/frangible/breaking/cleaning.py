"""Meshes as they come out of cleaning."""

from __future__ import annotations

from typing import TypedDict

import numpy as np
import numpy.typing as npt

#: Of a surface that crosses itself this part of its area may lie in the solid: folds whose volume
#: is below a percent.
MOST_BURIED = 0.01


class CleanMesh(TypedDict):
    """Raw triangles made into solids."""

    #: (v, 3) [m].
    vertices: npt.NDArray[np.float64]
    #: (t, 3) of closed surfaces; those of solids face outward, those of cavities inward.
    triangles: npt.NDArray[np.uint32]
    #: (t,) the raw triangle that it is, or is a part of; -1 if it closes a hole. The corners of a
    #: whole one begin with the same; of one that was turned the last two changed places.
    source: npt.NDArray[np.int64]
    #: (t,) the solid that it bounds, counted from zero; solids may cross or touch.
    solid: npt.NDArray[np.uint32]
    #: (s,) whether another solid may cross or touch it, or lie in it.
    meets: npt.NDArray[np.bool_]
    #: (s,) the part of its surface that lies in it, by area: 0 if it does not cross itself.
    buried: npt.NDArray[np.float64]
    #: Voxels along x, y and z of its grid in a simulation, without a resolution of its own.
    voxels: list[int]
    #: How many were closed.
    holes: int
    #: The repairs, in sentences.
    notes: list[str]
