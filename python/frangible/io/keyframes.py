"""Motion trimmed to the samples that players need."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..recording import Float64


def telling_samples(values: Float64) -> npt.NDArray[np.intp]:
    """Rows of (k, n) that linear interpolation needs: inside a run of equal rows only its ends, and
    one row if all are equal."""
    if len(values) < 2 or not np.any(values[1:] != values[:-1]):
        return np.arange(min(len(values), 1))
    same_as_last = np.concatenate([[False], np.all(values[1:] == values[:-1], axis=1)])
    same_as_next = np.concatenate([same_as_last[1:], [False]])
    return np.flatnonzero(~(same_as_last & same_as_next))
