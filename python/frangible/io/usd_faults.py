"""Where in a stage's text its reader stopped."""

from __future__ import annotations

import re
from contextlib import suppress

from ..words import shortened

#: How USD says it: in the sentence of its parser, or of that of earlier versions.
_PLACES = (
    re.compile(
        r"'(?P<file>[^'\n]+?):(?P<line>\d+):\d+: (?P<what>[^\n]*?)(?: in <[^>\n]*>)?$", re.MULTILINE
    ),
    re.compile(
        r"(?P<what>[^\n']*?)(?: in <[^>\n]*>)? on line (?P<line>\d+) in file (?P<file>[^\n]+)"
    ),
)
#: A longer line is cut [columns].
WIDTH = 96


def syntax_fault(reason: BaseException) -> str | None:
    """The sentence about a syntax error, with its file and its line; `None` for another error."""
    found = next((match for one in _PLACES if (match := one.search(str(reason)))), None)
    if found is None:
        return None
    file, number, what = found["file"], int(found["line"]), found["what"].strip().rstrip(".")
    what = shortened(what, WIDTH)
    sentence = f"{file}, line {number}: {what}, must be USD text"
    with suppress(OSError, IndexError), open(file, encoding="utf-8", errors="replace") as text:
        line = text.read().splitlines()[number - 1].strip()
        return f"{sentence}\n  {number} | {shortened(line, WIDTH)}"
    return sentence
