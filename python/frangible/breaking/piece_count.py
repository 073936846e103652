"""As many pieces as are asked for."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from .. import _frangible
from ..recording import Float64, UInt32

if TYPE_CHECKING:
    from .exact_cut import Cutting, Mesh

#: Breaks on a grid that are tried: the number of pieces is first found on a coarse one, which
#: resolves no small ones.
TRIES = 4
#: How far the number of pieces may be from what is asked for without another try.
WITHIN = 0.05
#: How far it may be without a word.
SILENT_WITHIN = 0.1
#: How much larger triangles of rough cells are while pieces are counted.
COARSENESS = 4.0
#: A break makes as many at least.
LEAST_PIECES = 2
#: As many as a pattern may have cells.
MOST_PIECES = 10_000
#: Voxels along the longest side of a mesh on the coarse grid.
VOXELS = 48


def break_on_grid_into(
    pieces: int,
    pattern: _frangible.Pattern,
    mesh: tuple[Float64, UInt32],
    blow: tuple[Float64, Float64],
    voxels: int,
    cut: Callable[[_frangible.Pattern], dict[str, Any]],
) -> dict[str, Any]:
    """The pieces that ``cut`` makes of a mesh on a grid of ``voxels``, as
    `_frangible.break_mesh_on_grid` returns it, along the pattern, which is made finer, coarser or
    larger until there are about so many pieces with a surface."""
    at, normal = blow[0].tolist(), blow[1].tolist()

    def counted(aim: int) -> _frangible.Pattern:
        for along in sorted({min(VOXELS, voxels), voxels}):
            try:
                found = pattern.with_pieces(
                    aim, mesh, at, normal, voxels=along, smallest_voxels=1.0
                )
                return found[0]
            except _frangible.BuildError:
                # A coarse grid may miss a thin mesh.
                if along == voxels:
                    raise
        raise AssertionError

    best: tuple[int, dict[str, Any]] | None = None
    aim, tried = pieces, set[int]()
    for _ in range(TRIES):
        tried.add(aim)
        broken = cut(counted(aim))
        count = sum(len(piece["triangles"]) > 0 for piece in broken["pieces"])
        if best is None or abs(count - pieces) < abs(best[0] - pieces):
            best = (count, broken)
        # More pieces than the grid shows ask for fewer there.
        aim = min(max(1, round(aim * pieces / max(count, 1))), MOST_PIECES)
        if abs(count - pieces) <= WITHIN * pieces or aim in tried:
            break
        # Without a contact each piece is a part of the mesh by itself: none makes fewer.
        if count >= pieces and not broken["contacts"]:
            break
    assert best is not None
    return best[1]


def nearest_to(
    pieces: int,
    pattern: _frangible.Pattern,
    part: tuple[Mesh, list[float], list[float], int],
    cut: Callable[[_frangible.Pattern, float], Cutting],
) -> Cutting:
    """What ``cut`` makes of a part of a mesh along the pattern, which is made for it until there
    are about so many pieces; one from a file is laid on larger. The part is its surface, point and
    normal of the blow, and its number. Rough cells are first counted with larger triangles: ``cut``
    is told by how much."""
    mesh, at, normal, number = part

    def searched(coarseness: float) -> tuple[_frangible.Pattern, Cutting]:
        best: tuple[_frangible.Pattern, Cutting] | None = None

        def attempt(chosen: _frangible.Pattern) -> int:
            nonlocal best
            made = cut(chosen, coarseness)
            if best is None or abs(made.count - pieces) < abs(best[1].count - pieces):
                best = (chosen, made)
            return made.count

        pattern.with_pieces_by(pieces, attempt, mesh, at, normal, number)
        assert best is not None
        return best

    if pattern.is_planar:
        return searched(1.0)[1]
    chosen, coarse = searched(COARSENESS)
    made = cut(chosen, 1.0)
    if made.count == coarse.count or abs(made.count - pieces) <= SILENT_WITHIN * pieces:
        return made
    return min(made, searched(1.0)[1], key=lambda found: abs(found.count - pieces))


def difference(count: int, wanted: int) -> str | None:
    """The sentence that there are not as many pieces as were asked for; `None` if it is nearly so
    many."""
    if abs(count - wanted) <= SILENT_WITHIN * wanted:
        return None
    return f"{wanted} pieces were asked for, and {count} is as near as this pattern comes"
