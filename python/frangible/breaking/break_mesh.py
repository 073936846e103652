"""Breaking a mesh file without a simulation."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _frangible
from ..extras import missing_packages
from ..interrupts import deaf_work
from ..io.mesh_files import check_ending, readable_mesh
from ..pieces import Contact, Piece, Pieces
from ..progress import StageCallback, no_stage
from ..recording import Float64
from .blow import far_off, finite_point, landing_point, unit_direction
from .cleaning import MOST_BURIED, CleanMesh
from .mesh_skin import Below, MeshSkin, read_skin
from .piece_count import LEAST_PIECES, MOST_PIECES, break_on_grid_into, difference
from .volumes import SILENT_WITHIN, volumes_differ

if TYPE_CHECKING:
    from manifold3d import Manifold

    from .exact_cut import Part

#: Voxels along the longest side of a mesh that is broken, or closed, on a grid.
DEFAULT_VOXELS = 128
#: The largest number that is worth waiting for; the grid has to fit into memory as well.
MOST_VOXELS = 1024
#: A piece of less than this part of the mean piece's volume joins its neighbour.
DEFAULT_SMALLEST = 1e-2
#: Up.
DEFAULT_NORMAL = (0.0, 1.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class _Target:
    """A cleaned mesh and the blow that breaks it."""

    name: str
    clean: CleanMesh
    #: Attributes of its file.
    skin: MeshSkin | None
    #: (3,) place of the blow [m], and unit direction from there towards what strikes.
    at: Float64
    normal: Float64
    #: Of a grid, along the longest side.
    voxels: int
    #: Of the mean piece's volume.
    smallest: float


def break_mesh(
    path: str | os.PathLike[str],
    pattern: _frangible.Pattern,
    *,
    at: Sequence[float] | None = None,
    normal: Sequence[float] = DEFAULT_NORMAL,
    exact: bool | None = None,
    voxels: int = DEFAULT_VOXELS,
    inside: str | None = None,
    pose_time: float | None = None,
    stage: StageCallback = no_stage,
    pieces: int | None = None,
    smallest: float = DEFAULT_SMALLEST,
    thickness: float | None = None,
) -> Pieces:
    """Break a mesh file along a pattern; `BuildError` if that cannot be done.

    The pattern's centre is laid on ``at`` [m], and its z axis along ``normal``, out of the mesh and
    towards what strikes it. Without ``at`` the blow goes through the middle of the bounding box and
    lands where it first meets the mesh.

    The mesh's own triangles are cut, wherever it bounds a solid or can be made to; what crosses
    itself gets a new surface from a grid of ``voxels`` along the longest side. With ``exact`` the
    latter is an error, and so is a missing extra ``exact`` of the installation, without which
    samples of the mesh are broken on the grid. Where ``exact`` is false all surfaces are made anew
    on one grid and cut.

    Pieces keep what the file says of their outer faces; ``inside`` names the material of the
    others: one of the file's, a look such as concrete, or a new one. What moves in a glTF or USD
    file is taken as it is ``pose_time`` [s] after its beginning, or at rest. ``stage`` is told what
    begins.

    With a number of ``pieces`` the pattern is made for each part that lies apart, or one from a
    file laid on larger, until there are about so many; a note says if it does not come within a
    tenth. A piece of less than ``smallest`` of the mean piece's volume joins its neighbour; a loose
    part as small stays whole, and is not counted.

    With a ``thickness`` [m] open parts are sheets, and plates so thick take their place; without it
    their holes are closed, and flat ones are left out.
    """
    stage("reading the mesh")
    check_ending(path)
    _check_counts(voxels, pieces, smallest)
    with readable_mesh(path, pose_time) as file:
        clean = _solids(file, thickness)
        skin = read_skin(os.fspath(path), file, inside)
    mesh = (clean["vertices"], clean["triangles"])
    direction = unit_direction(normal)
    point = landing_point(mesh, direction) if at is None else finite_point(at)
    name = os.path.splitext(os.path.basename(os.fspath(path)))[0]
    target = _Target(name, clean, skin, point, direction, voxels, smallest)

    hint = missing_packages("exact")
    if exact:
        _check_exact(path, clean, hint)
    if hint is not None:
        stage(f"breaking the mesh on a grid of {voxels} voxels along its longest side")
        uncut = "the mesh itself" if exact is None else "the grid's surface"
        broken = _break_uncut(target, pattern, pieces, f"cutting {uncut} {hint}")
    elif exact is False:
        stage(f"sampling the mesh on a grid of {voxels} voxels along its longest side")
        broken = _break_sampled(target, pattern, pieces, stage)
    else:
        stage("cutting the mesh along the pattern")
        with deaf_work():
            broken = _break_exactly(target, pattern, pieces)
    broken.notes.extend(far_off(mesh, point, len(broken.pieces)))
    return broken


def _check_counts(voxels: int, pieces: int | None, smallest: float) -> None:
    if not 1 <= voxels <= MOST_VOXELS:
        raise _frangible.BuildError(f"voxels: {voxels}, must be from 1 to {MOST_VOXELS}")
    if pieces is not None and not LEAST_PIECES <= pieces <= MOST_PIECES:
        rule = f"from {LEAST_PIECES} to {MOST_PIECES}"
        raise _frangible.BuildError(f"pieces: {pieces}, must be {rule}")
    if not 0.0 <= smallest <= 1.0:
        raise _frangible.BuildError(f"smallest: {smallest:g}, must be from 0 to 1")


def _check_exact(path: str | os.PathLike[str], clean: CleanMesh, hint: str | None) -> None:
    """`BuildError` if a mesh cannot be cut exactly: a library is missing, or it crosses itself."""
    if hint:
        raise _frangible.BuildError(f"exact: {hint}")
    crosses = int((clean["buried"] > MOST_BURIED).sum())
    if crosses:
        surfaces = (
            "a surface that crosses itself"
            if crosses == 1
            else f"{crosses} surfaces that cross themselves"
        )
        raise _frangible.BuildError(
            f"{path}: has {surfaces}, must have none to be cut exactly; without --exact they are "
            "made anew"
        )


def _break_uncut(
    target: _Target, pattern: _frangible.Pattern, pieces: int | None, reason: str
) -> Pieces:
    """Samples of the mesh, broken on the grid, as without the extra ``exact``; notes the reason."""
    if pieces is None:
        on_grid = _break_on_grid(target, pattern)
    else:
        on_grid = break_on_grid_into(
            pieces,
            pattern,
            (target.clean["vertices"], target.clean["triangles"]),
            (target.at, target.normal),
            target.voxels,
            lambda chosen: _break_on_grid(target, chosen),
        )
    broken = _pieces_on_grid(target, on_grid)
    broken.notes.append(reason)
    if pieces is not None and (sentence := difference(len(broken.pieces), pieces)):
        broken.notes.append(sentence)
    return broken


def _solids(file: str, thickness: float | None) -> CleanMesh:
    """The solids of a mesh file, with plates for its open parts if they have a thickness [m]."""
    raw = _frangible.load_mesh(file)
    if thickness is None:
        return _frangible.clean_mesh(raw, file)
    thick, plates = _frangible.thicken_mesh(raw, thickness, file)
    clean = _frangible.clean_mesh(thick, file)
    parts = {0: "no open part that could be", 1: "1 open part"}.get(plates, f"{plates} open parts")
    clean["notes"].insert(0, f"{parts} made a plate {thickness:g} m thick")
    return clean


def _break_on_grid(target: _Target, pattern: _frangible.Pattern) -> dict[str, Any]:
    mesh = (target.clean["vertices"], target.clean["triangles"])
    return _frangible.break_mesh_on_grid(
        pattern, mesh, target.at.tolist(), target.normal.tolist(), target.voxels, target.smallest
    )


def _pieces_on_grid(target: _Target, broken: dict[str, Any]) -> Pieces:
    """The pieces of `_break_on_grid`, with the mesh's attributes."""
    voxels = target.voxels
    notes = [*target.clean["notes"], f"broken on a grid of {voxels} voxels along the longest side"]
    # What is smaller than a voxel has no surface there, or none that encloses anything.
    voxel = float(np.ptp(target.clean["vertices"], axis=0).max()) / voxels
    specks = [
        number
        for number, piece in enumerate(broken["pieces"])
        if _frangible.mesh_mass((piece["vertices"], piece["triangles"]))["volume_m3"] < voxel**3
    ]
    if specks:
        part = (
            math.fsum(broken["pieces"][number]["volume_m3"] for number in specks)
            / broken["volume_m3"]
        )
        what = "1 speck" if len(specks) == 1 else f"{len(specks)} specks"
        notes.append(f"{what} smaller than a voxel left out, {part:.1g} of the volume")
    shown = [number for number in range(len(broken["pieces"])) if number not in specks]
    number_of = {number: index for index, number in enumerate(shown)}
    surfaces: list[Any] = [
        [broken["pieces"][number][key] for key in ("vertices", "triangles", "inner")]
        for number in shown
    ]
    coordinates = [broken["pieces"][number]["coordinates"] for number in shown]
    pieces = _pieces(surfaces, coordinates, target.skin, None)
    found: list[Contact] = broken["contacts"]
    contacts: list[Contact] = [
        {**contact, "a": number_of[contact["a"]], "b": number_of[contact["b"]]}
        for contact in found
        if contact["a"] in number_of and contact["b"] in number_of
    ]
    whole, sentence = _against_mesh(target, broken["volume_m3"], pieces)
    notes += sentence
    return Pieces(target.name, pieces, contacts, whole, target.at, target.normal, notes)


