"""Meshes cut by the closed cells of a pattern, with a robust Boolean library: watertight pieces
that fit without a gap."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from manifold3d import Manifold, Mesh64, OpType

from .. import _frangible
from ..recording import Bool, Float32, Float64, UInt32

Mesh = tuple[Float64, UInt32]
#: Vertices, triangles, and the face of the cell that each triangle is a part of.
Cutter = tuple[Float64, UInt32, UInt32]
#: Two parts by their numbers, the area [m^2] that they have in common, and the unit normal from the
#: first to the second.
Touching = tuple[int, int, float, list[float]]

#: A part with less of the whole's volume is what rounding leaves where faces touch, no piece.
LEAST_PART = 1e-12
#: Cells whose parts make up the whole but for this part of its volume fit: the rest is rounding.
FITS = 1e-9
#: How far parts that touch are pushed into one another to be one, in their largest coordinate.
GLUED = 1e-11


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A connected part of what one cell cut out of a mesh."""

    vertices: Float64
    triangles: UInt32
    #: (t,) the face of the cell, -1 on the mesh's own surface.
    face: npt.NDArray[np.int64]
    #: (t,) the triangle of the solid that it is a part of, -1 in a crack.
    source: npt.NDArray[np.int64]

    @property
    def inner(self) -> Bool:
        """(t,) whether a crack made the triangle."""
        return self.face >= 0


def as_manifold(vertices: Float64, triangles: UInt32, original: int | None = None) -> Manifold:
    """With an original id, each triangle keeps its number through all cuts."""
    corners = np.ascontiguousarray(triangles, np.uint64)
    if original is None:
        return Manifold(Mesh64(np.ascontiguousarray(vertices), corners))
    return Manifold(
        Mesh64(
            np.ascontiguousarray(vertices),
            corners,
            run_index=np.array([0, 3 * len(corners)], np.uint64),
            run_original_id=np.array([original], np.uint32),
            face_id=np.arange(len(corners), dtype=np.uint64),
        )
    )


def arrays(solid: Manifold) -> Mesh:
    """Vertices and triangles."""
    mesh = solid.to_mesh64()
    return np.array(mesh.vert_properties[:, :3]), np.array(mesh.tri_verts, np.uint32)


def labelled(solid: Manifold) -> Manifold:
    """The same solid, whose triangles keep their numbers through all cuts."""
    return as_manifold(*arrays(solid), Manifold.reserve_ids(1))


def cut(body: Manifold, cutters: list[Cutter], smallest: float = 0.0) -> Cutting:
    """What cells cut out of a `labelled` solid."""
    # Cells are told apart by the ids of their triangles, faces by numbers of their own.
    first = Manifold.reserve_ids(max(len(cutters), 1))
    least = LEAST_PART * body.volume()
    solids: list[Manifold] = []
    cells, face_of, count = [], {}, 0
    for cell, (vertices, triangles, face) in enumerate(cutters):
        if len(triangles) > 0:
            solids.append(as_manifold(vertices, triangles, first + cell))
            cells.append(body ^ solids[-1])
            face_of[first + cell] = face.astype(np.int64) + count
            count += int(face.max()) + 1
    if not _fit(cells, body) and not _fit([_box(body) ^ solid for solid in solids], _box(body)):
        cells = _fitted(body, cells, least)
    groups = [
        (cell, shells) for cell, inside in enumerate(cells) for shells in connected(inside, least)
    ]
    return Cutting(body, solids, groups, face_of, smallest)


def _fit(cells: list[Manifold], whole: Manifold) -> bool:
    """True if cells fill a whole. Of one that crosses itself no cells do."""
    return bool(abs(sum(cell.volume() for cell in cells) - whole.volume()) <= FITS * whole.volume())


def _box(solid: Manifold) -> Manifold:
    low, high = np.split(np.array(solid.bounding_box()), 2)
    return Manifold.cube(high - low).translate(low)


def uncut(body: Manifold, shells: list[Manifold]) -> Cutting:
    """A connected part of a `labelled` solid that stays whole."""
    return Cutting(body, [], [(0, shells)], {}, 0.0)


