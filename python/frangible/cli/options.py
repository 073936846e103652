"""Options of commands: how they are read, and how bad ones are answered."""

from __future__ import annotations

import argparse
import math
import re
import signal
from collections.abc import Callable, Mapping
from typing import Any, NoReturn

from .. import _frangible
from .._frangible import BuildError
from ..breaking.piece_count import LEAST_PIECES, MOST_PIECES
from ..io.drawing import FILM_SIZE, PICTURE_SIZE, RENDERERS, View
from ..render.shutter import Shutter
from ..scenes import Scene, find_scene
from ..words import did_you_mean, shortened

#: No more frames, cells and so on are asked for, as in scenes.
MOST_COUNT = 2**32 - 1
#: More threads than any machine has processors.
MOST_THREADS = 4096

EXIT_FAILED = 1
#: Bad input, as for `argparse`.
EXIT_BAD_INPUT = 2
EXIT_INTERRUPTED = 128 + signal.SIGINT
EXIT_PIPE_CLOSED = 128 + signal.SIGPIPE


class BadArguments(Exception):
    """Arguments that cannot be read, in one sentence."""


class Parser(argparse.ArgumentParser):
    """Answers bad arguments with one sentence, which asks for the nearest word that it knows."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        # Places as -3,0,2 are values, not options.
        self._negative_number_matcher = re.compile(r"-[\d.][\d.,eE+-]*$")

    def error(self, message: str) -> NoReturn:
        raise BadArguments(f"{self.prog}: {message}{self._rule(message)}")

    def _rule(self, message: str) -> str:
        """The form of an option without its values, or of all arguments, or the nearest word."""
        if bad_values := re.search(r"argument (-[^ /:]+).*: expected ", message):
            name = bad_values[1]
            values = self._option_string_actions[name].metavar or ""
            form = " ".join(values) if isinstance(values, tuple) else values
            return f", must be {name} {form}".rstrip()
        near = self._near(message)
        # `choose from` names them already.
        return near or (
            "" if "invalid" in message or "must be" in message else f"; see {self.prog} -h"
        )

    def _near(self, message: str) -> str:
        if bad_choice := re.search(r"invalid choice: '([^']*)'", message):
            choices = (choice for action in self._actions for choice in action.choices or ())
            return did_you_mean(bad_choice[1], map(str, choices))
        if bad_option := re.search(r"unrecognized arguments: (--[^ =]+)", message):
            return did_you_mean(bad_option[1], self._option_string_actions)
        return ""


def add_scene_options(parser: argparse.ArgumentParser, besides: str = "") -> None:
    """Add the options that choose a scene, for `chosen_scene`; ``besides`` is what else the first
    argument may name."""
    defaults = _frangible.shot_defaults()
    parser.add_argument(
        "shot",
        metavar="SHOT|FILE",
        help=f"{besides}one of those that `frangible shots` lists, a scene file (.json, .toml, "
        ".py, or .usd with physics), or one mesh file",
    )
    parser.add_argument("--mesh", metavar="FILE", help="mesh, for shots that break one")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        dest="assignments",
        metavar="PATH=VALUE",
        help="a field of the scene, as in bodies.wall.breaking.strength=2e6; may be repeated",
    )
    parser.add_argument(
        "--fps",
        type=positive,
        metavar="HZ",
        help=f"steps per second [{defaults['fps']:g}, or the file's]",
    )
    parser.add_argument(
        "--method", help=f"which step advances a frame [{defaults['method']}, or the file's]"
    )
    parser.add_argument(
        "--pieces",
        type=natural(MOST_PIECES),
        metavar="N",
        help="each break makes about so many pieces [what its pattern makes]",
    )
    parser.add_argument(
        "--seed",
        type=natural(2**64 - 1),
        metavar="N",
        help=f"same seed, same shot [{defaults['seed']}]",
    )
    add_thickness(parser)
    add_pose_time(parser)


def add_run_options(parser: argparse.ArgumentParser) -> None:
    """Options of a simulation: how long, and on how many threads."""
    parser.add_argument(
        "--frames", type=count, metavar="N", help="number of steps [the shot's, or 3 s]"
    )
    parser.add_argument(
        "--threads",
        type=natural(MOST_THREADS),
        default=0,
        metavar="N",
        help="0 means one for every processor [0]",
    )


def chosen_scene(options: argparse.Namespace, wishes: Mapping[str, Any]) -> tuple[Scene, int, str]:
    """The scene, number of frames and name that the options of `add_scene_options` choose, with
    what is wished of a mesh file."""
    check_pieces(options.pieces, None)
    try:
        return find_scene(
            options.shot,
            mesh=options.mesh,
            thickness=options.thickness,
            fps=options.fps,
            method=options.method,
            seed=options.seed,
            pieces=options.pieces,
            assignments=options.assignments,
            pose_time=options.pose_time,
            wishes=wishes,
        )
    except BuildError as error:
        # The field of a wish by its option.
        field, colon, rest = str(error).partition(": ")
        if not colon or field not in {*wishes, "from"}:
            raise
        raise BuildError(f"--{field.replace('_', '-')}: {rest}") from None


def add_inside(parser: argparse.ArgumentParser, default: str) -> None:
    """Add ``--inside``, with the name that it has by default."""
    parser.add_argument(
        "--inside",
        type=_name,
        metavar="NAME",
        help="material of what cracks lay bare: one of the mesh's file, a look, or a new one"
        f" [{default}]",
    )


def _name(text: str) -> str:
    if not text.strip():
        raise argparse.ArgumentTypeError(f"{text!r}, must be a name")
    return text


def add_thickness(parser: argparse.ArgumentParser) -> None:
    """Add ``--thickness``."""
    parser.add_argument(
        "--thickness",
        type=positive,
        metavar="LENGTH",
        help="open parts of the mesh are sheets and become plates so thick, in the file's unit"
        " [their holes are closed, flat ones left out]",
    )


def add_pose_time(parser: argparse.ArgumentParser) -> None:
    """When what moves in a mesh's file is read."""
    parser.add_argument(
        "--pose-time",
        type=finite,
        metavar="SECONDS",
        help="how long after its beginning an animation in a .gltf, .glb or .usd stands still "
        "[its rest pose]",
    )


