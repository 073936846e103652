"""Signals that end a command early.

Of a run the first ends the frame that is simulated, and its outputs are written; the second ends at
once.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

#: Signals of Ctrl-C and of a polite kill.
SIGNALS = (signal.SIGINT, signal.SIGTERM)

#: True while the process does nothing but one command.
_is_command = False


@contextmanager
def own_process() -> Iterator[None]:
    """While the context lasts, the process does nothing but one command: signals may end it."""
    global _is_command
    before, _is_command = _is_command, True
    try:
        yield
    finally:
        _is_command = before


@contextmanager
def deaf_work() -> Iterator[None]:
    """For calls into libraries that keep Python's lock, so that no handler runs until they return.

    In a process of our own signals end it at once while the context lasts, without a word: nothing
    may be open that has to be put away. Elsewhere they wait for the end of the call.
    """
    if not _is_command or threading.current_thread() is not threading.main_thread():
        yield
        return
    # Signals that the caller ignores, or that are handled outside of Python, stay as they are.
    heard = [one for one in SIGNALS if signal.getsignal(one) not in (signal.SIG_IGN, None)]
    before = {one: signal.signal(one, signal.SIG_DFL) for one in heard}
    try:
        yield
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)


class Stop:
    """True if a run was asked to stop, and by which signal."""

    def __init__(self) -> None:
        self.signal: int | None = None

    def __call__(self) -> bool:
        return self.signal is not None


@contextmanager
def stop_when_asked(stop_step: Callable[[], None]) -> Iterator[Stop]:
    """While the context lasts, the first signal is noted and calls ``stop_step``, and the second
    ends the process at once."""
    stop = Stop()

    def note(number: int, _: FrameType | None) -> None:
        stop.signal = number
        stop_step()
        for one in SIGNALS:
            signal.signal(one, signal.SIG_DFL)

    before = {one: signal.signal(one, note) for one in SIGNALS}
    try:
        yield stop
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)
