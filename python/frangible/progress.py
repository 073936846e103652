"""How far a run is, on stderr: a bar on a terminal, a line for every tenth in a pipe."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from .recording import ProgressCallback


@contextmanager
def report_progress(frames: int) -> Iterator[ProgressCallback]:
    """A callback for `step_frames` that shows frame, bodies and the time left."""
    if sys.stderr.isatty():
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
                print(f"frame {frame}/{frames}, {bodies} bodies, {left:.0f} s left", file=sys.stderr, flush=True)

        yield line
