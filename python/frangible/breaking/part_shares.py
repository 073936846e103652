"""As many pieces of a solid as are asked for, shared out among the parts that lie apart."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass

from manifold3d import Manifold

from .. import _frangible
from ..recording import Float64
from .blow import landing_point
from .exact_cut import LEAST_PART, Cutting, Part, arrays, composed, connected, cut, uncut
from .piece_count import difference, nearest_to


@dataclass(frozen=True, slots=True, eq=False)
class Blow:
    """Where a pattern is laid, and how."""

    pattern: _frangible.Pattern
    #: (3,) [m], and the unit direction from there towards what strikes.
    at: Float64
    normal: Float64
    #: Of the mean piece's volume: smaller pieces join a neighbour.
    smallest: float


def shares(volumes: Sequence[float], wanted: int, smallest: float) -> list[int]:
    """Of so many pieces the share of each part of a solid, by its volume. Each has at least one; a
    crumb, which is smaller than ``smallest`` of the mean piece, is left out with 0."""
    least = smallest * sum(volumes) / wanted
    own = [int(volume >= least) for volume in volumes]
    left = wanted - sum(own)
    # One more for the part with the largest pieces, again and again; the first of equals.
    queue = [(-volume, part) for part, volume in enumerate(volumes) if own[part]]
    heapq.heapify(queue)
    for _ in range(left):
        part = queue[0][1]
        own[part] += 1
        heapq.heapreplace(queue, (-volumes[part] / own[part], part))
    return own


def pieces_of(body: Manifold, blow: Blow, wanted: int) -> tuple[list[Part], list[str]]:
    """So many pieces of a `labelled` solid, and what there is to say of their number. A pattern is
    laid on each part that lies apart; crumbs stay whole and are not counted."""
    apart = connected(body, LEAST_PART * body.volume())
    volumes = [sum(shell.volume() for shell in shells) for shells in apart]
    own = shares(volumes, wanted, blow.smallest)
    made = [
        _cut_into(composed(shells), blow, count, number, len(apart) > 1)
        if count > 1
        else uncut(composed(shells), shells)
        for number, (shells, count) in enumerate(zip(apart, own, strict=True))
    ]
    notes = []
    count = sum(cutting.count for cutting, share in zip(made, own, strict=True) if share > 0)
    solid = sum(share > 0 for share in own)
    if solid > wanted:
        notes.append(
            f"{wanted} pieces were asked for, and the mesh has {solid} parts that lie apart"
        )
    elif sentence := difference(count, wanted):
        notes.append(sentence)
    crumbs = sum(
        cutting.crumbs if share > 0 else cutting.count
        for cutting, share in zip(made, own, strict=True)
    )
    if crumbs:
        those, stay = ("1 loose part is", "stays") if crumbs == 1 else (
            f"{crumbs} loose parts are",
            "stay",
        )
        notes.append(
            f"{those} smaller than {blow.smallest:g} of the mean piece, {stay} whole and beside "
            "the count"
        )
    return [part for cutting in made for part in cutting.parts()], notes


def _cut_into(body: Manifold, blow: Blow, pieces: int, number: int, is_one_of: bool) -> Cutting:
    """A part of a solid in so many pieces. ``number`` makes the pattern another one than those of
    equal parts."""
    mesh, box = arrays(body), body.bounding_box()
    at, normal = blow.at.tolist(), blow.normal.tolist()
    if is_one_of and blow.pattern.has_middle:
        # The blow may be far from this part.
        at = landing_point(mesh, blow.normal).tolist()

    def along(chosen: _frangible.Pattern, coarseness: float) -> Cutting:
        cutters = _frangible.pattern_cutters(chosen, (box[:3], box[3:]), at, normal, coarseness)
        return cut(body, cutters, blow.smallest)

    return nearest_to(pieces, blow.pattern, (mesh, at, normal, number), along)
