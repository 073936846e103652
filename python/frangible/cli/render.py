"""``frangible film`` and ``frangible render``: pictures of a cache, without simulating again."""

from __future__ import annotations

import argparse
import os
from typing import Any

from ..errors import OutputError
from ..recording import Recording
from .options import add_view, natural
from .outputs import check_view, open_outputs, write

#: Endings of films; no ending is a folder of pictures.
FILMS = (".gif", ".html", ".mp4")
#: More frames than any cache has.
MOST_FRAMES = 2**63 - 1


def add_film(commands: Any) -> None:
    """Add the command."""
    film = commands.add_parser("film", help="make a film of a cache, without simulating again")
    film.set_defaults(command=_film, frame=None)
    _add_cache(film, "film .mp4 or .gif, page .html that plays it, or folder/ for pictures")
    add_view(film)
    film.add_argument(
        "--first", type=natural(MOST_FRAMES), default=0, metavar="N", help="first frame [0]"
    )
    film.add_argument(
        "--last", type=natural(MOST_FRAMES), metavar="N", help="last frame [the cache's]"
    )


def add_render(commands: Any) -> None:
    """Add the command."""
    render = commands.add_parser("render", help="write pictures, films and other files of a cache")
    render.set_defaults(command=_render)
    _add_cache(render, "as for `frangible run`")
    add_view(render)
    render.add_argument(
        "--frame", type=natural(MOST_FRAMES), metavar="N", help="frame that a .png shows [the last]"
    )


def _add_cache(command: argparse.ArgumentParser, outputs: str) -> None:
    command.add_argument("file", metavar="FILE", help="what `frangible run --out FILE` wrote, .npz")
    command.add_argument(
        "--out", action="append", required=True, metavar="FILE", help=f"{outputs}; may be repeated"
    )
    command.add_argument("--quiet", action="store_true", help="no progress and no list of files")


def _film(options: argparse.Namespace) -> int:
    for path in options.out:
        ending = os.path.splitext(path)[1].lower()
        if not path.endswith("/") and ending not in FILMS:
            known = f"{', '.join(FILMS)}, or a folder, which ends in /"
            raise OutputError(
                f"{path}: the ending {ending or '(none)'!r} is no film's, must be one of {known}"
            )
    if options.last is not None and options.first > options.last:
        raise OutputError(f"--first: {options.first}, must be at most --last, {options.last}")
    outputs = open_outputs(options)
    recording = Recording.load(options.file)
    check_view(options, recording.convention)
    _check_frame("--first", options.first, recording)
    _check_frame("--last", options.last, recording)
    return write(outputs, recording, options.quiet, options.json)


def _render(options: argparse.Namespace) -> int:
    outputs = open_outputs(options)
    recording = Recording.load(options.file)
    check_view(options, recording.convention)
    _check_frame("--frame", options.frame, recording)
    return write(outputs, recording, options.quiet, options.json)


def _check_frame(option: str, frame: int | None, recording: Recording) -> None:
    if frame is not None and frame > recording.frames:
        last = recording.frames
        raise OutputError(f"{option}: {frame}, must be at most the last frame, {last}")
