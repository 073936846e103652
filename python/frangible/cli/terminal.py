"""Sentences and results for people, on a terminal or in a pipe."""

from __future__ import annotations

import os
import sys
from contextlib import suppress

from ..words import for_terminal


def say(sentence: str) -> None:
    """A line on stderr."""
    print(for_terminal(sentence), file=sys.stderr, flush=True)


def show(result: str) -> None:
    """Lines on stdout."""
    print(for_terminal(result))


def flushed() -> bool:
    """True once all that was printed is out; if it cannot be, nobody tries again."""
    try:
        sys.stdout.flush()
    except OSError:
        with suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return False
    return True