def _break_exactly(target: _Target, pattern: _frangible.Pattern, wanted: int | None) -> Pieces:
    from .exact_cut import arrays
    from .solids import closed

    clean, skin = target.clean, target.skin
    solid, notes = closed(clean, target.voxels)
    parts, counted = _parts(target, solid, pattern, wanted)
    notes += counted

    # The triangle of the file that each of the solid's lies in, if its surface is the file's.
    found: list[Below] | None = None
    if skin is not None and not (clean["buried"] > MOST_BURIED).any():
        vertices, triangles = arrays(solid)
        corners = vertices[triangles]
        faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        reach = np.linalg.norm(np.ptp(corners, axis=1), axis=1)
        below = skin.closest(corners.mean(axis=1), faces, reach)
        outer = [below[part.source[~part.inner]] for part in parts]
        found = [(own, np.repeat(own[:, None], 3, axis=1)) for own in outer]
    pieces, contacts = _pieces_of_parts(target, parts, found)
    whole, written = solid.volume(), math.fsum(piece.volume for piece in pieces)
    if abs(written / whole - 1.0) > SILENT_WITHIN:
        notes.append(
            f"the mesh encloses {whole:.4g} m^3, but the pieces' surfaces enclose {written:.4g} m^3"
            f" ({written / whole - 1.0:+.1%}): some of it is turned inside out"
        )
    return Pieces(target.name, pieces, contacts, whole, target.at, target.normal, notes)