def connected(solid: Manifold, least: float) -> list[list[Manifold]]:
    """The connected parts of a solid, each an outer shell and its cavities, the largest first."""
    return _with_cavities([shell for shell in solid.decompose() if abs(shell.volume()) > least])


class Cutting:
    """The connected parts of a solid in each cell. One of less than ``smallest`` of the mean volume
    joins the neighbour that it has the largest surface in common with."""

    def __init__(
        self,
        body: Manifold,
        cutters: list[Manifold],
        groups: list[tuple[int, list[Manifold]]],
        face_of: dict[int, npt.NDArray[np.int64]],
        smallest: float,
    ) -> None:
        """``groups`` are the shells of each part, and the number of the cutter that cut it out of
        the body; ``face_of`` the face of each triangle of a cutter, by its id."""
        self._body, self._cutters, self._groups, self._face_of = body, cutters, groups, face_of
        volumes = [sum(shell.volume() for shell in shells) for _, shells in groups]
        self._hosts = list(range(len(groups)))
        self._found: list[tuple[list[int], float, list[float]]] = []
        if volumes and min(volumes) < smallest * sum(volumes) / len(volumes):
            parts = [self._part(shells) for _, shells in groups]
            surfaces = [((part.vertices, part.triangles), part.inner) for part in parts]
            self._found = [
                ([contact["a"], contact["b"]], contact["area_m2"], contact["normal"])
                for contact in _frangible.piece_contacts(surfaces)
            ]
            areas = [(pair, area) for pair, area, _ in self._found]
            self._hosts = _frangible.join_slivers(volumes, areas, smallest)
        joined = np.zeros(len(groups))
        np.add.at(joined, self._hosts, volumes)
        joined = joined[joined > 0.0]
        #: How many parts there are, without crumbs: those that are too small and touch no other.
        self.count = int((joined >= _least(joined, smallest)).sum())
        self.crumbs = len(joined) - self.count

    def parts(self) -> list[Part]:
        """Cell by cell, the largest first. Together they are the solid, even if the cells leave
        gaps or overlap."""
        kept = []
        for number, (_, shells) in enumerate(self._groups):
            members = [other for other, host in enumerate(self._hosts) if host == number]
            if members == [number]:
                kept.append(self._part(shells))
            elif members:
                touching = [
                    (members.index(a), members.index(b), area, normal)
                    for (a, b), area, normal in self._found
                    if a in members and b in members
                ]
                own = [self._groups[member] for member in members]
                kept.append(self._part(_joined(self._body, self._cutters, own, touching)))
        return kept

    def _part(self, shells: list[Manifold]) -> Part:
        return _part(shells, self._face_of)


def _least(volumes: Float64, smallest: float) -> float:
    """This part of the mean of the volumes that are not below it."""
    least = 0.0
    while len(volumes):
        bound = smallest * float(volumes.sum()) / max(int((volumes >= least).sum()), 1)
        if bound <= least:
            break
        least = bound
    return least


def _joined(
    body: Manifold,
    cutters: list[Manifold],
    members: list[tuple[int, list[Manifold]]],
    touching: list[Touching],
) -> list[Manifold]:
    """Parts as one, without the cracks between them: what the united cells cut out. Cells share the
    corners of their faces bit for bit, and parts of a body do not: those would touch without being
    one."""
    whole = [composed(shells) for _, shells in members]
    if max(cell for cell, _ in members) >= len(cutters):
        # A gap between all cells.
        return _glued(whole, touching, LEAST_PART * body.volume())
    volume = sum(shell.volume() for _, shells in members for shell in shells)
    low, high = np.split(np.array([solid.bounding_box() for solid in whole]), 2, axis=1)
    box, near = np.append(low.min(axis=0), high.max(axis=0)), FITS * np.ptp([low, high])
    united = Manifold.batch_boolean(
        [cutters[cell] for cell in sorted({cell for cell, _ in members})], OpType.Add
    )
    for shells in connected(body ^ united, LEAST_PART * body.volume()):
        # Volumes and boxes tell it from others without more Boolean calls.
        fits = abs(sum(shell.volume() for shell in shells) - volume) <= FITS * body.volume()
        if fits and np.allclose(shells[0].bounding_box(), box, rtol=0.0, atol=near):
            return shells
    # Where cells leave gaps or overlap, or other parts touch them.
    return _glued(whole, touching, LEAST_PART * body.volume())


