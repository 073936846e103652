"""The dataclasses of scenes, from their JSON Schema: `scene_types.py`."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from typing import Any

Schema = dict[str, Any]

HEAD = '''"""The objects of scenes as dataclasses, with the fields and words of the JSON Schema.

Made by `frangible schema --python`; a test compares it with the schema.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from os import PathLike
from typing import Any, ClassVar, Literal

import numpy.typing as npt

from .description import Description

#: A list of numbers, such as a vector, or an array.
Numbers = Sequence[float] | npt.NDArray[Any]
#: A list of lists of numbers, such as points, or an array.
Rows = Sequence[Sequence[float]] | npt.NDArray[Any]
'''

#: Columns of a line.
WIDTH = 100
#: Names of objects of the schema that are not theirs without "Desc".
_NAMES = {"MaterialDesc": "Strength", "StrengthDesc": "AnyStrength", "MaterialName": "StrengthName"}
#: Unions of objects that are told apart by their kind, and what is added to a kind's name.
_UNIONS = {"ShapeDesc": ("Shape", "", ""), "PatternDesc": ("AnyPattern", "", "")}
_UNIONS["PartDesc"] = ("Part", "", "Part")
#: Kinds whose name alone would say too little.
_KINDS = {("PatternDesc", "file"): "PatternFile"}


def scene_module(schema: Schema) -> str:
    """The module's text."""
    found = schema["$defs"]
    words = [name for name in found if _is_words(found[name])]
    blocks = [HEAD]
    blocks += [_literal(name, found[name]) for name in words]
    done: set[str] = set()
    for name in _inner_first(schema):
        if name not in words and name not in done:
            done.add(name)
            blocks += _definition(name, found[name])
    blocks += _class("SceneDesc", schema, schema.get("description", ""))
    return "\n".join(blocks)


def class_name(name: str, kind: str | None = None) -> str:
    """The Python name of an object of the schema, or of one of its kinds."""
    if kind is None:
        return _UNIONS[name][0] if name in _UNIONS else _NAMES.get(name, name.removesuffix("Desc"))
    if (name, kind) in _KINDS:
        return _KINDS[name, kind]
    _, before, after = _UNIONS.get(name, ("", "", ""))
    return before + "".join(word.capitalize() for word in kind.split("-")) + after


def _is_words(part: Schema) -> bool:
    return bool(part.get("oneOf")) and all("const" in one for one in part["oneOf"])


def _is_tagged(part: Schema) -> bool:
    return bool(part.get("oneOf")) and all(
        "kind" in one.get("properties", {}) for one in part["oneOf"]
    )


def _inner_first(schema: Schema) -> list[str]:
    """The objects, each after those that it refers to."""
    order: list[str] = []

    def visit(part: Any) -> None:
        for name in _references(part):
            if name not in order:
                visit(schema["$defs"][name])
                if name not in order:
                    order.append(name)

    visit({key: value for key, value in schema.items() if key != "$defs"})
    return order


def _references(part: Any) -> Iterator[str]:
    items: list[Any] = part if isinstance(part, list) else []
    for item in [*part.values()] if isinstance(part, dict) else items:
        yield from _references(item)
    if isinstance(part, dict) and isinstance(part.get("$ref"), str):
        yield part["$ref"].rsplit("/", 1)[1]


def _literal(name: str, part: Schema) -> str:
    lines = _comment(_sentence(part))
    values = [f'"{one["const"]}"' for one in part["oneOf"]]
    return "\n".join([*lines, *_wrapped(f"{class_name(name)} = Literal[", values, "]"), ""])


def _definition(name: str, part: Schema) -> list[str]:
    if _is_tagged(part):
        blocks = []
        names = []
        for one in part["oneOf"]:
            kind = one["properties"]["kind"]["const"]
            names.append(class_name(name, kind))
            blocks += _class(names[-1], one, one.get("description", ""), kind)
        return [*blocks, _union(class_name(name), names, _sentence(part))]
    if "anyOf" in part or "oneOf" in part:
        several = part["anyOf"] if "anyOf" in part else part["oneOf"]
        kinds = list(dict.fromkeys(_type(one) for one in several))
        return [_union(class_name(name), kinds, _sentence(part))]
    if "properties" in part:
        return _class(class_name(name), part, part.get("description", ""))
    return [f"#: {_sentence(part)}\n{class_name(name)} = {_type(part)}\n"]


def _union(name: str, kinds: list[str], text: str) -> str:
    line = f"{name} = {' | '.join(kinds)}"
    if len(line) <= WIDTH:
        return "\n".join([*_before(), *_comment(text), line, ""])
    rows = [f"    {'| ' if index else ''}{kind}" for index, kind in enumerate(kinds)]
    return "\n".join([*_before(), *_comment(text), f"{name} = (", *rows, ")", ""])


def _before() -> list[str]:
    """Two empty lines, of which joining blocks makes one."""
    return [""]


def _class(name: str, part: Schema, text: str, kind: str | None = None) -> list[str]:
    fields = {key: value for key, value in part["properties"].items() if key != "kind"}
    needed = [key for key in fields if key in part.get("required", [])]
    lines = ["", "@dataclass(slots=True)", f"class {name}(Description):"]
    said = " ".join(text.split()) or name
    lines += _doc(said)
    if kind is not None:
        lines += ["", f'    KIND: ClassVar[str | None] = "{kind}"']
    if needed:
        lines.append("")
    for key in needed:
        lines += [f"    {line}" for line in _comment(_sentence(fields[key]), WIDTH - 4)]
        kinds = "str | PathLike[str]" if key == "path" else _type(fields[key])
        lines.append(f"    {key}: {kinds}")
    optional = [key for key in fields if key not in needed]
    if optional:
        lines += ["", "    _: KW_ONLY"]
    for key in optional:
        default = _default(fields[key])
        lines += [f"    {line}" for line in _comment(_sentence(fields[key]) + default, WIDTH - 4)]
        kinds = _type(fields[key])
        kinds = kinds if kinds.endswith("None") else f"{kinds} | None"
        lines.append(f"    {key}: {kinds} = None")
    return ["\n".join([*lines, ""])]


def _type(field: Schema) -> str:
    if "$ref" in field:
        return class_name(field["$ref"].rsplit("/", 1)[1])
    for several in ("anyOf", "oneOf"):
        if several in field:
            kinds = [_type(one) for one in field[several] if one.get("type") != "null"]
            return " | ".join(dict.fromkeys(kinds))
    said = field.get("type")
    kind = next((one for one in said if one != "null"), None) if isinstance(said, list) else said
    if kind == "array":
        return _list(field.get("items", {}))
    if kind == "object":
        inner = field.get("additionalProperties")
        return f"dict[str, {_type(inner)}]" if isinstance(inner, dict) else "dict[str, Any]"
    return {"number": "float", "integer": "int", "boolean": "bool", "string": "str"}.get(
        str(kind), "Any"
    )


def _list(items: Schema) -> str:
    inner = _type(items)
    if inner in ("float", "int"):
        return "Numbers"
    return "Rows" if inner == "Numbers" else f"list[{inner}]"


def _default(field: Schema) -> str:
    default = field.get("default")
    if default in (None, [], {}, "") or isinstance(default, dict):
        return ""
    return (
        f" Without it {default!r}."
        if not isinstance(default, bool)
        else (f" Without it {str(default).lower()}.")
    )


def _sentence(part: Schema) -> str:
    text = " ".join(part.get("description", "").split())
    return text.replace("[`", "`").replace("`]", "`")


def _comment(text: str, width: int = WIDTH) -> list[str]:
    return textwrap.wrap(
        text, width, initial_indent="#: ", subsequent_indent="#: ", break_on_hyphens=False
    )


def _doc(text: str) -> list[str]:
    lines = textwrap.wrap(text, WIDTH - 7, break_on_hyphens=False)
    if len(lines) == 1 and len(lines[0]) <= WIDTH - 10:
        return [f'    """{lines[0]}"""']
    lines = textwrap.wrap(text, WIDTH - 4, initial_indent='"""', break_on_hyphens=False)
    if len(lines[-1]) > WIDTH - 7:
        *front, last = lines[-1].split()
        lines[-1:] = [" ".join(front), last]
    lines[-1] += '"""'
    return [f"    {line}" for line in lines]


def _wrapped(begin: str, values: list[str], end: str) -> list[str]:
    line = f"{begin}{', '.join(values)}{end}"
    if len(line) <= WIDTH:
        return [line]
    inner = f"    {', '.join(values)}"
    if len(inner) <= WIDTH:
        return [begin, inner, end]
    return [begin, *(f"    {value}," for value in values), end]
