"""Breaking a mesh file without a simulation."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from . import _frangible
from .cleaning import CleanMesh
from .output import missing_packages
from .piece_count import break_into
from .pieces import Contact, Piece, Pieces
from .progress import StageCallback, no_stage
from .recording import Float64, UInt32
from .usd_mesh import readable_mesh

#: Voxels along the longest side of a mesh that is broken, or closed, on a grid.
DEFAULT_VOXELS = 128
#: The largest number that is worth waiting for; the grid has to fit into memory as well.
MOST_VOXELS = 1024
#: A piece of less than this part of the mean piece's volume joins its neighbour.
DEFAULT_SMALLEST = 1e-4
#: Up.
DEFAULT_NORMAL = (0.0, 1.0, 0.0)


def break_mesh(
    path: str | os.PathLike[str],
    pattern: _frangible.Pattern,
    *,
    at: Sequence[float] | None = None,
    normal: Sequence[float] = DEFAULT_NORMAL,
    exact: bool = False,
    voxels: int = DEFAULT_VOXELS,
    pose_time: float | None = None,
    stage: StageCallback = no_stage,
    pieces: int | None = None,
    smallest: float = DEFAULT_SMALLEST,
) -> Pieces:
    """Break a mesh file along a pattern; `BuildError` if that cannot be done.

    The pattern's centre is laid on ``at`` [m], and its z axis along ``normal``, out of the mesh and towards what strikes it. Without
    ``at`` the blow goes through the middle of the bounding box and lands where it first meets the mesh.

    By default the mesh is sampled on a grid of ``voxels`` along its longest side, so that holes and crossings do no harm. ``exact``
    keeps the mesh's own triangles and cuts them: the extra ``exact`` of the installation must be there. What moves in a glTF or
    USD file is taken as it is ``pose_time`` [s] after its beginning, or at rest. ``stage`` is told what begins.

    With a number of ``pieces`` the pattern is made finer or coarser, one from a file larger, until there are about so many; a note
    says if it does not come within a tenth. A piece of less than ``smallest`` of the mean piece's volume joins its neighbour.
    """
    stage("reading the mesh")
    # Where the blow lands.
    with readable_mesh(path, pose_time) as file:
        clean = _frangible.clean_mesh(_frangible.load_mesh(file), file)
    mesh = (clean["vertices"], clean["triangles"])
    direction = np.array(normal, np.float64)
    length = np.linalg.norm(direction)
    if not np.all(np.isfinite(direction)) or length == 0.0:
        raise _frangible.BuildError(f"normal: {_listed(direction)}, must be finite and not zero")
    direction = direction / length
    point = landing_point(mesh, direction) if at is None else np.array(at, np.float64)
    if not np.all(np.isfinite(point)):
        raise _frangible.BuildError(f"at: {_listed(point)}, must be finite")
    if not 1 <= voxels <= MOST_VOXELS:
        raise _frangible.BuildError(f"voxels: {voxels}, must be 1 to {MOST_VOXELS}")
    if not 0.0 <= smallest <= 1.0:
        raise _frangible.BuildError(f"smallest: {smallest:g}, must be from 0 to 1")

    # Cut.
    name = os.path.splitext(os.path.basename(os.fspath(path)))[0]
    blow = (point, direction)
    if exact and (hint := missing_packages("exact")):
        raise _frangible.BuildError(f"exact: {hint}")
    break_it = _break_exactly if exact else _break_on_grid

    def cut(chosen: _frangible.Pattern) -> Pieces:
        stage("cutting the mesh along the pattern" if exact else f"breaking the mesh on a grid of {voxels} voxels along its longest side")
        return break_it(name, clean, chosen, blow, voxels, smallest)

    return cut(pattern) if pieces is None else break_into(pieces, pattern, mesh, blow, cut)


def _listed(vector: Float64) -> str:
    return f"({', '.join(f'{component:g}' for component in vector)})"


def landing_point(mesh: tuple[Float64, UInt32], normal: Float64) -> Float64:
    """Where a line against the normal through the middle of the bounding box first meets the mesh; without that, its vertex
    that is farthest along the normal."""
    vertices, triangles = mesh
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))

    # A triangle is met if the line passes its three edges on the same side.
    a, b, c = (vertices[triangles[:, corner]] - middle for corner in range(3))
    sides = np.stack([np.cross(a, b) @ normal, np.cross(b, c) @ normal, np.cross(c, a) @ normal], axis=1)
    met = np.all(sides >= 0.0, axis=1) | np.all(sides <= 0.0, axis=1)
    facing = np.einsum("ij,ij->i", np.cross(b - a, c - a), np.broadcast_to(normal, a.shape))
    met &= facing != 0.0
    if not met.any():
        farthest: Float64 = vertices[np.argmax(vertices @ normal)]
        return farthest
    area_normals = np.cross(b - a, c - a)[met]
    heights = np.einsum("ij,ij->i", a[met], area_normals) / facing[met]
    landing: Float64 = middle + heights.max() * normal
    return landing


def _break_on_grid(
    name: str,
    clean: CleanMesh,
    pattern: _frangible.Pattern,
    blow: tuple[Float64, Float64],
    voxels: int,
    smallest: float,
) -> Pieces:
    at, normal = blow
    mesh = (clean["vertices"], clean["triangles"])
    broken = _frangible.break_mesh_on_grid(pattern, mesh, at.tolist(), normal.tolist(), voxels, smallest)
    notes = [*clean["notes"], f"broken on a grid of {voxels} voxels along the longest side"]
    # What is smaller than a voxel has no surface there.
    specks = [number for number, piece in enumerate(broken["pieces"]) if len(piece["triangles"]) == 0]
    if specks:
        part = math.fsum(broken["pieces"][number]["volume_m3"] for number in specks) / broken["volume_m3"]
        what = "1 speck" if len(specks) == 1 else f"{len(specks)} specks"
        notes.append(f"{what} smaller than a voxel left out, {part:.1g} of the volume")
    pieces: list[Piece] = []
    number_of: dict[int, int] = {}
    for number, piece in enumerate(broken["pieces"]):
        if number in specks:
            continue
        number_of[number] = len(pieces)
        surface = (piece["vertices"], piece["triangles"])
        pieces.append(_piece(len(pieces), surface, piece["inner"], piece["coordinates"], piece))
    found: list[Contact] = broken["contacts"]
    contacts: list[Contact] = [
        {**contact, "a": number_of[contact["a"]], "b": number_of[contact["b"]]}
        for contact in found
        if contact["a"] in number_of and contact["b"] in number_of
    ]
    return Pieces(name, pieces, contacts, broken["volume_m3"], at, normal, notes)


def _break_exactly(
    name: str,
    clean: CleanMesh,
    pattern: _frangible.Pattern,
    blow: tuple[Float64, Float64],
    voxels: int,
    smallest: float,
) -> Pieces:
    from .boolean import closed, crack_coordinates, cut

    at, normal = blow
    solid, notes = closed(clean, voxels)
    box = solid.bounding_box()
    cutters = _frangible.pattern_cutters(pattern, (box[:3], box[3:]), at.tolist(), normal.tolist())
    parts = cut(solid, cutters, smallest)
    pieces: list[Piece] = []
    for part in parts:
        surface = (part.vertices, part.triangles)
        mass = _frangible.mesh_mass(surface)
        pieces.append(_piece(len(pieces), surface, part.inner, crack_coordinates(part), mass))
    contacts = _frangible.piece_contacts([((part.vertices, part.triangles), part.inner) for part in parts])
    return Pieces(name, pieces, contacts, solid.volume(), at, normal, notes)


def _piece(index: int, surface: tuple[Float64, UInt32], inner: Any, coordinates: Any, mass: dict[str, Any]) -> Piece:
    return Piece(
        name=f"piece_{index:03}",
        vertices=surface[0],
        triangles=surface[1],
        inner=inner,
        coordinates=coordinates,
        volume=mass["volume_m3"],
        center=np.array(mass["center_m"]),
        unit_inertia=np.array(mass["unit_inertia_m5"]),
    )
