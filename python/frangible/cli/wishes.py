"""Options of one mesh file that breaks: what it is made of, and what strikes it."""

from __future__ import annotations

import argparse
import json
from typing import Any

from ..material_presets import PRESETS
from ..mesh_scene import UNITS
from .options import finite, natural, positive

#: What a bond of glue bears [Pa]: about what mortar does.
GLUE = 5e5

#: The options, by the field of the wishes that each sets.
OPTIONS = {
    "material": "--material",
    "pattern": "--pattern",
    "strength": "--strength",
    "reach": "--reach",
    "glue": "--glue",
    "ball": "--ball",
    "origin": "--from",
    "hit_at_frame": "--hit-at-frame",
    "ground": "--ground",
    "gravity": "--gravity",
    "look": "--look",
    "up": "--up",
    "unit": "--unit",
}


def add_wishes(parser: argparse.ArgumentParser) -> None:
    """Add the options, for `wished`."""
    group = parser.add_argument_group("of one mesh file (.obj, .ply, .stl, .glb, .usd)")
    group.add_argument(
        "--material",
        metavar="NAME",
        help=f"what it is made of: {', '.join(PRESETS)} [concrete]",
    )
    group.add_argument(
        "--pattern", metavar="NAME|FILE", help="how it breaks, as `frangible pattern` [material's]"
    )
    group.add_argument(
        "--strength",
        type=_strength,
        metavar="N",
        help="largest impulse that it bears [N s], or a material's name [the material's]",
    )
    group.add_argument(
        "--reach",
        type=positive,
        metavar="LENGTH",
        help="how far a break reaches from its blow, in the file's unit: the rest stays whole",
    )
    group.add_argument(
        "--glue",
        nargs="?",
        type=positive,
        const=GLUE,
        metavar="PA",
        help="its closed parts, as `frangible break` writes them, or a pattern's pieces are glued "
        f"together, and a bond bears so much [{GLUE:g} Pa]",
    )
    group.add_argument(
        "--ball",
        type=_pair,
        metavar="R,V",
        help="a steel ball flies at its middle: radius in the file's unit, speed [m/s]",
    )
    group.add_argument(
        "--from",
        dest="origin",
        type=_place,
        metavar="X,Y,Z",
        help="where the ball comes from, in the file's unit and axes [from its front: +z, or -y if "
        "z is up]",
    )
    group.add_argument(
        "--hit-at-frame",
        type=natural(10**6, 1),
        metavar="N",
        help="frame in which the ball arrives: it starts as far away on its line as that takes",
    )
    group.add_argument(
        "--ground", action="store_const", const=True, help="it stands on ground, where it is lowest"
    )
    group.add_argument(
        "--gravity", type=finite, metavar="M/S2", help="downwards [9.81]; scenes say their own"
    )
    group.add_argument(
        "--look", metavar="NAME", help="what it looks like: a look's name [the material's]"
    )
    group.add_argument("--up", choices=("y", "z"), help="the file's axis that points up [y]")
    group.add_argument("--unit", metavar="NAME", help=f"the file's unit: {', '.join(UNITS)} [m]")


def wished(options: argparse.Namespace) -> dict[str, Any]:
    """The fields of wishes that the options set."""
    given = {field: getattr(options, field) for field in OPTIONS}
    return {field: value for field, value in given.items() if value is not None}


def _numbers(text: str, count: int, form: str) -> tuple[float, ...]:
    parts = text.split(",")
    if len(parts) != count:
        raise argparse.ArgumentTypeError(f"{text!r}, must be {form}")
    return tuple(finite(part) for part in parts)


def _place(text: str) -> tuple[float, ...]:
    return _numbers(text, 3, "X,Y,Z, like 0,1,3")


def _pair(text: str) -> tuple[float, ...]:
    found = _numbers(text, 2, "R,V, like 0.2,15")
    return tuple(positive(str(number)) for number in found)


def _strength(text: str) -> float | str:
    try:
        value = json.loads(text)
    except json.JSONDecodeError:
        return text
    return float(value) if isinstance(value, (int, float)) else text
