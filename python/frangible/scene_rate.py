"""Another number of frames a second for a scene: what it says in frames comes at the same times."""

from __future__ import annotations

import math
from typing import Any

#: Of a scene that says nothing [1/s].
RATE = 30.0


def set_rate(scene: dict[str, Any], fps: float) -> None:
    """Set ``frames_per_second``; length, keys of paths and starts of bodies stay at their times.
    What is no number is left to the engine."""
    rate = scene.get("frames_per_second", RATE)
    scene["frames_per_second"] = fps
    if not isinstance(rate, (int, float)) or not 0 < rate < math.inf or not 0 < fps < math.inf:
        return
    factor = fps / rate
    if isinstance(scene.get("frames"), int):
        scene["frames"] = max(1, math.ceil(scene["frames"] * factor))
    bodies = scene.get("bodies")
    for body in bodies if isinstance(bodies, list) else []:
        if not isinstance(body, dict):
            continue
        path, starts = body.get("path"), body.get("starts")
        for key in path if isinstance(path, list) else []:
            if isinstance(key, dict) and isinstance(key.get("frame"), (int, float)):
                key["frame"] *= factor
        if isinstance(starts, dict) and isinstance(starts.get("frame"), int):
            # At the end of the frame that is nearest.
            starts["frame"] = round(starts["frame"] * factor)
