"""A camera of the stage that a scene came from, as caches carry it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

#: No stage has a longer film [frames].
_MOST_ROWS = 1_000_000


@dataclass(frozen=True, slots=True)
class StageCamera:
    """One pose for each time code of the stage from its first one on, or one for all; in metres, y
    up."""

    #: The prim's path.
    name: str
    #: Rows in a second.
    fps: float
    #: Places (n, 3) [m].
    eyes: tuple[tuple[float, ...], ...]
    #: World from camera (n, 4), quaternions x, y, z, w; a camera looks along its -z, its y is up.
    orientations: tuple[tuple[float, ...], ...]
    #: Half the width and height (n, 2) of what the lens shows at distance 1.
    lenses: tuple[tuple[float, ...], ...]

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)

    @staticmethod
    def from_dict(found: object) -> StageCamera:
        """`ValueError` for anything else."""
        if not isinstance(found, Mapping) or set(found) != set(StageCamera.__slots__):
            raise ValueError("cameras: must be objects with name, fps, eyes, orientations, lenses")
        name, fps = found["name"], found["fps"]
        if not isinstance(name, str) or not _is_number(fps) or not fps > 0:
            raise ValueError("cameras: name must be text, fps a number > 0")
        eyes, turns, lenses = (
            _rows(found[key], width)
            for key, width in (("eyes", 3), ("orientations", 4), ("lenses", 2))
        )
        if not 1 <= len(eyes) <= _MOST_ROWS or not len(eyes) == len(turns) == len(lenses):
            raise ValueError("cameras: must have as many eyes as orientations and lenses")
        if any(abs(math.hypot(*turn) - 1.0) > 1e-5 for turn in turns):
            raise ValueError("cameras: orientations must be unit quaternions")
        if any(min(lens) <= 0.0 for lens in lenses):
            raise ValueError("cameras: lenses must be > 0")
        return StageCamera(name, float(fps), eyes, turns, lenses)


def _rows(found: object, width: int) -> tuple[tuple[float, ...], ...]:
    if not isinstance(found, list) or not all(
        isinstance(row, list) and len(row) == width and all(map(_is_number, row)) for row in found
    ):
        raise ValueError(f"cameras: must be lists of {width} numbers")
    return tuple(tuple(map(float, row)) for row in found)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e9
