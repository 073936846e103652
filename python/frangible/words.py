"""Words of sentences."""

from __future__ import annotations

import difflib
import json
from collections.abc import Iterable
from typing import Any


def counted(number: int, noun: str) -> str:
    """As in "1 piece" and "2 pieces"."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """The question " (did you mean 'wall'?)" where a known word is near, else nothing."""
    near = difflib.get_close_matches(word, [*known], 1, 0.6)
    return f" (did you mean {near[0]!r}?)" if near else ""


def shown(value: Any) -> str:
    """A value of a scene, shortened."""
    text = json.dumps(value, default=str)
    return text if len(text) <= 40 else f"{text[:36]} ..."
