"""The materials that bodies are drawn with, the same in every format."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Generic, TypeVar

import numpy as np

from ..materials import (
    INSIDE,
    INSIDE_ROUGHNESS,
    LOOKS,
    OUTSIDE,
    OUTSIDE_ROUGHNESS,
    SCENERY,
    Colour,
    Look,
    Material,
)
from ..names import unique_names
from ..recording import Body, Bool, Float64
from ..skin import NO_MATERIAL

# Steps of the two-dimensional golden-ratio sequence, which fills a square evenly (M. Roberts,
# 2018).
GOLDEN_STEPS = np.array([0.7548776662466927, 0.5698402909980532])
#: How a file refers to a material of its own.
Handle = TypeVar("Handle")


def source_colours(families: dict[int, list[Body]]) -> dict[int, Colour]:
    """A colour for each source id, given its bodies: for those without a look."""
    movable = [source for source, family in families.items() if any(body.moves for body in family)]
    colours = {source: OUTSIDE[i % len(OUTSIDE)] for i, source in enumerate(movable)}
    return {source: colours.get(source, SCENERY) for source in families}


def plain(colour: Colour) -> Look:
    """The look of a body that nobody gave one."""
    return Look(Material(colour, OUTSIDE_ROUGHNESS), Material(INSIDE, INSIDE_ROUGHNESS), 0.34)


def look_of(body: Body) -> Look:
    """The material that a body is drawn with; the colours of one without a look are its source's,
    not these."""
    return plain(SCENERY) if body.look is None else LOOKS[body.look]


def tint(body: Body, look: Look) -> Float64:
    """(3,) factor of a piece's colours: pieces differ by a touch of brightness and warmth, so that
    they can be told apart."""
    if body.parent is None:
        return np.ones(3)
    brightness, warmth = (body.id * GOLDEN_STEPS) % 1.0
    shade = 1.0 + look.variation * (brightness - 0.53)
    factor: Float64 = shade * (
        1.0 + 0.3 * look.variation * (warmth - 0.5) * np.array([1.0, 0.0, -1.2])
    )
    return factor


class Palette(Generic[Handle]):
    """The materials of a file, each made when the first body needs it.

    Materials of a mesh's file stay what they are. A body without a look has its source's outside
    besides, and the inside that all share.
    """

    def __init__(
        self,
        families: dict[int, list[Body]],
        make: Callable[[str, Material], Handle],
        sides: tuple[str, str] | None = None,
    ) -> None:
        """``sides`` names outside and inside of bodies without a look, if all have the same."""
        self._make = make
        self._made: dict[Material, Handle] = {}
        self._colours = source_colours(families)
        self._inside = "inside" if sides is None else sides[1]
        ours = [
            self._inside,
            *(f"{look}_{side}" for look in LOOKS for side in ("outside", "inside")),
        ]
        own = (
            (family[0].name for family in families.values())
            if sides is None
            else (sides[0] for _ in families)
        )
        names = list(unique_names([*ours, *own]))
        self._names = dict(zip(families, names[len(ours) :], strict=True))
        self._taken = set(names)

    def groups(self, body: Body) -> list[tuple[Handle, Bool, bool]]:
        """Each material of a body's triangles, its triangles (t,), and whether they are the
        inside."""
        own = np.full(len(body.triangles), NO_MATERIAL) if body.skin is None else body.skin.material
        groups = []
        for is_inside in (False, True):
            side = body.interior == is_inside
            for index in np.unique(own[side]).tolist():
                handle = (
                    self._side(body, is_inside)
                    if index == NO_MATERIAL
                    else self._of_file(body, index)
                )
                groups.append((handle, side & (own == index), is_inside))
        return groups

    def _side(self, body: Body, is_inside: bool) -> Handle:
        if body.look is None:
            look = plain(self._colours[body.source])
            name = self._inside if is_inside else self._names[body.source]
        else:
            look, name = LOOKS[body.look], f"{body.look}_{'inside' if is_inside else 'outside'}"
        return self._material(name, look.inside if is_inside else look.outside)

    def _of_file(self, body: Body, index: int) -> Handle:
        assert body.skin is not None
        material = body.skin.materials[index]
        if material not in self._made:
            # Another material of that name keeps it.
            *_, name = unique_names([*sorted(self._taken), material.name or "material"])
            self._taken.add(name)
            self._made[material] = self._make(name, material)
        return self._made[material]

    def _material(self, name: str, material: Material) -> Handle:
        named = replace(material, name=name)
        if named not in self._made:
            self._made[named] = self._make(name, named)
        return self._made[named]
