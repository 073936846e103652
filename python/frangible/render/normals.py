"""Normals for drawing: smooth where a surface bends gently, sharp at its edges."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..recording import Body, Bool, Float32, Float64, UInt32

#: Faces that meet at a flatter angle look like one bent surface [degrees]; broken edges are far
#: sharper.
CREASE_DEGREES = 30.0


class ShadedMesh(NamedTuple):
    """A surface whose vertices are split along its creases."""

    #: (s,) the vertex that each split vertex copies.
    vertex: UInt32
    #: (s, 3) unit normals, body frame.
    normals: Float32
    #: (t, 3) indices of split vertices.
    triangles: UInt32


def shaded_mesh(vertices: Float32, triangles: UInt32, interior: Bool) -> ShadedMesh:
    """Split the vertices (v, 3) of triangles (t, 3) wherever the surface creases or a crack begins
    (t,)."""
    corner_normals = smooth_normals(vertices, triangles, interior)

    # Corners of one vertex with the same normal and side become one split vertex.
    corner_vertex = triangles.ravel().astype(np.int64)
    side = np.repeat(interior, 3).astype(np.int64)
    key = np.column_stack([corner_vertex, side, np.round(corner_normals * 1e4).astype(np.int64)])
    _, keep, split = np.unique(key, axis=0, return_index=True, return_inverse=True)
    return ShadedMesh(
        vertex=corner_vertex[keep].astype(np.uint32),
        normals=corner_normals[keep].astype(np.float32),
        triangles=split.reshape(-1, 3).astype(np.uint32),
    )


def smooth_normals(vertices: Float32, triangles: UInt32, interior: Bool) -> Float64:
    """(3 t, 3) unit normals of the corners of triangles (t, 3), smooth up to creases and cracks
    (t,)."""
    # Area-weighted and unit normals of the triangles; a sliver without area takes any normal.
    corners = vertices.astype(np.float64)[triangles]
    area_normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(area_normals, axis=1, keepdims=True)
    unit_normals = np.where(
        lengths > 0.0, area_normals / np.where(lengths > 0.0, lengths, 1.0), [0.0, 1.0, 0.0]
    )

    # All ordered pairs of corners that share a vertex.
    corner_vertex = triangles.ravel().astype(np.int64)
    order = np.argsort(corner_vertex, kind="stable")
    valence = np.bincount(corner_vertex, minlength=len(vertices))
    partners = valence[corner_vertex[order]]
    first_of_vertex = np.concatenate([[0], np.cumsum(valence)])[corner_vertex[order]]
    here = np.repeat(order, partners)
    rank = np.arange(len(here)) - np.repeat(np.cumsum(partners) - partners, partners)
    there = order[np.repeat(first_of_vertex, partners) + rank]

    # A corner's normal is the mean over its neighbours on the same side of every crease.
    t_here, t_there = here // 3, there // 3
    cosine = np.einsum("ij,ij->i", unit_normals[t_here], unit_normals[t_there])
    gentle = (cosine > np.cos(np.radians(CREASE_DEGREES))) & (interior[t_here] == interior[t_there])
    corner_normals = np.stack(
        [
            np.bincount(here[gentle], area_normals[t_there[gentle], axis], len(corner_vertex))
            for axis in range(3)
        ],
        axis=1,
    )
    lengths = np.linalg.norm(corner_normals, axis=1, keepdims=True)
    scale = np.where(lengths > 0.0, lengths, 1.0)
    smooth: Float64 = np.where(
        lengths > 0.0, corner_normals / scale, unit_normals.repeat(3, axis=0)
    )
    return smooth


def corner_normals(body: Body, shaded: ShadedMesh) -> Float32:
    """(t, 3, 3) unit normals of the triangles' corners: those of the mesh's file where it has
    some."""
    normals: Float32 = shaded.normals[shaded.triangles]
    if body.skin is not None and body.skin.normals is not None:
        own = body.skin.normals
        normals = np.where(np.any(own != 0.0, axis=2, keepdims=True), own, normals)
    return normals


def textured_corners(triangles: UInt32, coordinates: Float32) -> tuple[UInt32, Float32, UInt32]:
    """Distinct pairs of a vertex (n,) and its place in the texture (n, 2), and each triangle's
    three pairs (3 t,)."""
    corners = np.column_stack(
        [triangles.ravel(), coordinates.reshape(-1, 2).astype(np.float32).view(np.uint32)]
    )
    pairs, indices = np.unique(corners, axis=0, return_inverse=True)
    places = np.ascontiguousarray(pairs[:, 1:]).astype(np.uint32).view(np.float32)
    return pairs[:, 0].astype(np.uint32), places, indices.ravel().astype(np.uint32)
