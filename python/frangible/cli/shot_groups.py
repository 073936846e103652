"""The shots by what they show, as `frangible shots` lists them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

#: The subject of a group, and the names in it.
GROUPS = (
    (
        "Bodies break where they are hit",
        "wall wall-middle wall-corner wall-ball wall-natural cylinder refracture rain-25 rain-100"
        " rain-1000",
    ),
    ("A mesh of your own breaks", "impact bunny"),
    ("Materials break in their ways", "pane masonry timber concrete"),
    ("Prescored and glued pieces come apart", "pillar bonded-pillar"),
    (
        "Piles and walls of many bodies",
        "pile-spread pile-deep pile-table bricks bricks-still debris",
    ),
    ("Stacks stand", "tower pyramid load arch slab card-house stack plank"),
    ("Collisions and friction", "incline cradle plate nut"),
)
#: Of shots that no group names.
OTHERS = "Others"


def grouped(shots: Sequence[tuple[str, str]]) -> Iterator[tuple[str, list[tuple[str, str]]]]:
    """Each group's title, and names and lines of its shots."""
    lines = dict(shots)
    for title, names in GROUPS:
        yield title, [(name, lines.pop(name)) for name in names.split() if name in lines]
    if lines:
        yield OTHERS, list(lines.items())
