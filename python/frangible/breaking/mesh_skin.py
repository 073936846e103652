"""Attributes of a mesh file, laid on the surfaces that are made of the mesh."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from .._frangible import closest_triangles, mesh_attributes
from ..io.material_files import Known, read_materials
from ..materials import INSIDE, INSIDE_ROUGHNESS, LOOKS, OUTSIDE_ROUGHNESS, Material
from ..recording import Bool, Float32, Float64, Int64, UInt32
from ..skin import NO_MATERIAL, Skin

#: The triangle of a mesh below each outer triangle of a surface (n,), and below each of its corners
#: (n, 3).
Below = tuple[Int64, Int64]

#: A surface belongs to the deepest node of its file that this part of its area is of.
OWNER = 0.9
#: What lies below a surface is no farther from it than this part of the mesh's diagonal.
MOST_REACH = 1.0 / 64.0
#: Texture coordinates may go on beyond a triangle by this part of it.
MOST_BEYOND = 0.5
#: Of what has colours of its corners and no material.
CORNER_COLOURS = Material(
    (1.0, 1.0, 1.0), OUTSIDE_ROUGHNESS, name="corner_colours", corner_colours=True
)


@dataclass(frozen=True, eq=False)
class MeshSkin:
    """Of the triangles (t,) of a mesh's file, in its own frame and order."""

    #: (t, 3, 3) [m].
    corners: Float64
    materials: tuple[Material, ...]
    #: (t,) index, `NO_MATERIAL` for none.
    material: npt.NDArray[np.int32]
    #: Names of each object and of what is above it, and the index of each triangle's (t,), -1 for
    #: none.
    paths: list[tuple[str, ...]]
    object: npt.NDArray[np.int32]
    #: (t, 3, n) of the corners; NaN where the file has none.
    coordinates: Float32
    normals: Float32
    colours: Float32
    #: Of what cracks lay bare; `None` for what the look decides.
    inside: Material | None

    @cached_property
    def charts(self) -> Int64:
        """(t,) the same number for triangles that hang together without a seam in anything that
        their corners have."""
        rows = np.concatenate([self.coordinates, self.normals, self.colours], axis=2).reshape(-1, 9)
        places = (self.corners + 0.0).reshape(-1, 3)
        keys = np.column_stack(
            [places.view(np.int64), rows.view(np.int32), np.repeat(self.material, 3)]
        )
        corner = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1, 3)
        label = np.arange(corner.max(initial=-1) + 1)
        while True:
            # The lowest number of each triangle's corners goes to all of them, and on along what it
            # stands for.
            lowest = label[corner].min(axis=1)
            new = label.copy()
            np.minimum.at(new, corner.ravel(), np.repeat(lowest, 3))
            new = new[new]
            if np.array_equal(new, label):
                return label[corner[:, 0]].astype(np.int64)
            label = new

    @cached_property
    def has_colours(self) -> bool:
        """True if any corner has one."""
        return bool(np.isfinite(self.colours).any())

    @cached_property
    def is_even(self) -> bool:
        """True if all faces look alike."""
        is_plain = not self.has_colours and not np.isfinite(self.coordinates).any()
        return is_plain and bool(np.all(self.material == self.material[:1]))

    @cached_property
    def has_normals(self) -> bool:
        """True if any corner has one."""
        return bool(np.isfinite(self.normals).any())

    def closest(
        self, points: Float64, normals: Float64, reach: Float64, charts: Int64 | None = None
    ) -> Int64:
        """(n,) the triangle closest to each point (n, 3), of any chart, or of those: one that faces
        the same way as its normal, unless that is farther than the closest by more than its reach
        (n,) [m]."""
        wanted = np.full(len(points), -1, np.int64) if charts is None else charts
        own = np.zeros(len(self.corners), np.int64) if charts is None else self.charts
        reach = np.minimum(
            reach, MOST_REACH * np.linalg.norm(np.ptp(self.corners.reshape(-1, 3), axis=0))
        )
        arrays = (
            np.ascontiguousarray(points),
            np.ascontiguousarray(normals),
            wanted,
            np.ascontiguousarray(reach),
        )
        return closest_triangles(self.corners, own, *arrays)

    def below(self, surfaces: list[tuple[Float64, UInt32, Bool]]) -> list[Below]:
        """The file's triangles below the outer triangles of surfaces (vertices, triangles, inner),
        in the mesh's own frame.

        It is the closest triangle; of a corner the closest within the same chart.
        """
        corners = np.concatenate(
            [
                np.zeros((0, 3, 3)),
                *(vertices[triangles[~inner]] for vertices, triangles, inner in surfaces),
            ]
        )
        faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        reach = np.linalg.norm(np.ptp(corners, axis=1), axis=1)
        below = self.closest(corners.mean(axis=1), faces, reach)
        charts = np.repeat(self.charts[below], 3)
        each = self.closest(
            corners.reshape(-1, 3), np.repeat(faces, 3, axis=0), np.repeat(reach, 3), charts
        )
        ends = np.cumsum([int((~inner).sum()) for _, _, inner in surfaces])[:-1]
        return list(zip(np.split(below, ends), np.split(each.reshape(-1, 3), ends), strict=True))

    def lay_on(
        self,
        vertices: Float64,
        triangles: UInt32,
        inner: Bool,
        coordinates: Float32,
        found: Below,
    ) -> tuple[Skin, Float32]:
        """The skin and the texture coordinates of a surface, in the mesh's own frame, given what
        lies below it."""
        if not len(triangles):
            return self._without_surface(), coordinates
        outer = np.flatnonzero(~inner)
        corners = vertices[triangles[outer]]
        faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        below, each = found
        weights = _weights(corners, self.corners[each])[..., None]

        def blended(values: Float32, beyond: float = 0.0) -> Float32:
            bounded = np.maximum(weights, -beyond)
            mixed: Float32 = (
                (bounded / bounded.sum(axis=2, keepdims=True) * values[each])
                .sum(axis=2)
                .astype(np.float32)
            )
            return mixed

        # Attributes of the corners.
        placed = coordinates.copy()
        # Across a seam an image goes on as before it.
        own = blended(self.coordinates, MOST_BEYOND)
        placed[outer] = np.where(
            np.isfinite(own).all(axis=(1, 2), keepdims=True), own, coordinates[outer]
        )
        colours = normals = None
        if self.has_colours:
            colours = np.ones((len(triangles), 3, 4), np.float32)
            colours[outer] = np.nan_to_num(blended(self.colours), nan=1.0)
        if self.has_normals:
            normals = np.zeros((len(triangles), 3, 3), np.float32)
            own = np.nan_to_num(blended(self.normals))
            # A triangle that was turned has its normals turned.
            flat = np.cross(
                self.corners[below, 1] - self.corners[below, 0],
                self.corners[below, 2] - self.corners[below, 0],
            )
            own = own * np.where(np.einsum("ij,ij->i", flat, faces) < 0.0, -1.0, 1.0)[:, None, None]
            lengths = np.linalg.norm(own, axis=2, keepdims=True)
            normals[outer] = np.where(
                lengths > 0.1, own / np.where(lengths > 0.1, lengths, 1.0), 0.0
            )

        material = np.full(len(triangles), NO_MATERIAL, np.int32)
        material[outer] = self.material[below]
        materials = self.materials
        if self.inside is not None:
            materials = (*materials, self.inside)
            material[inner] = len(self.materials)
        path = self._path(below, np.linalg.norm(faces, axis=1))
        return Skin(materials, material, colours, normals, path), placed

    def _without_surface(self) -> Skin:
        """Of a half-space: the one material that a patch of it is drawn with."""
        materials: tuple[Material, ...] = ()
        number = int(self.material[0]) if len(self.material) else NO_MATERIAL
        if number != NO_MATERIAL:
            one = self.materials[number]
            if one.corner_colours and np.isfinite(self.colours).any():
                corners = self.colours.reshape(-1, 4).astype(np.float64)
                red, green, blue, _ = np.nanmean(corners, axis=0).tolist()
                one = replace(one, colour=(red, green, blue), name="", corner_colours=False)
            materials = (one,)
        return Skin(materials, np.zeros(0, np.int32))

    def _path(self, below: Int64, areas: Float64) -> tuple[str, ...]:
        """The deepest node that most of a surface is of."""
        share: dict[tuple[str, ...], float] = {}
        for number in np.unique(self.object[below]).tolist():
            path = self.paths[number] if number >= 0 else ()
            area = float(areas[self.object[below] == number].sum())
            for depth in range(len(path) + 1):
                share[path[:depth]] = share.get(path[:depth], 0.0) + area
        least = OWNER * float(areas.sum())
        return max((path for path, area in share.items() if area >= least), key=len, default=())


