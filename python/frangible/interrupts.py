"""Signals that end a run early: the first lets the frame end and its outputs be written, the second ends at once."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

#: Signals of Ctrl-C and of a polite kill.
SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Stop:
    """True if a run was asked to stop, and by which signal."""

    def __init__(self) -> None:
        self.signal: int | None = None

    def __call__(self) -> bool:
        return self.signal is not None


@contextmanager
def stop_when_asked() -> Iterator[Stop]:
    """While the context lasts, the first signal is noted and the second ends the process, also in the middle of a frame."""
    stop = Stop()

    def note(number: int, _: FrameType | None) -> None:
        stop.signal = number
        for one in SIGNALS:
            signal.signal(one, signal.SIG_DFL)

    before = {one: signal.signal(one, note) for one in SIGNALS}
    try:
        yield stop
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)
