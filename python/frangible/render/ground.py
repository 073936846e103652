"""Half-spaces: bodies without an edge, of which files and pictures show a part."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..recording import Body, Float64, Recording, rotation_matrix
from ..skin import NO_MATERIAL, Skin

#: Edge of the square that files show, over the size of what moves at first.
REACH = 6.0


def is_half_space(body: Body) -> bool:
    """True if a body is everything below the plane y = 0 of its own frame: it alone has no
    surface."""
    return not len(body.triangles) and not np.isfinite(body.mass)


def with_visible_ground(recording: Recording) -> Recording:
    """The same recording with a square patch of every half-space, below the middle of what
    moves."""
    if not any(is_half_space(body) for body in recording.bodies):
        return recording
    moving = [
        body.vertices_world(0) for body in recording.alive(0) if body.moves and len(body.vertices)
    ]
    points = np.concatenate(moving) if moving else np.zeros((1, 3))
    low, high = points.min(axis=0), points.max(axis=0)
    size = REACH * max(float(np.max(high - low)), 1e-3)
    bodies = [
        _patched(body, (low + high) / 2, size) if is_half_space(body) else body
        for body in recording.bodies
    ]
    return replace(recording, bodies=bodies)


def patch(body: Body, below: Float64, size: float) -> Float64:
    """Corners (4, 3) of a square of a half-space's plane around the point below ``below``, body
    frame [m]."""
    position, orientation = body.pose(body.birth_frame)
    x, _, z = (below - position) @ rotation_matrix(orientation)
    half = size / 2
    return np.array(
        [
            [x - half, 0, z - half],
            [x - half, 0, z + half],
            [x + half, 0, z + half],
            [x + half, 0, z - half],
        ]
    )


def _patched(body: Body, below: Float64, size: float) -> Body:
    corners, triangles = (
        patch(body, below, size).astype(np.float32),
        np.array([[0, 1, 2], [0, 2, 3]], np.uint32),
    )
    skin = body.skin
    if skin is not None:
        # A half-space has the one material that its patch shows.
        number = 0 if len(skin.materials) == 1 else NO_MATERIAL
        skin = Skin(skin.materials, np.full(2, number, np.int32), path=skin.path)
    return replace(
        body,
        skin=skin,
        vertices=corners,
        triangles=triangles,
        interior=np.zeros(2, np.bool_),
        coordinates=corners[triangles][:, :, [0, 2]],
    )
