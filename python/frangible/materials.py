"""Colours, the same in every format: linear RGB, picked so that a crack stands out at a glance."""

from __future__ import annotations

from .recording import Body

Colour = tuple[float, float, float]

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


def source_colours(families: dict[int, list[Body]]) -> dict[int, Colour]:
    """A colour for each source id, given its bodies."""
    movable = [source for source, family in families.items() if any(body.moves for body in family)]
    colours = {source: OUTSIDE[i % len(OUTSIDE)] for i, source in enumerate(movable)}
    return {source: colours.get(source, SCENERY) for source in families}
