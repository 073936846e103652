"""Axes, unit and times of the file that a scene came from, in which USD is written again."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass


@dataclass(frozen=True, slots=True)
class Convention:
    """Of a stage; ours by default."""

    #: "y" or "z".
    up_axis: str = "y"
    #: Metres in its unit.
    metres: float = 1.0
    #: The time code of the state before the first step.
    first_frame: float = 0.0

    def to_json(self) -> str:
        """For a cache."""
        return json.dumps(asdict(self))

    @staticmethod
    def from_json(text: str) -> Convention:
        """`ValueError` for any other text."""
        found = json.loads(text)
        if not isinstance(found, dict) or set(found) != set(Convention.__slots__):
            raise ValueError("convention: must be an object with up_axis, metres and first_frame")
        convention = Convention(**found)
        numbers = (convention.metres, convention.first_frame)
        if (
            convention.up_axis not in ("y", "z")
            or not all(type(number) in (int, float) and math.isfinite(number) for number in numbers)
            or not 1e-9 <= convention.metres <= 1e9
            or abs(convention.first_frame) > 1e9
        ):
            raise ValueError("convention: up_axis must be y or z, metres a number > 0")
        return convention
