"""The description of scene files for people, from their JSON Schema: docs/scene_format.md."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

Schema = dict[str, Any]

HEAD = """# Scene files

`frangible run scene.json` (or `.toml`) simulates a scene; `frangible scene SHOT > scene.json`, or
`frangible scene SHOT --toml > scene.toml`, prints one to start from, and
`--set bodies.wall.breaking.strength=2e6` sets a field, of bodies by their name or number. In
Python, `frangible.run` and `World.build` take the path, the same as a dictionary, or a
`frangible.Scene`, whose classes have these fields: [scenes_in_python.md](scenes_in_python.md).
[`docs/scenes`](scenes) has three small ones.

Quantities are SI, y is up, quaternions are x, y, z, w. A path of a mesh or a pattern is relative to
the scene's folder. Only the fields that are **bold** are needed. This page is made from the
descriptions in Rust by `frangible schema --markdown`. For editors that complete and check there is
the JSON Schema: the package holds it as `frangible/scene.schema.json`, and `frangible schema`
prints it.
"""


def scene_page(schema: Schema) -> str:
    """The page, in Markdown."""
    lines = [HEAD, "## The scene", "", *_table(schema)]
    for name in _in_order(schema):
        part = schema["$defs"][name]
        lines += ["", f"## {name}", "", *_paragraph(part)]
        if _is_words(part):
            lines += [f"- `{one['const']}`: {_sentence(one)}" for one in part["oneOf"]]
        elif "oneOf" in part:
            for one in part["oneOf"]:
                kind = one["properties"]["kind"]["const"]
                lines += ["", f'### `"kind": "{kind}"`', "", *_paragraph(one), *_table(one)]
        elif "anyOf" in part:
            lines += [f"- {_type(one)}{_text(one)}" for one in part["anyOf"]]
        else:
            lines += _table(part)
    return "\n".join(lines) + "\n"


def _in_order(schema: Schema) -> list[str]:
    """The parts, each after what first refers to it."""
    found: list[str] = []

    def visit(part: Any) -> None:
        for name in _references(part):
            if name not in found:
                found.append(name)
                visit(schema["$defs"][name])

    visit({key: value for key, value in schema.items() if key != "$defs"})
    return found


def _references(part: Any) -> Iterator[str]:
    if isinstance(part, list):
        for item in part:
            yield from _references(item)
    if isinstance(part, dict):
        if isinstance(part.get("$ref"), str):
            yield part["$ref"].rsplit("/", 1)[1]
        for item in part.values():
            yield from _references(item)


def _table(part: Schema) -> list[str]:
    """A row for each field."""
    fields = {name: field for name, field in part["properties"].items() if name != "kind"}
    if not fields:
        return []
    needed = part.get("required", [])
    rows = ["| field | type | default | |", "|---|---|---|---|"]
    for name, field in fields.items():
        shown = f"**`{name}`**" if name in needed else f"`{name}`"
        rows.append(f"| {shown} | {_type(field)} | {_default(field)} | {_sentence(field)} |")
    return rows


def _default(field: Schema) -> str:
    default = field.get("default")
    if (
        default is None
        or isinstance(default, (dict, list))
        and not default
        or default == {"voxels": None, "sample_spacing": None}
    ):
        return ""
    return f"`{json.dumps(default)}`"


def _type(field: Schema) -> str:
    if "$ref" in field:
        name = field["$ref"].rsplit("/", 1)[1]
        return f"[{name}](#{name.lower()})"
    for several in ("anyOf", "oneOf"):
        if several in field:
            return " or ".join(_type(one) for one in field[several] if one.get("type") != "null")
    kinds = field["type"] if isinstance(field["type"], list) else [field["type"]]
    (kind,) = (kind for kind in kinds if kind != "null")
    if kind == "object":
        return f"object: {_type(field['additionalProperties'])} by name"
    if kind != "array":
        return {
            "number": "number",
            "integer": "whole number",
            "boolean": "true or false",
            "string": "text",
        }[kind]
    count = f"{field['minItems']} " if "minItems" in field else ""
    items = field["items"]
    if "$ref" in items:
        return f"list of {_type(items)}"
    if items["type"] == "array":
        return f"list of {_type(items).replace('list', 'lists', 1)}"
    return f"list of {count}{_type(items)}s"


def _is_words(part: Schema) -> bool:
    return all("const" in one for one in part.get("oneOf", [{}]))


def _paragraph(part: Schema) -> list[str]:
    return [_sentence(part), ""] if part.get("description") else []


def _text(part: Schema) -> str:
    return f": {_sentence(part)}" if part.get("description") else ""


def _sentence(part: Schema) -> str:
    """The description in one line; what Rust calls a link is its text."""
    text = " ".join(part.get("description", "").split())
    return text.replace("|", "\\|").replace("[`", "`").replace("`]", "`")
