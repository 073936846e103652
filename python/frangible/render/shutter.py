"""Motion blur: when a shutter is open, and where bodies are between two frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..recording import Body, Float64

#: Quaternions whose dot product is larger turn by less than 0.4 degrees: their great circle is a
#: line to single precision.
_NEAR = 1.0 - 1e-6


@dataclass(frozen=True, slots=True)
class Shutter:
    """Open for a part of a frame, and closed as the frame is there.

    What a frame shows was there all the time then: a break between two frames needs no guess.
    """

    #: 360 is a whole frame, 0 no motion blur.
    degrees: float = 0.0
    #: Times at which a picture looks.
    samples: int = 8

    def times(self, frame: int) -> list[float]:
        """The latest first [frames]."""
        if self.degrees == 0.0 or self.samples < 2:
            return [float(frame)]
        step = self.degrees / 360.0 / self.samples
        return [frame - step * (index + 0.5) for index in range(self.samples)]


#: No motion blur.
CLOSED = Shutter()


def pose_between(body: Body, time: float) -> tuple[Float64, Float64]:
    """Position (3,) [m] and orientation (4,) at a time [frames] of its life or up to a frame before
    it: on a line, and turning at a constant rate, from frame to frame."""
    frame = int(np.ceil(time))
    if frame == time:
        return body.pose(frame)
    position, turn = body.pose(frame)
    before, turn_before = _pose_before(body, frame)
    share = time - (frame - 1)
    return before + share * (position - before), _slerp(turn_before, turn, share)


def moves_between(body: Body, earliest: float, frame: int) -> bool:
    """True if a body is not at rest from a time within the frame before to a frame."""
    now, then = body.pose(frame), pose_between(body, earliest)
    return bool(np.any(now[0] != then[0]) or np.any(now[1] != then[1]))


def _pose_before(body: Body, frame: int) -> tuple[Float64, Float64]:
    if frame > body.birth_frame:
        return body.pose(frame - 1)
    position, turn = body.pose(frame)
    if body.before is not None:
        return body.before[:3], body.before[3:]
    if frame > 0 or len(body.positions) < 2:
        return position, turn
    # Before the first frame it came as it goes on.
    after, turn_after = body.pose(frame + 1)
    return 2.0 * position - after, _slerp(turn, turn_after, -1.0)


def _slerp(start: Float64, end: Float64, share: float) -> Float64:
    """From one unit quaternion the short way to another (Shoemake 1985)."""
    cosine = float(start @ end)
    end = -end if cosine < 0.0 else end
    if abs(cosine) > _NEAR:
        mixed = start + share * (end - start)
    else:
        angle = np.arccos(min(abs(cosine), 1.0))
        mixed = np.sin((1.0 - share) * angle) * start + np.sin(share * angle) * end
    unit: Float64 = mixed / np.linalg.norm(mixed)
    return unit