def _weights(points: Float64, triangles: Float64) -> Float64:
    """(t, 3, 3) weights of the corners of triangles (t, 3, 3, 3) for points (t, 3, 3) in their
    planes."""
    a, b, c = np.moveaxis(triangles, 2, 0)
    ab, ac, ap = b - a, c - a, points - a
    d00, d01, d11 = (np.einsum("tkj,tkj->tk", x, y) for x, y in ((ab, ab), (ab, ac), (ac, ac)))
    d20, d21 = (np.einsum("tkj,tkj->tk", ap, x) for x in (ab, ac))
    determinant = d00 * d11 - d01 * d01
    safe = np.where(determinant > 0.0, determinant, 1.0)
    v = np.where(determinant > 0.0, (d11 * d20 - d01 * d21) / safe, 0.0)
    w = np.where(determinant > 0.0, (d00 * d21 - d01 * d20) / safe, 0.0)
    return np.stack([1.0 - v - w, v, w], axis=2)


def read_skin(
    path: str, plain: str, inside: str | None, known: Known | None = None
) -> MeshSkin | None:
    """Attributes of a file; ``plain`` is what `readable_mesh` made of it, ``known`` as in
    `read_materials`.

    ``inside`` names the material of what cracks lay bare: one of the file's, a look, or a new one.
    `None` if there is nothing.
    """
    said = mesh_attributes(plain)
    if said is None:
        return None if inside is None else _bare(_chosen(inside, ()))
    materials, transforms = read_materials(path, plain, said["materials"], known)
    material = said["material"]
    coordinates: Float32 = said["coordinates"]
    for number, transform in transforms.items():
        own = material == number
        down = np.stack(
            [
                coordinates[own, :, 0],
                1.0 - coordinates[own, :, 1],
                np.ones_like(coordinates[own, :, 0]),
            ],
            axis=-1,
        )
        moved = down @ transform.T
        coordinates[own] = np.stack([moved[..., 0], 1.0 - moved[..., 1]], axis=-1)

    # Colours show where nothing else has a colour.
    with_colours = np.isfinite(said["colours"]).all(axis=(1, 2))
    if with_colours.any():
        shown = np.unique(material[with_colours]).tolist()
        plain_white = {
            number
            for number in shown
            if number >= 0
            and materials[number].image is None
            and materials[number].colour == (1.0,) * 3
        }
        materials = [
            replace(one, corner_colours=True) if number in plain_white else one
            for number, one in enumerate(materials)
        ]
        material = np.where(
            with_colours & (material == NO_MATERIAL), len(materials), material
        ).astype(np.int32)
        materials = [*materials, CORNER_COLOURS]
    return MeshSkin(
        corners=said["corners"],
        materials=tuple(materials),
        material=material,
        paths=[_names(path) for path in said["objects"]],
        object=said["object"],
        coordinates=coordinates,
        normals=said["normals"],
        colours=said["colours"],
        inside=None if inside is None else _chosen(inside, materials),
    )


def _names(path: list[str]) -> tuple[str, ...]:
    """Names from the root on; of a prim they are all in one."""
    if len(path) == 1 and path[0].startswith("/"):
        return tuple(name for name in path[0].split("/") if name)
    return tuple(path)


def _chosen(name: str, materials: tuple[Material, ...] | list[Material]) -> Material:
    for material in materials:
        if material.name == name:
            return material
    if name in LOOKS:
        return replace(LOOKS[name].inside, name=name)
    return Material(INSIDE, INSIDE_ROUGHNESS, name=name)


def _bare(inside: Material) -> MeshSkin:
    """Of a file that says nothing: one triangle without anything stands for all."""
    nothing = np.full((1, 3, 4), np.nan, np.float32)
    return MeshSkin(
        corners=np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]),
        materials=(),
        material=np.array([NO_MATERIAL], np.int32),
        paths=[],
        object=np.array([-1], np.int32),
        coordinates=nothing[..., :2],
        normals=nothing[..., :3],
        colours=nothing,
        inside=inside,
    )
