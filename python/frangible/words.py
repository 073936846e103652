"""Words of sentences."""

from __future__ import annotations

import difflib
import json
import re
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
    return shortened(json.dumps(value, default=str))


def shortened(text: str, most: int = 40) -> str:
    """A text of so many characters at most."""
    return text if len(text) <= most else f"{text[: most - 4]} ..."


#: What a terminal obeys, or shows in another order than it is written in, and what is no text.
_UNSEEN = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)
#: The longest line that is printed [characters].
_LONGEST_LINE = 1000


def for_terminal(text: str) -> str:
    """A text as it may be printed, whatever names of files and bodies are in it: characters that a
    terminal obeys are escaped, and long lines cut."""
    lines = (shortened(line, _LONGEST_LINE) for line in text.split("\n"))
    return _UNSEEN.sub(lambda found: f"\\u{{{ord(found[0]):x}}}", "\n".join(lines))