def _break_sampled(
    target: _Target, pattern: _frangible.Pattern, wanted: int | None, stage: StageCallback
) -> Pieces:
    """The same of a surface that is made anew on a grid."""
    from .solids import on_grid

    # What the file says of its faces is laid on triangle by triangle.
    is_even = target.skin is None or target.skin.is_even
    solid, notes = on_grid(target.clean, target.voxels, simpler=is_even)
    stage("cutting the new surface along the pattern")
    with deaf_work():
        parts, counted = _parts(target, solid, pattern, wanted)
    pieces, contacts = _pieces_of_parts(target, parts, None)
    whole, sentence = _against_mesh(target, solid.volume(), pieces)
    notes += sentence + counted
    return Pieces(target.name, pieces, contacts, whole, target.at, target.normal, notes)


def _parts(
    target: _Target, solid: Manifold, pattern: _frangible.Pattern, wanted: int | None
) -> tuple[list[Part], list[str]]:
    """What the pattern's cells cut out of a solid, and what there is to say of its number."""
    from .exact_cut import cut, labelled
    from .part_shares import Blow, pieces_of

    body = labelled(solid)
    if wanted is not None:
        return pieces_of(body, Blow(pattern, target.at, target.normal, target.smallest), wanted)
    box = solid.bounding_box()
    at, normal = target.at.tolist(), target.normal.tolist()
    cutters = _frangible.pattern_cutters(pattern, (box[:3], box[3:]), at, normal, 1.0)
    made = cut(body, cutters, target.smallest)
    notes = []
    if made.crumbs:
        those = "1 loose part is" if made.crumbs == 1 else f"{made.crumbs} loose parts are"
        notes.append(f"{those} smaller than {target.smallest:g} of the mean piece")
    return made.parts(), notes


def _pieces_of_parts(
    target: _Target, parts: list[Part], found: list[Below] | None
) -> tuple[list[Piece], list[Contact]]:
    """``found`` as in `_pieces`."""
    from .exact_cut import texture_coordinates

    surfaces = [(part.vertices, part.triangles, part.inner) for part in parts]
    coordinates = [texture_coordinates(part) for part in parts]
    contacts = _frangible.piece_contacts(
        [((part.vertices, part.triangles), part.inner) for part in parts]
    )
    return _pieces(surfaces, coordinates, target.skin, found), contacts


def _against_mesh(target: _Target, on_grid: float, pieces: list[Piece]) -> tuple[float, list[str]]:
    """The volume [m^3] of a mesh that was broken on a grid, and the sentence if the grid or the
    pieces hold another one."""
    clean = target.clean
    mesh = (clean["vertices"], clean["triangles"])
    # Solids that meet have a volume of their own only where they were united.
    is_known = not clean["meets"].any() and not (clean["buried"] > MOST_BURIED).any()
    whole = _frangible.mesh_mass(mesh)["volume_m3"] if is_known else on_grid
    written = math.fsum(piece.volume for piece in pieces)
    sentence = volumes_differ(mesh, whole, on_grid, written, target.voxels)
    return whole, [sentence] if sentence else []


def _pieces(
    surfaces: Any, coordinates: list[Any], skin: MeshSkin | None, found: list[Below] | None
) -> list[Piece]:
    """Pieces with the mass properties of their surfaces: vertices, triangles, and which are inner.
    ``found`` is what lies below them in the mesh's file, if that is known."""
    skins: list[Any] = [None] * len(surfaces)
    if skin is not None:
        found = skin.below(surfaces) if found is None else found
        for index, (surface, own) in enumerate(zip(surfaces, found, strict=True)):
            skins[index], coordinates[index] = skin.lay_on(
                surface[0], surface[1], surface[2], coordinates[index], own
            )
    pieces = []
    for index, (vertices, triangles, inner) in enumerate(surfaces):
        mass = _frangible.mesh_mass((vertices, triangles))
        pieces.append(
            Piece(
                name=f"piece_{index:03}",
                vertices=vertices,
                triangles=triangles,
                inner=inner,
                coordinates=coordinates[index],
                volume=mass["volume_m3"],
                center=np.array(mass["center_m"]),
                unit_inertia=np.array(mass["unit_inertia_m5"]),
                skin=skins[index],
            )
        )
    return pieces
