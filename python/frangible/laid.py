"""What lays skins on surfaces that were recorded."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

from .skin import Skin

#: Vertices, triangles, which of them a crack made, and texture coordinates; and the frame of the
#: material in the body frame.
Recorded = tuple[
    tuple[
        npt.NDArray[np.float32],
        npt.NDArray[np.uint32],
        npt.NDArray[np.bool_],
        npt.NDArray[np.float32],
    ],
    tuple[list[float], list[float]],
]


class Laid(Protocol):
    """Anything that lays skins on the surfaces of bodies."""

    def lay_on(self, surfaces: list[Recorded]) -> list[tuple[Skin, npt.NDArray[np.float32]]]:
        """The skins and the texture coordinates of the surfaces."""
