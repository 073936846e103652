"""Lines of scene files that sentences about fields refer to."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from ._frangible import BuildError
from .convention import Convention


@dataclass(frozen=True, slots=True)
class PrimSkin:
    """A body of a stage whose materials, colours and texture coordinates another shape has."""

    #: The prim's path.
    prim: str
    #: From the shape's frame to the prim's rigid one: a point is ``point @ rotation + origin`` [m].
    rotation: list[list[float]]
    origin: list[float]


#: Names of fields and numbers of items, from the scene down.
Steps = tuple[str | int, ...]

#: Columns of a line that are quoted, around the field.
WIDTH = 96

_PATH = re.compile(r"^[A-Za-z_][\w-]*(?:\[\d+\]|\.[\w-]+)*(?=: )")
_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[{}\[\],:]|[^\s{}\[\],:"]+')
_KEY = re.compile(r'^\s*((?:[\w-]+|"[^"]*")(?:\s*\.\s*(?:[\w-]+|"[^"]*"))*)\s*=')
_TABLE = re.compile(r"^\s*(\[\[?)\s*([^\]]+?)\s*\]\]?\s*(?:#.*)?$")


class FileScene(dict[str, Any]):
    """A scene with the file that it was read from."""

    #: The file's name, and its text if it is one.
    name: str = ""
    text: str = ""
    convention: Convention = Convention()
    #: What bodies that are no meshes look like, by their numbers.
    skins: Mapping[int, PrimSkin] = MappingProxyType({})


def convention_of(scene: Any) -> Convention:
    """Of the file that a scene was read from; ours for any other."""
    return scene.convention if isinstance(scene, FileScene) else Convention()


def with_line(error: BuildError, scene: Any) -> BuildError:
    """The error with the line of the scene's file that it is about, if it is about one.

    A file of one line is not quoted, nor a field that was set after it was read.
    """
    if not isinstance(scene, FileScene) or len(scene.text.splitlines()) < 2:
        return error
    found = _PATH.match(str(error))
    if found is None:
        return error
    steps = tuple(
        int(number) if number else name
        for name, number in re.findall(r"([A-Za-z_][\w-]*)|\[(\d+)\]", found[0])
    )
    is_toml = scene.name.lower().endswith(".toml")
    stored = tomllib.loads(scene.text) if is_toml else json.loads(scene.text)
    if _at(stored, steps) != _at(scene, steps):
        return error
    places = dict(_toml_places(scene.text) if is_toml else _json_places(scene.text))
    while steps not in places:
        steps = steps[:-1]
        if not steps:
            return error
    begin = places[steps]
    number = scene.text.count("\n", 0, begin) + 1
    first = scene.text.rfind("\n", 0, begin) + 1
    line = scene.text[first:].partition("\n")[0].rstrip()
    # A long line is cut before its field.
    cut = max(0, begin - first - WIDTH // 3) if len(line) > WIDTH else 0
    shown = f"{'... ' if cut else ''}{line[cut : cut + WIDTH]}"
    shown += " ..." if len(line) > cut + WIDTH else ""
    return BuildError(f"{scene.name}, line {number}: {error}\n  {number} | {shown}")


def _at(value: Any, steps: Steps) -> Any:
    """The value there; `None` without one."""
    for step in steps:
        if isinstance(value, list) and isinstance(step, int) and step < len(value):
            value = value[step]
        elif isinstance(value, dict):
            value = value.get(step)
        else:
            return None
    # Paths of files were made absolute.
    return None if steps[-1:] == ("path",) else json.dumps(value, default=str, sort_keys=True)[:200]


def _json_places(text: str) -> Iterator[tuple[Steps, int]]:
    """Where each field's name and each item of JSON begins."""
    path: list[str | int] = []
    #: For each open bracket whether it is an object's, and whether a name comes next.
    objects: list[bool] = []
    takes_name = False
    for token in _TOKEN.finditer(text):
        match token[0]:
            case "{" | "[" as bracket:
                if objects and not objects[-1]:
                    yield tuple(path), token.start()
                objects.append(bracket == "{")
                takes_name = objects[-1]
                path.append("" if takes_name else 0)
            case "}" | "]":
                if not objects:
                    return
                objects.pop()
                path.pop()
                takes_name = False
            case ",":
                takes_name = bool(objects) and objects[-1]
                last = path[-1] if path else ""
                if isinstance(last, int):
                    path[-1] = last + 1
            case ":":
                takes_name = False
            case word:
                if takes_name:
                    path[-1] = str(json.loads(word)) if word.startswith('"') else word
                    yield tuple(path), token.start()
                elif objects and not objects[-1]:
                    yield tuple(path), token.start()


def _toml_places(text: str) -> Iterator[tuple[Steps, int]]:
    """Where each key and each table of TOML begins; what is in an inline table or a list is not
    told apart from its key."""
    here: Steps = ()
    #: How many items each list of tables has so far.
    counts: dict[Steps, int] = {}
    start = 0
    for line in text.splitlines(keepends=True):
        if (table := _TABLE.match(line)) is not None:
            here = ()
            names = _names(table[2])
            for index, name in enumerate(names):
                here = (*here, name)
                if table[1] == "[[" and index == len(names) - 1:
                    counts[here] = counts.get(here, -1) + 1
                if here in counts:
                    here = (*here, counts[here])
            yield here, start
        elif (key := _KEY.match(line)) is not None:
            yield (*here, *_names(key[1])), start + key.start(1)
        start += len(line)


def _names(dotted: str) -> list[str]:
    return [name.strip('"') for name in re.findall(r'"[^"]*"|[\w-]+', dotted)]
