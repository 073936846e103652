"""How far long work is, on stderr: for a run a bar on a terminal, a line for every tenth in a
pipe."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from .recording import ProgressCallback

#: Told what begins.
StageCallback = Callable[[str], None]
#: A stage that takes longer is worth a line [s].
LONG_STAGE = 1.0


def no_stage(_: str) -> None:
    """A `StageCallback` that says nothing."""


@contextmanager
def report_stages(quiet: bool = False) -> Iterator[StageCallback]:
    """A callback for what begins; a line on stderr for each stage that is not over within a second;
    none if quiet."""
    waiting: list[threading.Timer] = []

    def begin(stage: str) -> None:
        for timer in waiting:
            timer.cancel()
        if quiet:
            return
        line = f"frangible: {stage} ..."
        waiting[:] = [
            threading.Timer(LONG_STAGE, print, [line], {"file": sys.stderr, "flush": True})
        ]
        waiting[0].daemon = True
        waiting[0].start()

    try:
        yield begin
    finally:
        for timer in waiting:
            timer.cancel()


@contextmanager
def report_progress(frames: int, quiet: bool = False) -> Iterator[ProgressCallback | None]:
    """A callback for `step_frames` that shows frame, bodies and the time left; none if quiet."""
    if quiet:
        yield None
    elif sys.stderr.isatty():
        with Progress(
            TextColumn("frame"),
            MofNCompleteColumn(),
            BarColumn(),
            TextColumn("{task.fields[bodies]} bodies"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        ) as bar:
            task = bar.add_task("", total=frames, bodies=0)
            yield lambda frame, bodies: bar.update(task, completed=frame, bodies=bodies)
    else:
        begin = time.monotonic()

        def line(frame: int, bodies: int) -> None:
            if frame * 10 // frames > (frame - 1) * 10 // frames:
                left = (time.monotonic() - begin) / frame * (frames - frame)
                print(
                    f"frame {frame}/{frames}, {bodies} bodies, {left:.0f} s left",
                    file=sys.stderr,
                    flush=True,
                )

        yield line
