"""Convex colliders of pieces, for engines that collide convex shapes alone."""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold, Mesh

from ..pieces import Piece
from ..recording import Float64, UInt32

#: A part whose hull has more volume beside its own than this share of the piece's is cut again. An
#: arch of 5 pieces has 16 parts, which overlap by 0.15 % of its volume, and stands in MuJoCo; with
#: 2 % it has 10, which overlap by 1 % and push it over.
CONVEX_WITHIN = 0.002
#: No piece has more parts.
MOST_PARTS = 32
#: Hulls of less than this share of a piece's volume are left out: rounding, not shape.
LEAST_PART = 1e-6
#: Places along an axis where a part may be cut, over its length.
PLACES = (0.2, 0.35, 0.5, 0.65, 0.8)

#: Vertices (v, 3) and triangles (t, 3).
Hull = tuple[Float64, UInt32]


def convex_parts(piece: Piece) -> list[Hull]:
    """Hulls that cover a piece, relative to its centre of mass [m]; itself where it is convex.

    The least convex part is cut in two, where the two hulls have the least volume, until all are
    nearly convex.
    """
    places = piece.vertices - piece.center
    solid = Manifold(Mesh(places.astype(np.float32), piece.triangles.astype(np.uint32)))
    if solid.status().name != "NoError" or solid.volume() <= 0.0:
        return [_arrays(Manifold.hull_points(places))]
    parts = [solid]
    while len(parts) < MOST_PARTS:
        excess = [part.hull().volume() - part.volume() for part in parts]
        worst = int(np.argmax(excess))
        if excess[worst] <= CONVEX_WITHIN * piece.volume:
            break
        parts[worst : worst + 1] = _halves(parts[worst])
    hulls = [part.hull() for part in parts]
    large = [hull for hull in hulls if hull.volume() > LEAST_PART * piece.volume]
    return [_arrays(hull) for hull in large or hulls]


def _halves(part: Manifold) -> list[Manifold]:
    low, high = np.array(part.bounding_box()).reshape(2, 3)
    best, least = [part], np.inf
    for axis in range(3):
        normal = np.eye(3)[axis]
        for place in PLACES:
            offset = low[axis] + place * (high[axis] - low[axis])
            halves = [half for half in part.split_by_plane(normal, offset) if half.volume() > 0.0]
            volume = sum(half.hull().volume() for half in halves)
            if len(halves) == 2 and volume < least:
                best, least = halves, volume
    return best


def _arrays(hull: Manifold) -> Hull:
    mesh = hull.to_mesh64()
    return np.array(mesh.vert_properties, np.float64)[:, :3], np.array(mesh.tri_verts, np.uint32)
