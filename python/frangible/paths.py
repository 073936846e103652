"""Motion trimmed for players, and names for scene graphs."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

import numpy as np
import numpy.typing as npt

from .recording import Body, Float64


def telling_samples(values: Float64) -> npt.NDArray[np.intp]:
    """Rows of (k, n) that linear interpolation needs: inside a run of equal rows only its ends, and one row if all are equal."""
    if len(values) < 2 or not np.any(values[1:] != values[:-1]):
        return np.arange(min(len(values), 1))
    same_as_last = np.concatenate([[False], np.all(values[1:] == values[:-1], axis=1)])
    same_as_next = np.concatenate([same_as_last[1:], [False]])
    return np.flatnonzero(~(same_as_last & same_as_next))


def unique_names(names: Iterable[str]) -> Iterator[str]:
    """Identifiers made of letters, digits and underscores, each different from those before."""
    taken: set[str] = set()
    for name in names:
        identifier = re.sub(r"[^A-Za-z0-9_]", "_", name) or "body"
        if identifier[0].isdigit():
            identifier = f"_{identifier}"
        candidate, count = identifier, 1
        while candidate in taken:
            count += 1
            candidate = f"{identifier}_{count}"
        taken.add(candidate)
        yield candidate


def by_source(bodies: Iterable[Body]) -> dict[int, list[Body]]:
    """The bodies of each source, itself first."""
    families: dict[int, list[Body]] = {}
    for body in bodies:
        families.setdefault(body.source, []).append(body)
    return families
