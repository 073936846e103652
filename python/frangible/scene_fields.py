"""Fields of a scene that are set by hand, or for a file."""

from __future__ import annotations

import copy
import json
import os
from typing import Any

from ._frangible import BuildError
from .words import did_you_mean, shortened, shown

#: The most parts of a field's path; those of a scene have eight.
MOST_STEPS = 64


def set_field(scene: dict[str, Any], assignment: str) -> None:
    """Set a field by its path, as in ``bodies.wall.breaking.strength=2e6``; bodies by name or
    number, values as JSON.

    A value that is no JSON is text. All bodies of a name are set. `BuildError` names the part of
    the path that does not fit.
    """
    path, equals, text = assignment.partition("=")
    path = path.strip()
    at = f"--set {shortened(path, 80)}"
    if not equals or not path.strip("."):
        said = f"--set {shortened(assignment, 80)}"
        raise BuildError(f"{said}: must be PATH=VALUE, as in bodies.wall.friction=0.3")
    if path.count(".") + path.count("[") >= MOST_STEPS:
        raise BuildError(f"{at}: must have at most {MOST_STEPS} parts")
    try:
        value = json.loads(text)
    except (json.JSONDecodeError, RecursionError):
        value = text
    except ValueError:
        raise BuildError(f"{at}: {shortened(text)}, must have at most 4300 digits") from None
    _assign(scene, path, "", value, at)


def _assign(place: Any, rest: str, here: str, value: Any, at: str) -> None:
    """Go down by the first part of ``rest``, and set the value where it ends."""
    rest = rest.replace("[", ".").replace("]", "").lstrip(".")
    steps: list[int] | list[str]
    if isinstance(place, list):
        steps, after = _rows(place, rest, here, at)
    elif isinstance(place, dict):
        field, _, after = rest.partition(".")
        steps = [field]
    else:
        raise BuildError(f"{at}: {here} is {shown(place)}, which has no fields")
    step: int | str
    for step in steps:
        if not after:
            place[step] = copy.deepcopy(value)
            continue
        if isinstance(step, str) and place.get(step) is None:
            place[step] = {}
        _assign(place[step], after, f"{here}.{step}".lstrip("."), value, at)


def _rows(place: list[Any], rest: str, here: str, at: str) -> tuple[list[int], str]:
    """The rows of a list that the path begins with, by number or by name, and the rest of the
    path."""
    names = {
        row["name"] for row in place if isinstance(row, dict) and isinstance(row.get("name"), str)
    }
    for name in sorted(names, key=len, reverse=True):
        if name and (rest == name or rest.startswith(f"{name}.")):
            rows = [
                index
                for index, row in enumerate(place)
                if isinstance(row, dict) and row.get("name") == name
            ]
            return rows, rest[len(name) + 1 :]
    step, _, after = rest.partition(".")
    if step.isdecimal() and len(step) < 20 and int(step) < len(place):
        return [int(step)], after
    rule = f"a number below {len(place)}" + (
        f", or a name: {', '.join(sorted(names))}" if names else ""
    )
    said = repr(shortened(step, 80))
    raise BuildError(f"{at}: {here} has no {said}{did_you_mean(step[:80], names)}, must be {rule}")


def with_relative_paths(scene: dict[str, Any], file: str) -> dict[str, Any]:
    """The scene for a file: paths of meshes and patterns in its folder or below are relative to it,
    all others absolute."""
    folder = os.path.dirname(os.path.abspath(file))
    found = copy.deepcopy(dict(scene))

    def visit(value: Any) -> None:
        if isinstance(value, dict):
            path = value.get("path")
            if isinstance(path, str) and value.get("kind") in ("mesh", "file"):
                near = os.path.relpath(os.path.abspath(path), folder)
                value["path"] = os.path.abspath(path) if near.startswith(os.pardir) else near
        items = value.values() if isinstance(value, dict) else value
        for item in items if isinstance(value, (dict, list)) else ():
            visit(item)

    visit(found)
    return found
