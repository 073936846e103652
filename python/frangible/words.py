"""Words that were mistyped."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def counted(number: int, noun: str) -> str:
    """As in "1 piece" and "2 pieces"."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """The question " (did you mean 'wall'?)" where a known word is near, else nothing."""
    near = difflib.get_close_matches(word, [*known], 1, 0.6)
    return f" (did you mean {near[0]!r}?)" if near else ""
