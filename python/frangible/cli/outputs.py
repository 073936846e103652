"""Writes what the options name."""

from __future__ import annotations

import os
import sys

from ..output import Output
from ..recording import Recording


def write(outputs: list[Output], recording: Recording) -> None:
    """Each output, with a line for each on stderr."""
    for output in outputs:
        output.write(recording)
        size = f", {os.path.getsize(output.path) / 2**20:.3g} MiB" if os.path.isfile(output.path) else ""
        print(f"wrote {output.path}{size}", file=sys.stderr)
