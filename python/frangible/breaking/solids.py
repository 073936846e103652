"""The solid that is cut: of a clean mesh as it is, or made anew on a grid."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from manifold3d import Manifold, OpType

from .. import _frangible
from .._frangible import BuildError
from ..recording import UInt32
from .cleaning import MOST_BURIED, CleanMesh
from .exact_cut import Mesh, arrays, as_manifold

#: Solids that are united in one call.
AT_ONCE = 16
#: Volumes that differ by less are the same, relatively.
SAME = 1e-12
#: Voxels in the thickness of what a grid can make anew: thinner plates lose most of their volume.
LEAST_THICKNESS = 1.0
#: Smaller solids are not made anew [voxels], and smaller shells that a grid shows are what it
#: leaves of thinner walls, no parts of the solid.
LEAST_SHELL = 27.0
#: A grid shows no more of a thin plate than this many times its volume.
CANCELS = 1.5
#: By this part of a voxel a surface from a grid may move for fewer triangles: below its own error.
SIMPLER = 0.03


def closed(clean: CleanMesh, voxels: int) -> tuple[Manifold, list[str]]:
    """The solid that a clean mesh bounds, and what had to be done to it in sentences."""
    notes = list(clean["notes"])
    anew = np.flatnonzero(clean["buried"] > MOST_BURIED)
    whole = as_manifold(clean["vertices"], clean["triangles"])
    if len(anew) == 0 and not clean["meets"].any():
        return whole, notes

    # A surface that crosses itself is made anew, the others keep their triangles.
    count = len(clean["meets"])
    surfaces = _surfaces(clean, count)
    kept = []
    for number in anew:
        made = _made_anew(surfaces[number], voxels)
        if made is None:
            kept.append(number)
        else:
            surfaces[number] = made
    on_grid = f"a grid of {voxels} voxels along the longest side"
    if len(anew) > len(kept):
        notes.append(f"{_crossing(len(anew) - len(kept))} made anew, on {on_grid}")
    if kept:
        notes.append(f"{_crossing(len(kept))} kept, too thin for {on_grid}")
    solids = [as_manifold(*surface) for surface in surfaces]
    united = _united(solids)

    # Solids that only came near one another stay as they are.
    apart = sum(solid.volume() for solid in solids)
    if (
        len(anew) == 0
        and abs(united.volume() - apart) <= SAME * apart
        and united.num_tri() == whole.num_tri()
    ):
        return whole, notes
    if clean["meets"].any():
        notes.append(
            f"{int(clean['meets'].sum())} parts that cross, touch or lie in one another made one"
        )
    return united, notes


def on_grid(clean: CleanMesh, voxels: int, simpler: bool = True) -> tuple[Manifold, list[str]]:
    """The solid that a clean mesh bounds, with all surfaces made anew on one grid of ``voxels``
    along the longest side, and what was done in sentences. Solids that are thinner than a voxel, or
    smaller than 27 of them, keep their own surface. Flat faces get few triangles, unless
    ``simpler`` is false."""
    notes = list(clean["notes"])
    surfaces = _surfaces(clean, len(clean["meets"]))
    voxel = float(np.ptp(clean["vertices"], axis=0).max()) / voxels
    is_thin = np.array([_is_too_small(surface, voxel) for surface in surfaces])
    for number in np.flatnonzero(is_thin & (clean["buried"] > MOST_BURIED)):
        size = float(np.ptp(surfaces[number][0], axis=0).max())
        is_thin[number] = _made_anew(surfaces[number], max(1, round(size / voxel))) is None
    made = None
    if not is_thin.all():
        triangles = clean["triangles"][~is_thin[clean["solid"]]]
        used, triangles = np.unique(triangles, return_inverse=True)
        thick = clean["vertices"][used], triangles.reshape(-1, 3).astype(np.uint32)
        along = max(1, round(float(np.ptp(thick[0], axis=0).max()) / voxel))
        made = _resurfaced(thick, along, simpler)
    if made is None:
        is_thin[:] = True
    else:
        notes.append(f"surface made anew on a grid of {voxels} voxels along the longest side")
    if not is_thin.any():
        assert made is not None
        return made, notes
    count = int(is_thin.sum())
    one, several = "1 part thinner than a voxel keeps its", "parts thinner than a voxel keep their"
    notes.append(f"{one if count == 1 else f'{count} {several}'} own surface")
    kept = [as_manifold(*surface) for surface, thin in zip(surfaces, is_thin, strict=True) if thin]
    return _united(kept if made is None else [made, *kept]), notes


def _made_anew(surface: Mesh, voxels: int) -> Mesh | None:
    """The solid in a surface that crosses itself, made anew on a grid; `None` if it is too thin for
    that."""
    voxel = float(np.ptp(surface[0], axis=0).max()) / voxels
    made = _resurfaced(surface, voxels, True)
    if made is None:
        return None
    # Where some of it is turned inside out, what it encloses cancels, and it only seems thin.
    cancels = made.volume() > CANCELS * _frangible.mesh_mass(surface)["volume_m3"]
    return arrays(made) if cancels or not _is_too_small(surface, voxel) else None


def _is_too_small(surface: Mesh, voxel: float) -> bool:
    """True if a surface encloses a plate or a crumb that a grid would not show."""
    vertices, triangles = surface
    corners = vertices[triangles]
    sides = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = np.linalg.norm(np.cross(*sides), axis=1)
    volume = _frangible.mesh_mass(surface)["volume_m3"]
    # A plate's thickness is twice its volume by its area.
    thickness = 4.0 * volume / areas.sum()
    return bool(thickness < LEAST_THICKNESS * voxel or volume < LEAST_SHELL * voxel**3)


def _resurfaced(surface: Mesh, voxels: int, simpler: bool) -> Manifold | None:
    """What a grid of ``voxels`` along the longest side shows of the solids in a surface, without
    specks; `None` if that is nothing."""
    voxel = float(np.ptp(surface[0], axis=0).max()) / voxels
    try:
        vertices, triangles = _frangible.resurface(surface, voxels)
    except BuildError:
        return None
    shell = _shells(len(vertices), triangles)
    sides = vertices[triangles]
    volumes = np.einsum("ij,ij->i", sides[:, 0], np.cross(sides[:, 1], sides[:, 2])) / 6.0
    is_large = np.abs(np.bincount(shell, volumes)) >= LEAST_SHELL * voxel**3
    if not is_large.any():
        return None
    made = as_manifold(vertices, triangles[is_large[shell]])
    return made.simplify(SIMPLER * voxel) if simpler else made


def _shells(count: int, triangles: UInt32) -> npt.NDArray[np.int64]:
    """(t,) the number of the connected part that each triangle is in, of ``count`` vertices."""
    corners = triangles.astype(np.int64)
    label = np.arange(count)
    while True:
        # The lowest number of each triangle's corners goes to all of them and to their parts.
        lowest = label[corners].min(axis=1)
        new = label.copy()
        for corner in corners.T:
            np.minimum.at(new, label[corner], lowest)
        new = new[new]
        new = new[label]
        if np.array_equal(new, label):
            return np.unique(label[corners[:, 0]], return_inverse=True)[1]
        label = new


def _crossing(count: int) -> str:
    if count == 1:
        return "a surface that crosses itself was"
    return f"{count} surfaces that cross themselves were"


def _united(solids: list[Manifold]) -> Manifold:
    """The union, a few at a time: between them signals are heard."""
    while len(solids) > 1:
        solids = [
            Manifold.batch_boolean(solids[n : n + AT_ONCE], OpType.Add)
            for n in range(0, len(solids), AT_ONCE)
        ]
        for solid in solids:
            solid.num_tri()
    return solids[0]


def _surfaces(clean: CleanMesh, count: int) -> list[Mesh]:
    """The surface of each solid, with its cavities."""
    order = np.argsort(clean["solid"], kind="stable")
    bounds = np.searchsorted(clean["solid"][order], np.arange(count + 1))
    surfaces = []
    for first, last in zip(bounds[:-1], bounds[1:], strict=True):
        used, triangles = np.unique(clean["triangles"][order[first:last]], return_inverse=True)
        surfaces.append((clean["vertices"][used], triangles.reshape(-1, 3).astype(np.uint32)))
    return surfaces