def _glued(solids: list[Manifold], touching: list[Touching], least: float) -> list[Manifold]:
    """Solids whose faces touch but for rounding as one: each is moved into the larger one that it
    touches, by so little that single precision does not show it."""
    depth = GLUED * float(np.abs([solid.bounding_box() for solid in solids]).max())
    first = max(range(len(solids)), key=lambda number: solids[number].volume())
    one, done = solids[first], {first}
    ways = [*touching, *((b, a, area, [-x for x in normal]) for a, b, area, normal in touching)]
    while reached := [way for way in ways if way[0] in done and way[1] not in done]:
        _, number, _, normal = max(reached, key=lambda way: way[2])
        one = one + solids[number].translate([-depth * x for x in normal])
        done.add(number)
    rest = [solid for number, solid in enumerate(solids) if number not in done]
    one = Manifold.batch_boolean([one.simplify(2.0 * depth), *rest], OpType.Add)
    return [shell for shell in one.decompose() if abs(shell.volume()) > least]


def composed(shells: list[Manifold]) -> Manifold:
    """An outer shell and its cavities as one: the library's own composition unites them, and fills
    the cavities."""
    if len(shells) == 1:
        return shells[0]
    meshes = [shell.to_mesh64() for shell in shells]
    counts = np.cumsum([0, *(len(mesh.vert_properties) for mesh in meshes)])
    corners = np.cumsum([0, *(3 * len(mesh.tri_verts) for mesh in meshes)])

    def joined(
        name: str, offsets: npt.NDArray[np.int64] | None, dtype: npt.DTypeLike
    ) -> npt.NDArray[Any]:
        rows = [np.asarray(getattr(mesh, name)) for mesh in meshes]
        if offsets is not None:
            rows = [
                own.astype(np.int64) + offset for own, offset in zip(rows, offsets, strict=False)
            ]
        return np.ascontiguousarray(np.concatenate(rows), dtype)

    # Runs begin where those of the mesh before end.
    begins = [
        np.asarray(mesh.run_index, np.int64)[:-1] + offset
        for mesh, offset in zip(meshes, corners, strict=False)
    ]
    return Manifold(
        Mesh64(
            np.ascontiguousarray(np.concatenate([mesh.vert_properties[:, :3] for mesh in meshes])),
            joined("tri_verts", counts, np.uint64),
            merge_from_vert=joined("merge_from_vert", counts, np.uint64),
            merge_to_vert=joined("merge_to_vert", counts, np.uint64),
            run_index=np.concatenate([*begins, corners[-1:]]).astype(np.uint64),
            run_original_id=joined("run_original_id", None, np.uint32),
            face_id=joined("face_id", None, np.uint64),
        )
    )


def _fitted(body: Manifold, cells: list[Manifold], least: float) -> list[Manifold]:
    """Cells that a body is made of: what two of them share goes to the first, and a gap to the one
    that has the largest surface in common with it."""
    fitted: list[Manifold] = []
    taken = Manifold()
    for cell in cells:
        fitted.append(cell - taken)
        taken = taken + cell
    # The smallest first: it may lie in a cell that a larger one encloses, and shells are without
    # their cavities.
    rest = body - taken
    outer = sorted(
        (shell for shell in rest.decompose() if shell.volume() > least),
        key=lambda shell: shell.volume(),
    )
    for shell in outer:
        gap = rest ^ shell
        rest = rest - gap
        united = {number: cell + gap for number, cell in enumerate(fitted) if _may_touch(cell, gap)}
        if united:
            common = {
                number: fitted[number].surface_area() - both.surface_area()
                for number, both in united.items()
            }
            largest = max(common, key=lambda number: common[number])
            fitted[largest] = united[largest]
        else:
            fitted.append(gap)
    return fitted


