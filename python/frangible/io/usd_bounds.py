"""How many prims a stage has, found out in its layers before anything is composed: references that
refer to references multiply, and ten lines may make a hundred million prims."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from typing import Any

from pxr import Sdf, Tf

#: The most prims of a stage, those of references and instances counted for each: some 5 s and 0.6
#: GB. Of a stage as large as our readers take, two of five are meshes.
MOST_PRIMS = 500_000

_ARCS = {"references", "payload", "inheritPaths", "specializes"}


def has_too_many_prims(path: str) -> bool:
    """True if the stage of a file would have more than `MOST_PRIMS`; false for what is no stage."""
    try:
        status = os.stat(path)
    except OSError:
        return False
    return _has_too_many(os.path.realpath(path), status.st_mtime_ns, status.st_size)


@lru_cache(64)
def _has_too_many(path: str, _time: int, _size: int) -> bool:
    # Faults of the file are told when it is opened as a stage.
    with suppress(Tf.ErrorException):
        layer = Sdf.Layer.FindOrOpen(path)
        if layer is not None:
            return _Counter().count(layer, Sdf.Path.absoluteRootPath) > MOST_PRIMS
    return False


class _Counter:
    """Counts the prims below sites: a layer with its sublayers, and a path in them.

    A prim has at most the children that its layers give it and those of all that it refers to. Each
    site is counted once, however often it is referred to.
    """

    def __init__(self) -> None:
        self._counts: dict[tuple[str, str], int] = {}
        self._stacks: dict[str, list[Any]] = {}

    def count(self, layer: Any, path: Any) -> int:
        """Prims at and below a site, up to some more than `MOST_PRIMS`."""
        site = (layer.identifier, str(path))
        if (known := self._counts.get(site)) is not None:
            return known
        # What refers to itself is left out by USD, too.
        self._counts[site] = 0
        total, children = 1, set()
        for own in self._stack(layer):
            spec = own.GetPrimAtPath(path) if path != path.absoluteRootPath else own.pseudoRoot
            if spec is None:
                continue
            children.update(spec.nameChildren.keys())
            keys = set(spec.ListInfoKeys())
            if keys & _ARCS:
                for target in self._targets(layer, own, spec):
                    total += self.count(*target)
            if "variantSetNames" in keys:
                total += self._variants(layer, spec)
        for name in children:
            total += self.count(layer, path.AppendChild(name))
            if total > MOST_PRIMS:
                break
        self._counts[site] = total
        return total

    def _variants(self, layer: Any, spec: Any) -> int:
        """Of the largest variant of each set."""
        total = 0
        for name, variants in spec.variantSets.items():
            ones = variants.variants.keys()
            paths = (spec.path.AppendVariantSelection(name, one) for one in ones)
            total += max((self.count(layer, path) for path in paths), default=0)
        return total

    def _targets(self, layer: Any, own: Any, spec: Any) -> Iterator[tuple[Any, Any]]:
        """What a prim of a layer, which belongs to another one's stack, refers to."""
        for paths in (spec.inheritPathList, spec.specializesList):
            for path in paths.GetAddedOrExplicitItems():
                yield layer, path
        for arcs in (spec.referenceList, spec.payloadList):
            for arc in arcs.GetAddedOrExplicitItems():
                other = layer if not arc.assetPath else _opened(own, arc.assetPath)
                if other is None:
                    continue
                path = arc.primPath
                if path.isEmpty and other.defaultPrim:
                    path = Sdf.Path.absoluteRootPath.AppendPath(Sdf.Path(other.defaultPrim))
                if not path.isEmpty:
                    yield other, path

    def _stack(self, layer: Any) -> list[Any]:
        """A layer with all of its sublayers."""
        if layer.identifier not in self._stacks:
            found = {layer.identifier: layer}
            open_ones = [layer]
            while open_ones:
                below = open_ones.pop()
                for asset in below.subLayerPaths:
                    sub = _opened(below, asset)
                    if sub is not None and sub.identifier not in found:
                        found[sub.identifier] = sub
                        open_ones.append(sub)
            self._stacks[layer.identifier] = list(found.values())
        return self._stacks[layer.identifier]


def _opened(beside: Any, asset: str) -> Any:
    """A layer that another one names; `None` if it cannot be read."""
    try:
        return Sdf.Layer.FindOrOpenRelativeToLayer(beside, asset)
    except Tf.ErrorException:
        return None
