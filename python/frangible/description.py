"""Parts of a scene as dataclasses: to and from the dictionaries that scene files hold."""

from __future__ import annotations

import dataclasses
import os
import types
import typing
from collections.abc import Mapping
from typing import Any, ClassVar, Self

import numpy as np

from ._frangible import BuildError
from .words import did_you_mean


class Description:
    """A dataclass with the fields of an object of a scene; `None` stands for a field left out."""

    __slots__ = ()
    #: The value of the field "kind", of objects that are told apart by it.
    KIND: ClassVar[str | None] = None

    def to_dict(self) -> dict[str, Any]:
        """The object as a scene file holds it, without fields that are left out."""
        found: dict[str, Any] = {} if self.KIND is None else {"kind": self.KIND}
        for field in dataclasses.fields(self):  # type: ignore[arg-type]
            value = getattr(self, field.name)
            if value is not None:
                found[field.name] = _plain(value)
        return found

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> Self:
        """The dataclass of an object of a scene file; `BuildError` for a field that it has not, or
        one that is missing. Values are checked when the scene is built."""
        return _read(cls, fields, "")


def _plain(value: Any) -> Any:
    """Plain data of anything that a field can hold."""
    if isinstance(value, Description):
        return value.to_dict()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return value


AnyDescription = typing.TypeVar("AnyDescription", bound=Description)


def _read(cls: type[AnyDescription], fields: Mapping[str, Any], path: str) -> AnyDescription:
    at = f"{path}." if path else ""
    known = [field.name for field in dataclasses.fields(cls)]  # type: ignore[arg-type]
    for name in fields:
        if name not in known and not (name == "kind" and cls.KIND is not None):
            rule = f"must be one of {', '.join(known)}"
            raise BuildError(f"{at}{name}: unknown field{did_you_mean(name, known)}, {rule}")
    types_of = typing.get_type_hints(cls)
    for field in dataclasses.fields(cls):  # type: ignore[arg-type]
        if field.default is dataclasses.MISSING and fields.get(field.name) is None:
            raise BuildError(f"{at}{field.name}: missing, must be given")
    values = {
        name: _value(types_of[name], fields[name], f"{at}{name}")
        for name in known
        if fields.get(name) is not None
    }
    return cls(**values)


def _value(kind: Any, value: Any, path: str) -> Any:
    """A value as its type says, where that names a description."""
    arguments = typing.get_args(kind)
    origin = typing.get_origin(kind)
    if origin in (typing.Union, types.UnionType):
        classes = [
            one for one in arguments if isinstance(one, type) and issubclass(one, Description)
        ]
        if isinstance(value, Mapping) and classes:
            return _read(_of_kind(classes, value, path), value, path)
        lists = [one for one in arguments if typing.get_origin(one) in (list, dict)]
        return _value(lists[0], value, path) if lists else value
    if origin is list and isinstance(value, list):
        items = enumerate(value)
        return [_value(arguments[0], item, f"{path}[{index}]") for index, item in items]
    if origin is dict and isinstance(value, Mapping):
        return {key: _value(arguments[1], item, f"{path}.{key}") for key, item in value.items()}
    if isinstance(kind, type) and issubclass(kind, Description) and isinstance(value, Mapping):
        return _read(kind, value, path)
    return value


def _of_kind(
    classes: list[type[Description]], value: Mapping[str, Any], path: str
) -> type[Description]:
    """The class of an object that says its kind; of others the only one."""
    tagged = {one.KIND: one for one in classes if one.KIND is not None}
    if not tagged:
        return classes[0]
    kind = value.get("kind")
    if kind in tagged:
        return tagged[kind]
    if kind is None:
        said = "missing"
    else:
        said = f"{kind!r}{did_you_mean(str(kind), map(str, tagged))}"
    rule = f"must be one of {', '.join(map(str, tagged))}"
    raise BuildError(f"{path}.kind: {said}, {rule}")
