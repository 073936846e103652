"""Writes what the options name."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

from ..convention import Convention
from ..io.drawing import View
from ..io.output import Output, open_output
from ..recording import Recording
from ..render.camera import check_camera
from ..render.shutter import Shutter
from ..words import for_terminal
from .options import EXIT_FAILED
from .results import print_json
from .terminal import say


def open_outputs(options: argparse.Namespace) -> list[Output]:
    """The outputs that ``--out`` names, seen as the options of `add_view` say."""
    outputs = []
    for path in options.out:
        progress = None if options.quiet else _progress(path)
        view = View(
            options.camera,
            options.size,
            progress,
            Shutter(options.shutter, options.samples or Shutter().samples),
            options.renderer,
            options.samples or View().rays,
            getattr(options, "first", 0),
            getattr(options, "last", None),
        )
        outputs.append(open_output(path, options.frame, view))
    return outputs


def check_view(options: argparse.Namespace, convention: Convention) -> None:
    """`CameraError` if the camera is of a stage that has none."""
    check_camera(options.camera, convention.cameras)


def _progress(path: str) -> Callable[[int, int], None]:
    """Says how much is drawn, and how long the rest takes: in a pipe a line for every tenth, on a
    terminal one line that changes."""
    begin: list[tuple[float, int]] = []

    def line(done: int, whole: int) -> None:
        now = time.monotonic()
        begin[:] = begin or [(now, done)]
        is_terminal = sys.stderr.isatty()
        parts = 100 if is_terminal else 10
        if done * parts // whole == (done - 1) * parts // whole:
            return
        since, first = begin[0]
        left = (now - since) / max(done - first, 1) * (whole - done)
        said = f"drawing {for_terminal(path)}: {100 * done // whole} %"
        said += f", {left:.0f} s left" if done > first else ""
        if is_terminal:
            # The rest of a longer line before is wiped away.
            print(f"\r{said}\x1b[K", end="\n" if done == whole else "", file=sys.stderr, flush=True)
        else:
            print(said, file=sys.stderr, flush=True)

    return line


@dataclass(frozen=True, slots=True)
class Written:
    """What became of an output."""

    path: str
    #: The reason why it could not be written.
    error: str | None = None

    def as_json(self) -> dict[str, object]:
        """For ``--json``."""
        if self.error is not None:
            return {"path": self.path, "error": self.error}
        is_file = os.path.isfile(self.path)
        return {"path": self.path, "bytes": os.path.getsize(self.path) if is_file else None}


def write(
    outputs: list[Output], recording: Recording, quiet: bool = False, as_json: bool = False
) -> int:
    """Each output, with a line for each on stderr; those that fail do not keep the others. The exit
    status."""
    done = []
    for output in outputs:
        try:
            output.write(recording)
        except (OSError, ValueError, RuntimeError, MemoryError) as error:
            said = getattr(error, "strerror", None) or str(error) or type(error).__name__
            sentence = said if said.startswith(output.path) else f"{output.path}: {said}"
            say(f"frangible: {sentence}")
            done.append(Written(output.path, sentence))
            continue
        done.append(Written(output.path))
        if not quiet:
            say(f"wrote {output.path}{_size(output.path)}")
    status = EXIT_FAILED if any(one.error for one in done) else 0
    if as_json:
        print_json({"outputs": [one.as_json() for one in done], "status": status})
    return status


def _size(path: str) -> str:
    """Of a file, for people; of a pipe and a folder, nothing."""
    return f", {os.path.getsize(path) / 2**20:.3g} MiB" if os.path.isfile(path) else ""
