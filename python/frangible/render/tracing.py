"""Rays against what a stage shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..recording import Float32
from .stage import Int32, Stage

#: A plane is only seen where it is nearer than a surface by this part: what lies in it covers it.
COPLANAR = 1e-4


@dataclass(frozen=True, slots=True)
class Hits:
    """Where rays met the stage; only those that did."""

    #: (n,) which rays.
    rows: Int32
    #: (n,) index of the triangle or plane.
    triangle: Int32
    #: (n,) from the ray's origin [m].
    depth: Float32
    #: (n, 3) relative to the camera's target [m].
    points: Float32
    #: (n, 3) unit, on the eye's side: smooth, and of the triangle itself.
    normals: Float32
    flat: Float32
    #: (n, 2) weights of the triangle's second and third corner.
    weights: Float32


def trace(stage: Stage, origins: Float32, directions: Float32) -> Hits:
    """Follow rays from origins (n, 3) along unit directions (n, 3)."""
    hits = stage.scene.run(origins, directions, output=1)
    triangle, depth = hits["primID"].astype(np.int32), hits["tfar"]
    flat, u, v = hits["Ng"], hits["u"], hits["v"]
    for index, plane in enumerate(stage.planes):
        with np.errstate(divide="ignore", invalid="ignore"):
            way = (plane.height - origins @ plane.normal) / (directions @ plane.normal)
        nearer = (way > 0.0) & (way < depth * np.float32(1.0 - COPLANAR)) & np.isfinite(way)
        depth = np.where(nearer, way, depth)
        triangle[nearer] = stage.first_plane + index
        flat[nearer] = plane.normal
        u[nearer], v[nearer] = 0.0, 0.0
    rows = np.flatnonzero(triangle >= 0).astype(np.int32)
    triangle, depth, view = triangle[rows], depth[rows], directions[rows]
    weights = np.stack([u[rows], v[rows]], axis=1)

    # Normals on the eye's side.
    corners = stage.normals[triangle]
    rest = 1.0 - weights[:, 0] - weights[:, 1]
    smooth = (
        corners[:, 0] * rest[:, None]
        + corners[:, 1] * weights[:, :1]
        + corners[:, 2] * weights[:, 1:]
    )
    smooth, flat = unit(smooth), unit(flat[rows])
    flat *= np.where(dot(flat, view) > 0.0, np.float32(-1.0), np.float32(1.0))[:, None]
    smooth *= np.where(dot(flat, smooth) < 0.0, np.float32(-1.0), np.float32(1.0))[:, None]
    points = origins[rows] + depth[:, None] * view
    return Hits(rows, triangle, depth, points, smooth, flat, weights)


def openness(stage: Stage, points: Float32, towards: Float32, through_glass: float) -> Float32:
    """The share of the light (n,) that arrives at points (n, 3) from directions (n, 3)."""
    is_open = stage.solid.run(points, towards, query="OCCLUDED") < 0
    for plane in stage.planes:
        above = points @ plane.normal - plane.height
        is_open &= above * (towards @ plane.normal) >= 0.0
    share: Float32 = is_open.astype(np.float32)
    if stage.glass is not None:
        blocked = stage.glass.run(points, towards, query="OCCLUDED") >= 0
        share[blocked] *= np.float32(through_glass)
    return share


def dot(a: Float32, b: Float32) -> Float32:
    """(n,) products of vectors (n, 3)."""
    products: Float32 = np.einsum("ij,ij->i", a, b)
    return products


def unit(vectors: Float32) -> Float32:
    """Vectors (n, 3) of length 1."""
    length = np.sqrt(dot(vectors, vectors))
    length[length == 0.0] = 1.0
    scaled: Float32 = (vectors / length[:, None]).astype(np.float32, copy=False)
    return scaled


def where_lit(stage: Stage, hits: Hits) -> Float32:
    """(n, 3) where rays to the lights begin."""
    lifted: Float32 = hits.points + stage.lift[hits.triangle][:, None] * hits.flat
    return lifted
