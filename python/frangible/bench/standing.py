"""Whether what was built stands: a wall that fell is fast to step, and overlaps little."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..recording import Float64


@dataclass(frozen=True, slots=True)
class Standing:
    """How some pieces are at the end of a run."""

    #: Of those that there were at first, the share that is where it was, by half of its least
    #: width.
    share: float
    #: Of the centres of those that are left [m].
    median_height: float


def standing(start: Float64, end: Float64, widths: Float64) -> Standing:
    """Of pieces with these centres (n, 3) at first and at last and these least widths (n,), all in
    metres; what is gone is not a number at last."""
    if len(start) == 0:
        return Standing(0.0, 0.0)
    with np.errstate(invalid="ignore"):
        stands = np.linalg.norm(end - start, axis=1) < 0.5 * widths
    heights = end[np.isfinite(end).all(axis=1), 1]
    return Standing(float(stands.mean()), float(np.median(heights)) if len(heights) else 0.0)
