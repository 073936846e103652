"""Colours, the same in every format: linear RGB, picked so that a crack stands out at a glance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from .paths import unique_names
from .recording import Body

Colour = tuple[float, float, float]

#: How a file refers to a material of its own.
Handle = TypeVar("Handle")

#: What cracks lay bare: fired clay.
INSIDE: Colour = (0.42, 0.15, 0.085)
INSIDE_ROUGHNESS = 0.9
#: What was the surface all along, one colour for each source that can move.
OUTSIDE: tuple[Colour, ...] = (
    (0.54, 0.49, 0.41),  # limestone
    (0.13, 0.17, 0.23),  # gunmetal
    (0.28, 0.45, 0.52),  # verdigris
    (0.55, 0.42, 0.16),  # brass
    (0.42, 0.30, 0.42),  # heather
)
OUTSIDE_ROUGHNESS = 0.7
#: Whatever never moves.
SCENERY: Colour = (0.42, 0.43, 0.44)


@dataclass(frozen=True, slots=True)
class Material:
    """One side of what a body is made of."""

    colour: Colour
    roughness: float
    metallic: float = 0.0
    #: Share of the light that passes.
    clear: float = 0.0


@dataclass(frozen=True, slots=True)
class Look:
    """What something is drawn as."""

    #: What was its surface all along, and what cracks lay bare.
    outside: Material
    inside: Material
    #: By how much pieces differ in brightness, relative to it.
    variation: float


#: What a scene can say that a body looks like.
LOOKS: dict[str, Look] = {
    "glass": Look(Material((0.72, 0.95, 0.86), 0.02, clear=0.86), Material((0.28, 0.62, 0.47), 0.1, clear=0.45), 0.0),
    "concrete": Look(Material((0.37, 0.365, 0.35), 0.85), Material((0.47, 0.44, 0.39), 0.95), 0.06),
    "brick": Look(Material((0.40, 0.115, 0.062), 0.85), Material((0.50, 0.175, 0.10), 0.95), 0.45),
    "mortar": Look(Material((0.56, 0.53, 0.47), 0.95), Material((0.58, 0.55, 0.49), 0.95), 0.10),
    "wood": Look(Material((0.58, 0.37, 0.18), 0.65), Material((0.70, 0.47, 0.20), 0.85), 0.22),
    "stone": Look(Material((0.46, 0.43, 0.38), 0.85), Material((0.55, 0.52, 0.46), 0.95), 0.15),
    "metal": Look(Material((0.12, 0.12, 0.125), 0.35, metallic=1.0), Material((0.32, 0.32, 0.33), 0.5, metallic=1.0), 0.1),
}


def source_colours(families: dict[int, list[Body]]) -> dict[int, Colour]:
    """A colour for each source id, given its bodies: for those without a look."""
    movable = [source for source, family in families.items() if any(body.moves for body in family)]
    colours = {source: OUTSIDE[i % len(OUTSIDE)] for i, source in enumerate(movable)}
    return {source: colours.get(source, SCENERY) for source in families}


def plain(colour: Colour) -> Look:
    """The look of a body that nobody gave one."""
    return Look(Material(colour, OUTSIDE_ROUGHNESS), Material(INSIDE, INSIDE_ROUGHNESS), 0.34)


class Palette(Generic[Handle]):
    """The materials of a file, each made when the first body needs it.

    A body without a look has its source's outside, and the inside that all share.
    """

    def __init__(self, families: dict[int, list[Body]], make: Callable[[str, Material], Handle]) -> None:
        self._make = make
        self._made: dict[str, Handle] = {}
        self._colours = source_colours(families)
        ours = ["inside", *(f"{look}_{side}" for look in LOOKS for side in ("outside", "inside"))]
        names = list(unique_names([*ours, *(family[0].name for family in families.values())]))
        self._names = dict(zip(families, names[len(ours) :], strict=True))

    def sides(self, body: Body) -> tuple[Handle, Handle]:
        """What a body looks like outside, and where it cracked."""
        if body.look is None:
            look, outside, inside = plain(self._colours[body.source]), self._names[body.source], "inside"
        else:
            look, outside, inside = LOOKS[body.look], f"{body.look}_outside", f"{body.look}_inside"
        return self._material(outside, look.outside), self._material(inside, look.inside)

    def _material(self, name: str, material: Material) -> Handle:
        if name not in self._made:
            self._made[name] = self._make(name, material)
        return self._made[name]
