"""Writes what the options name."""

from __future__ import annotations

import os
import sys

from ..output import Output
from ..recording import Recording
from .options import EXIT_FAILED


def write(outputs: list[Output], recording: Recording, quiet: bool = False) -> int:
    """Each output, with a line for each on stderr; those that fail do not keep the others. The exit status."""
    status = 0
    for output in outputs:
        try:
            output.write(recording)
        except (OSError, ValueError, RuntimeError, MemoryError) as error:
            said = getattr(error, "strerror", None) or str(error) or type(error).__name__
            sentence = said if said.startswith(output.path) else f"{output.path}: {said}"
            print(f"frangible: {sentence}", file=sys.stderr, flush=True)
            status = EXIT_FAILED
            continue
        if not quiet:
            print(f"wrote {output.path}{_size(output.path)}", file=sys.stderr)
    return status


def _size(path: str) -> str:
    """Of a file, for people; of a pipe and a folder, nothing."""
    return f", {os.path.getsize(path) / 2**20:.3g} MiB" if os.path.isfile(path) else ""
