"""Fields of our own stages that come back as they were: what a stage says in singles and in its own
words is kept beside it, and counts as long as the stage says the same."""

from __future__ import annotations

import hashlib
import json
import os
from typing import Any

#: The key of a prim's custom data.
KEY = "frangible:exact"


def keep_exact_fields(prim: Any, exact: dict[str, Any], read: dict[str, Any], name: str) -> None:
    """Keep the fields of an object that the stage, of that file's name, gives back otherwise."""
    differing = {
        field: {"read": _digest(read.get(field), name), "exact": exact.get(field)}
        for field in {**exact, **read}
        if json.dumps(exact.get(field)) != json.dumps(read.get(field))
    }
    order = list(exact)
    if differing or order != list(read):
        prim.SetCustomDataByKey(KEY, json.dumps({"fields": differing, "order": order}))


def with_exact_fields(
    scene: dict[str, Any], prims: list[Any], stage: Any, name: str
) -> dict[str, Any]:
    """The scene of a stage with the fields that were kept; ``prims`` are those of its bodies."""
    bodies = [_exact(body, prim, name) for body, prim in zip(scene["bodies"], prims, strict=True)]
    root = stage.GetDefaultPrim()
    rest = {field: value for field, value in scene.items() if field != "bodies"}
    found = _exact(rest, root, name) if root else rest
    return {**found, "bodies": bodies}


def _exact(read: dict[str, Any], prim: Any, name: str) -> dict[str, Any]:
    kept = prim.GetCustomDataByKey(KEY)
    if not isinstance(kept, str):
        return read
    try:
        found = json.loads(kept)
        fields, order = found["fields"], found["order"]
        values = dict(read)
        for field, one in fields.items():
            if one["read"] != _digest(read.get(field), name):
                continue
            values[field] = one["exact"]
            if one["exact"] is None:
                del values[field]
    except (ValueError, KeyError, TypeError, AttributeError):
        return read
    first = {field: values[field] for field in order if field in values}
    return {**first, **values}


def _digest(value: Any, name: str) -> str:
    """Of what a stage says, whatever its file is called."""
    text = json.dumps(value, sort_keys=True).replace(
        json.dumps(f"{os.path.basename(name)}<")[1:-1], "<"
    )
    return hashlib.sha256(text.encode()).hexdigest()[:16]
