"""Axes, unit and times of the file that a scene came from, in which USD is written again."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass

from .stage_camera import StageCamera

#: Of a cache whose stage has no camera, and of older ones.
_OPTIONAL = {"cameras"}


@dataclass(frozen=True, slots=True)
class Convention:
    """Of a stage; ours by default."""

    #: "y" or "z".
    up_axis: str = "y"
    #: Metres in its unit.
    metres: float = 1.0
    #: The time code of the state before the first step.
    first_frame: float = 0.0
    #: The stage's, the one first that it renders with.
    cameras: tuple[StageCamera, ...] = ()

    def to_json(self) -> str:
        """For a cache."""
        fields = asdict(self)
        if not self.cameras:
            del fields["cameras"]
        return json.dumps(fields)

    @staticmethod
    def from_json(text: str) -> Convention:
        """`ValueError` for any other text."""
        found = json.loads(text)
        known = set(Convention.__slots__)
        if not isinstance(found, dict) or not known - _OPTIONAL <= set(found) <= known:
            raise ValueError("convention: must be an object with up_axis, metres and first_frame")
        cameras = found.pop("cameras", [])
        if not isinstance(cameras, list):
            raise ValueError("convention: cameras must be a list")
        convention = Convention(**found, cameras=tuple(map(StageCamera.from_dict, cameras)))
        numbers = (convention.metres, convention.first_frame)
        if (
            convention.up_axis not in ("y", "z")
            or not all(type(number) in (int, float) and math.isfinite(number) for number in numbers)
            or not 1e-9 <= convention.metres <= 1e9
            or abs(convention.first_frame) > 1e9
        ):
            raise ValueError("convention: up_axis must be y or z, metres a number > 0")
        return convention
