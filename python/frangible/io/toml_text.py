"""Scenes as TOML for people to read and change: rows of numbers stay in one line."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

from .._frangible import BuildError

#: A longer table gets lines of its own.
WIDTH = 90


def as_toml(scene: dict[str, Any]) -> str:
    """The scene as TOML 1.0. Fields without a value are left out, as TOML has none.

    `BuildError` for a list that has such an item.
    """
    return "\n".join(_table(scene, "")).strip("\n") + "\n"


def _table(fields: dict[str, Any], path: str) -> Iterator[str]:
    """The lines of a table: first what fits into a line each, then tables of their own."""
    own = {key: value for key, value in fields.items() if value is not None}
    large = {key: value for key, value in own.items() if _is_large(key, value)}
    for key, value in own.items():
        if key not in large:
            yield f"{_key(key)} = {_value(value, _below(path, key))}"
    for key, value in large.items():
        at = _below(path, key)
        if isinstance(value, dict):
            yield from ("", f"[{at}]", *_table(value, at))
        elif isinstance(value[0], dict):
            for item in value:
                yield from ("", f"[[{at}]]", *_table(item, at))


def _is_large(key: str, value: Any) -> bool:
    """True for a table, or a list of tables, that is too long for a line."""
    if isinstance(value, list):
        return bool(value) and all(isinstance(item, dict) for item in value)
    return isinstance(value, dict) and len(key) + len(json.dumps(value)) > WIDTH


def _value(value: Any, at: str) -> str:
    """A value without line breaks, but between the rows of a long list of rows."""
    if isinstance(value, dict):
        fields = ((key, item) for key, item in value.items() if item is not None)
        inner = ", ".join(f"{_key(key)} = {_inline(item, _below(at, key))}" for key, item in fields)
        return f"{{ {inner} }}" if inner else "{}"
    if isinstance(value, list) and any(isinstance(item, list) for item in value):
        rows = [_inline(item, f"{at}[{index}]") for index, item in enumerate(value)]
        line = f"[{', '.join(rows)}]"
        return line if len(line) <= WIDTH else "[\n  " + ",\n  ".join(rows) + ",\n]"
    return _inline(value, at)


def _inline(value: Any, at: str) -> str:
    if isinstance(value, dict):
        return _value(value, at)
    if isinstance(value, list):
        return f"[{', '.join(_inline(item, f'{at}[{row}]') for row, item in enumerate(value))}]"
    if value is None:
        raise BuildError(f"{at}: null, must have a value to be written as TOML")
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)


def _text(text: str) -> str:
    escaped = json.dumps(text, ensure_ascii=False)
    return re.sub("[\x7f-\x9f]", lambda found: f"\\u{ord(found[0]):04x}", escaped)


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _text(name)


def _below(path: str, key: str) -> str:
    return f"{path}.{_key(key)}" if path else _key(key)
