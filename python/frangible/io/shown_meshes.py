"""A recording from meshes that move: what files of other programs, and ours, hold of a run."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ..recording import Body, Bool, Float32, Float64, Recording, UInt32, without_sign_flips
from ..skin import Skin
from .rotations import quaternions_of

#: A mesh that is smaller than this part of its first size is not shown: that is how files hide.
_HIDDEN = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class ShownMesh:
    """A mesh and where it is at each frame."""

    name: str
    #: What holds it: pieces and what they broke off from share one.
    group: str
    #: (v, 3) in its own frame.
    vertices: Float64
    #: (t, 3), and (t,) whether a crack made each.
    triangles: UInt32
    interior: Bool
    #: (t, 3, 2).
    coordinates: Float32
    skin: Skin | None
    #: (f + 1, 4, 4) ``world_from_mesh`` [m], of columns; one for all frames if it stands still.
    matrices: Float64
    #: (f + 1,) or (1,).
    is_shown: Bool


def recording_of(shot: str, fps: float, frames: int, meshes: list[ShownMesh]) -> Recording:
    """Bodies with the life and the motion of meshes; masses and breaks are not known."""
    bodies: list[Body] = []
    groups: list[str] = []
    for mesh in meshes:
        shown = _lives(mesh, frames)
        if shown is None:
            continue
        bodies.append(_body(mesh, len(bodies), shown, frames))
        groups.append(mesh.group)
    parents = _parents(bodies, groups)
    sources: dict[int, int] = {}
    for body in sorted(bodies, key=lambda body: body.birth_frame):
        parent = parents[body.id]
        sources[body.id] = body.id if parent is None else sources[parent]
    named = [replace(body, parent=parents[body.id], source=sources[body.id]) for body in bodies]
    named.sort(key=lambda body: (body.birth_frame, body.id))
    return Recording(shot, "", fps, frames, named)


def _lives(mesh: ShownMesh, frames: int) -> tuple[int, int] | None:
    """The first and the last frame that show a mesh; `None` if none does."""
    first = mesh.matrices[:, :3, :3]
    sizes = np.abs(np.linalg.det(first))
    shown = (sizes > _HIDDEN**3 * max(float(sizes.max(initial=0.0)), 1e-300)) & mesh.is_shown
    at = np.flatnonzero(np.broadcast_to(shown, (frames + 1,)))
    return (int(at[0]), int(at[-1])) if len(at) and len(mesh.triangles) else None


def _body(mesh: ShownMesh, number: int, shown: tuple[int, int], frames: int) -> Body:
    first, last = shown
    matrices = np.broadcast_to(mesh.matrices, (frames + 1, 4, 4))[first : last + 1]
    # Size and shear are those of its first frame: what follows is rigid.
    turns = quaternions_of(matrices[:, :3, :3])
    own = matrices[0, :3, :3]
    rotation = turns.matrices[0]
    vertices = mesh.vertices @ (rotation.T @ own).T
    # The body's place is its middle.
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    places = matrices[:, :3, 3] + np.einsum("fij,j->fi", turns.matrices, middle)
    stands = bool(np.all(np.ptp(places, axis=0) < 1e-9)) and len(mesh.matrices) == 1
    normals = None if mesh.skin is None else mesh.skin.normals
    skin = mesh.skin
    if skin is not None and normals is not None:
        turned = normals @ np.linalg.inv(rotation.T @ own)
        lengths = np.linalg.norm(turned, axis=-1, keepdims=True)
        skin = replace(skin, normals=(turned / np.maximum(lengths, 1e-30)).astype(np.float32))
    return Body(
        id=number,
        name=mesh.name,
        parent=None,
        source=number,
        birth_frame=first,
        death_frame=None if last == frames else last + 1,
        mass=math.inf if stands else math.nan,
        look=None,
        vertices=(vertices - middle).astype(np.float32),
        triangles=mesh.triangles,
        interior=mesh.interior,
        coordinates=mesh.coordinates,
        positions=places,
        orientations=without_sign_flips(turns.quaternions),
        skin=skin,
    )


def _parents(bodies: list[Body], groups: list[str]) -> dict[int, int | None]:
    """What goes at the frame in which others come, in the same group, is what these broke off
    from: of several, the one whose name theirs begins with, or else the nearest."""
    leaving: dict[tuple[str, int], list[Body]] = {}
    for body, group in zip(bodies, groups, strict=True):
        if body.death_frame is not None:
            leaving.setdefault((group, body.death_frame), []).append(body)
    parents: dict[int, int | None] = {}
    for body, group in zip(bodies, groups, strict=True):
        found = leaving.get((group, body.birth_frame), []) if body.birth_frame > 0 else []
        named = [one for one in found if body.name.startswith(one.name)]
        near = max(named, key=lambda one: len(one.name), default=None) or min(
            found, key=lambda one: _distance(one, body), default=None
        )
        parents[body.id] = None if near is None else near.id
    return parents


def _distance(before: Body, body: Body) -> float:
    return float(np.linalg.norm(before.positions[-1] - body.positions[0]))


def fan(counts: npt.NDArray[np.int64]) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Polygons with so many corners as triangles: (t, 3) corners, counted through all polygons, and
    (t,) the polygon of each."""
    begins = np.concatenate([[0], np.cumsum(counts)[:-1]])
    pieces = np.maximum(counts - 2, 0)
    polygon = np.repeat(np.arange(len(counts)), pieces)
    step = np.arange(len(polygon)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    first = begins[polygon]
    return np.stack([first, first + step + 1, first + step + 2], axis=1), polygon
