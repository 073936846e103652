"""``frangible render``: pictures, films and other files of a cache, without simulating again."""

from __future__ import annotations

import argparse
from typing import Any

from ..errors import OutputError
from ..recording import Recording
from .options import add_view, natural
from .outputs import open_outputs, write


def add_render(commands: Any) -> None:
    """Add the command."""
    render = commands.add_parser("render", help="write pictures, films and other files of a cache")
    render.set_defaults(command=_render)
    render.add_argument("file", metavar="FILE", help="what `frangible run --out FILE` wrote, .npz")
    render.add_argument(
        "--out",
        action="append",
        required=True,
        metavar="FILE",
        help="as for `frangible run`; may be repeated",
    )
    add_view(render)
    render.add_argument(
        "--frame", type=natural(2**63 - 1), metavar="N", help="frame that a .png shows [the last]"
    )
    render.add_argument("--quiet", action="store_true", help="no progress and no list of files")


def _render(options: argparse.Namespace) -> int:
    outputs = open_outputs(options)
    recording = Recording.load(options.file)
    if options.frame is not None and options.frame > recording.frames:
        last = recording.frames
        raise OutputError(f"--frame: {options.frame}, must be at most the last frame, {last}")
    return write(outputs, recording, options.quiet)
