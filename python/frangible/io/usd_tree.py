"""Where bodies stand in a stage that is written: those that came from a stage keep their paths."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pxr import UsdGeom

from ..names import Names, unique_names
from ..recording import Body

#: The root of what has no other one.
ROOT = "World"


def root_name(names: Iterable[str]) -> str:
    """The name of the root prim: what all paths of prims among the names begin with."""
    paths = [_steps(name) for name in names if name.startswith("/")]
    first = {steps[0] for steps in paths if len(steps) > 1}
    if len(first) != 1 or any(len(steps) < 2 for steps in paths):
        return ROOT
    (name,) = unique_names(first)
    return name


def _steps(name: str) -> list[str]:
    return [step for step in name.split("/") if step]


class PrimTree:
    """Xforms and names below a root, each name once."""

    def __init__(self, stage: Any, root: str, taken: Iterable[str] = ()) -> None:
        self._stage = stage
        self.root = f"/{root}"
        self._names = {self.root: Names(taken)}
        self._branches: dict[tuple[str, tuple[str, ...]], str] = {}
        UsdGeom.Xform.Define(stage, self.root)

    def child(self, parent: str, name: str) -> str:
        """A path below another that nothing has yet, with that name or one like it."""
        return f"{parent}/{self._names.setdefault(parent, Names()).own(name)}"

    def source(self, name: str) -> str:
        """The Xform of a body of the scene: at the path that its name is, as far as it is free."""
        if not name.startswith("/"):
            return self._xform(self.child(self.root, name))
        steps = _steps(name)
        if len(steps) > 1 and f"/{steps[0]}" == self.root:
            steps = steps[1:]
        parent = self.branch(self.root, tuple(steps[:-1]))
        # One that stands there because something below it came first.
        key = (self.root, tuple(steps))
        if key not in self._branches:
            self._branches[key] = self._xform(self.child(parent, steps[-1] if steps else "body"))
        return self._branches[key]

    def branch(self, root: str, path: tuple[str, ...]) -> str:
        """An Xform for each of the names, one below the other."""
        if not path:
            return root
        if (root, path) not in self._branches:
            parent = self.branch(root, path[:-1])
            self._branches[root, path] = self._xform(self.child(parent, path[-1]))
        return self._branches[root, path]

    def body(self, source: str, body: Body, name: str) -> str:
        """Where a body goes, below its source and the nodes that its mesh has in its file. Of a
        source whose name is a path, the body has its last name."""
        path = () if body.skin is None else body.skin.path
        own = body.name
        if name.startswith("/"):
            own = own.rpartition("/")[2]
        return self.child(self.branch(source, path), own)

    def camera(self, name: str) -> str:
        """Where a camera goes: at the path that its name is, as far as it is free."""
        steps = _steps(name)
        if len(steps) > 1 and f"/{steps[0]}" == self.root:
            steps = steps[1:]
        return self.child(self.branch(self.root, tuple(steps[:-1])), steps[-1])

    def _xform(self, path: str) -> str:
        UsdGeom.Xform.Define(self._stage, path)
        return path