def check_pieces(pieces: int | None, cells: int | None) -> None:
    """`BuildError` unless at most one of the two is given, and there are pieces."""
    if pieces is not None and pieces < LEAST_PIECES:
        rule = f"from {LEAST_PIECES} to {MOST_PIECES}"
        raise _frangible.BuildError(f"--pieces: {pieces}, must be {rule}")
    if pieces is not None and cells is not None:
        raise _frangible.BuildError(
            f"--pieces: {pieces}, must come without --cells, which follow from it"
        )


def finite(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r}, must be a finite number")
    return value


def count(text: str) -> int:
    """A number of frames, pieces and so on."""
    return natural(MOST_COUNT, 1)(text)


def positive(text: str) -> float:
    """A number that a quantity can be."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r}, must be a number > 0")
    return value


def natural(largest: int, least: int = 0) -> Callable[[str], int]:
    def parse(text: str) -> int:
        digits = text.lstrip("0") or text[-1:]
        is_number = text.isdecimal() and len(digits) <= len(str(largest))
        if not is_number or not least <= int(digits) <= largest:
            rule = f"a whole number from {least} to {largest}"
            raise argparse.ArgumentTypeError(f"{shortened(text)!r}, must be {rule}")
        return int(digits)

    return parse


def naturals(largest: int) -> Callable[[str], list[int]]:
    parse = natural(largest)
    return lambda text: [parse(part) for part in text.split(",")]


def readable(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        between = "; " if value and isinstance(value[0], list) else " "
        return between.join(readable(item) for item in value)
    return str(value)


def size(text: str) -> tuple[int, int]:
    """Width and height of a picture or a film [pixels]."""
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(part.isdecimal() and len(part) < 9 for part in parts):
        rule = "must be WIDTHxHEIGHT, like 1280x720"
        raise argparse.ArgumentTypeError(f"{shortened(text)!r}, {rule}")
    width, height = int(parts[0]), int(parts[1])
    if not (16 <= width <= 8192 and 16 <= height <= 8192) or width % 2 or height % 2:
        raise argparse.ArgumentTypeError(f"{text!r}, must be even numbers from 16 to 8192")
    return width, height


def add_view(command: argparse.ArgumentParser) -> None:
    """Add the options of pictures and films."""
    group = command.add_argument_group("of pictures and films")
    group.add_argument(
        "--camera",
        default="fit",
        metavar="fit|stage|FILE",
        help="where they are taken from: fitted to all frames; the camera of the USD stage that "
        "the scene came from, or stage:PATH; FILE: docs/films.md [fit]",
    )
    group.add_argument(
        "--size",
        type=size,
        metavar="WxH",
        help=f"[{'x'.join(map(str, PICTURE_SIZE))}, films {'x'.join(map(str, FILM_SIZE))}]",
    )
    group.add_argument(
        "--shutter",
        type=_degrees,
        default=0.0,
        metavar="DEGREES",
        help="motion blur: light of so much of a frame, of 360 [0]",
    )
    group.add_argument(
        "--samples",
        type=natural(4096, 1),
        metavar="N",
        help=f"times at which the shutter looks [{Shutter().samples}]; of Blender, rays of a pixel "
        f"[{View().rays}]",
    )
    group.add_argument(
        "--renderer",
        choices=RENDERERS,
        default=RENDERERS[0],
        help="blender: finer and slower, where it is installed [own]",
    )


def _degrees(text: str) -> float:
    value = finite(text)
    if not 0.0 <= value <= 360.0:
        raise argparse.ArgumentTypeError(f"{text!r}, must be from 0 to 360 degrees")
    return value