def _may_touch(one: Manifold, other: Manifold) -> bool:
    """False if their boxes are apart."""
    low, high = np.split(np.array(one.bounding_box()), 2)
    other_low, other_high = np.split(np.array(other.bounding_box()), 2)
    return bool(np.all(low <= other_high) and np.all(other_low <= high))


def _with_cavities(shells: list[Manifold]) -> list[list[Manifold]]:
    """Each outer shell with the cavities in it, the largest first."""

    def order(shell: Manifold) -> tuple[float, ...]:
        return (-shell.volume(), *shell.bounding_box())

    outer = sorted((shell for shell in shells if shell.volume() > 0.0), key=order)
    around: list[list[Manifold]] = [[shell] for shell in outer]
    for cavity in (shell for shell in shells if shell.volume() < 0.0):
        # Among the shells whose box holds the cavity's: the smallest.
        low, high = np.split(np.array(cavity.bounding_box()), 2)
        for group in reversed(around):
            outer_low, outer_high = np.split(np.array(group[0].bounding_box()), 2)
            if np.all(outer_low <= low) and np.all(high <= outer_high):
                group.append(cavity)
                break
    return around


def _part(shells: list[Manifold], face_of: dict[int, npt.NDArray[np.int64]]) -> Part:
    """The shells as one surface, with the face that each triangle comes from, by the ids of the
    cells' meshes."""
    vertices, triangles, faces, sources = [], [], [], []
    count = 0
    for shell in shells:
        mesh = shell.to_mesh64()
        # Which triangles of which original mesh these are.
        bounds = np.asarray(mesh.run_index, np.int64) // 3
        lengths: npt.NDArray[np.int64] = bounds[1:] - bounds[:-1]
        original = np.repeat(np.asarray(mesh.run_original_id, np.int64), lengths)
        face = np.full(len(original), -1, np.int64)
        for cutter in np.unique(original).tolist():
            if cutter in face_of:
                own = original == cutter
                face[own] = face_of[cutter][np.asarray(mesh.face_id, np.int64)[own]]
        sources.append(np.where(face < 0, np.asarray(mesh.face_id, np.int64), -1))
        own_vertices, own_triangles = _merged(mesh)
        vertices.append(own_vertices)
        triangles.append(own_triangles + np.uint32(count))
        faces.append(face)
        count += len(own_vertices)
    return Part(*(np.concatenate(arrays) for arrays in (vertices, triangles, faces, sources)))


def _merged(mesh: Any) -> Mesh:
    """Vertices and triangles, with one vertex at each place."""
    target = np.arange(len(mesh.vert_properties))
    target[np.asarray(mesh.merge_from_vert, np.int64)] = np.asarray(mesh.merge_to_vert, np.int64)
    used, triangles = np.unique(target[np.asarray(mesh.tri_verts, np.int64)], return_inverse=True)
    return np.array(mesh.vert_properties[used, :3]), triangles.reshape(-1, 3).astype(np.uint32)


def texture_coordinates(part: Part) -> Float32:
    """(t, 3, 2) coordinates of all corners [m]: in the mean planes of cracks, the same on both
    sides, and along the axes of the mesh's frame on its own surface."""
    coordinates = np.zeros((len(part.triangles), 3, 2), np.float32)
    corners = part.vertices[part.triangles]
    area_vectors = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for face in np.unique(part.face[part.inner]):
        triangles = part.face == face
        normal = area_vectors[triangles].sum(axis=0)
        normal /= np.linalg.norm(normal)
        # Of the two sides of a crack, the one whose normal is positive along its longest component
        # decides.
        normal *= np.sign(normal[np.argmax(np.round(np.abs(normal), 6))])
        u = np.cross(normal, np.eye(3)[np.argmin(np.round(np.abs(normal), 6))])
        u /= np.linalg.norm(u)
        coordinates[triangles] = corners[triangles] @ np.column_stack([u, np.cross(normal, u)])

    # Outer faces are seen along the axis that they face, as pieces of a grid are.
    across = np.argmax(np.abs(area_vectors), axis=1)
    for axis, seen in enumerate(([2, 1], [0, 2], [0, 1])):
        faces = ~part.inner & (across == axis)
        coordinates[faces] = corners[faces][:, :, seen]
    return coordinates
