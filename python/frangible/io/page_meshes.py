"""The surfaces of a page, each distinct one once, and the materials on them."""

from __future__ import annotations

import base64
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..materials import LOOKS, Image, Material
from ..names import by_source
from ..recording import Body, Float64
from ..render.normals import corner_normals, shaded_mesh
from ..render.palette import Palette
from .page_streams import Blob, Ints, bits, rounded, stacked

#: Corners lie on a lattice of so many steps along the longest side of their mesh.
CORNER_STEPS = 2**16 - 1
#: Normals lie on a lattice of so many steps on each side of the octahedron's square.
NORMAL_STEPS = 2**10 - 1
#: Texture coordinates are multiples of one over this, colours of corners too.
COORDINATE_STEPS = 2**13
COLOUR_STEPS = 2**8 - 1
#: Grains that looks draw by position.
GRAINS = ("wood", "concrete")

Json = dict[str, Any]


class _Surface(NamedTuple):
    """A mesh whose vertices are split wherever something differs."""

    #: (s,) the corner of the body that each vertex lies at, and which of its materials it has.
    corner: Ints
    slot: Ints
    #: (s, 2), (s, 2) and (s, 4), on their lattices.
    normal: Ints
    place: Ints
    colour: Ints
    #: (t, 3) vertices.
    triangles: Ints


class Appearance:
    """Meshes, materials and images that bodies share: each is handed over once."""

    def __init__(self) -> None:
        self._table = _Materials()
        self._meshes: dict[bytes, int] = {}
        self._palettes: dict[int, Palette[int]] = {}

    def add(self, blob: Blob, bodies: list[Body]) -> Json:
        """The header's part on materials and images that are new with some bodies; their surfaces
        go into the streams."""
        materials, images = len(self._table.materials), len(self._table.images)
        self._table.note_files(bodies)
        self._choose_palettes(bodies)
        mesh_of_body, slots, surfaces, originals = [], [], [], []
        for body in bodies:
            groups = self._palettes[body.source].groups(body)
            slots.append([material for material, _, _ in groups])
            key = _key(body)
            if key not in self._meshes:
                self._meshes[key] = len(self._meshes)
                originals.append(body)
                surfaces.append(_surface(body, [faces for _, faces, _ in groups]))
            mesh_of_body.append(self._meshes[key])
        blob.add("mesh", np.array(mesh_of_body, np.int64))
        blob.add("slots", np.array([len(of_body) for of_body in slots], np.int64))
        blob.add(
            "materials", np.array([material for of_body in slots for material in of_body], np.int64)
        )
        _add_surfaces(blob, originals, surfaces)
        return {
            "materials": self._table.materials[materials:],
            "images": self._table.images[images:],
        }

    def _choose_palettes(self, bodies: list[Body]) -> None:
        """Sources that appear together share a palette, so that those without a look differ."""
        families = by_source(body for body in bodies if body.source not in self._palettes)
        palette = Palette(families, self._table.add)
        self._palettes |= dict.fromkeys(families, palette)


def _add_surfaces(blob: Blob, originals: list[Body], surfaces: list[_Surface]) -> None:
    boxes = [_box(body) for body in originals]
    corners = [
        rounded(body.vertices - low, max(size, 1e-30) / CORNER_STEPS)
        for body, (low, size) in zip(originals, boxes, strict=True)
    ]
    blob.add("mesh_low", bits(np.array([low for low, _ in boxes]).reshape(-1, 3)))
    blob.add("mesh_scale", bits(np.array([size / CORNER_STEPS for _, size in boxes])))
    blob.add("mesh_corners", np.array([len(body.vertices) for body in originals], np.int64))
    blob.add("mesh_vertices", np.array([len(surface.corner) for surface in surfaces], np.int64))
    blob.add("mesh_triangles", np.array([len(surface.triangles) for surface in surfaces], np.int64))
    blob.add("corners", stacked(list(corners), 3))
    blob.add("vertices", stacked([surface.corner for surface in surfaces], 1))
    blob.add("vertex_slots", stacked([surface.slot for surface in surfaces], 1))
    blob.add("normals", stacked([surface.normal for surface in surfaces], 2))
    blob.add("places", stacked([surface.place for surface in surfaces], 2))
    blob.add("colours", stacked([surface.colour for surface in surfaces], 4))
    blob.add("triangles", stacked([surface.triangles for surface in surfaces], 3).reshape(-1, 1))


class _Materials:
    """The header's materials, and the images that they show."""

    def __init__(self) -> None:
        self._of_files: set[Material] = set()
        self.materials: list[Json] = []
        self.images: list[Json] = []
        self._image_rows: dict[Image, int] = {}

    def note_files(self, bodies: list[Body]) -> None:
        """Materials of skins are those of files."""
        self._of_files |= {own for body in bodies if body.skin for own in body.skin.materials}

    def add(self, name: str, material: Material) -> int:
        look = name.rpartition("_")[0]
        drawn = look in GRAINS and material.image is None and look in LOOKS
        self.materials.append(
            {
                "name": name,
                "colour": list(material.colour),
                "metallic": material.metallic,
                "clear": material.clear,
                "emission": list(material.emission),
                # Only files say how smooth something is: looks all shine as pictures show them.
                "roughness": material.roughness if material in self._of_files else -1.0,
                "image": self._image(material.image),
                "surfaceImage": self._image(material.surface_image),
                "normalImage": self._image(material.normal_image),
                "emissionImage": self._image(material.emission_image),
                "cutoff": material.cutoff or 0.0,
                "blended": material.blended,
                "grain": look if drawn else "",
                "inside": name.endswith("_inside"),
            }
        )
        return len(self.materials) - 1

    def _image(self, image: Image | None) -> int:
        if image is None:
            return -1
        if image not in self._image_rows:
            self._image_rows[image] = len(self.images)
            data = base64.b64encode(image.data).decode("ascii")
            self.images.append({"mime": image.mime, "data": data})
        return self._image_rows[image]


def _key(body: Body) -> bytes:
    skin = body.skin
    arrays: list[npt.NDArray[Any]] = [body.vertices, body.triangles, body.interior]
    if skin is not None:
        own = (skin.material, skin.colours, skin.normals, body.coordinates)
        arrays += [array for array in own if array is not None]
    return b"".join(array.tobytes() for array in arrays)


def _surface(body: Body, groups: list[npt.NDArray[np.bool_]]) -> _Surface:
    shaded = shaded_mesh(body.vertices, body.triangles, body.interior)
    slot = np.zeros(len(body.triangles), np.int64)
    for index, faces in enumerate(groups):
        slot[faces] = index
    skin = body.skin
    if skin is None:
        # No vertex is on both sides, and each side has a material.
        split = np.zeros(len(shaded.vertex), np.int64)
        split[shaded.triangles] = slot[:, None]
        nothing = np.zeros((len(split), 2), np.int64)
        normal = _octahedral(shaded.normals)
        white = np.zeros((len(split), 4), np.int64)
        return _Surface(
            shaded.vertex.astype(np.int64),
            split,
            normal,
            nothing,
            white,
            shaded.triangles.astype(np.int64),
        )

    # Colours are stored as what is missing to white, so that none takes no room.
    count = 3 * len(body.triangles)
    colours = (
        np.zeros((count, 4))
        if skin.colours is None
        else 1.0 - np.clip(skin.colours.reshape(-1, 4), 0.0, 1.0)
    )
    # A place is drawn only where an image is; which one is the material's affair.
    has_image = np.array([bool(material.images()) for material in skin.materials] + [False])
    places = np.where(
        has_image[skin.material].repeat(3)[:, None], body.coordinates.reshape(-1, 2), 0.0
    )
    rows = np.column_stack(
        [
            body.triangles.ravel(),
            slot.repeat(3),
            _octahedral(corner_normals(body, shaded).reshape(-1, 3)),
            rounded(places, 1.0 / COORDINATE_STEPS),
            rounded(colours, 1.0 / COLOUR_STEPS),
        ]
    ).astype(np.int64)
    distinct, indices = np.unique(rows, axis=0, return_inverse=True)
    parts = distinct[:, 0], distinct[:, 1], distinct[:, 2:4], distinct[:, 4:6], distinct[:, 6:]
    return _Surface(*parts, indices.reshape(-1, 3))


def _box(body: Body) -> tuple[Float64, float]:
    """Lowest corner (3,) and longest side of a body's bounding box, body frame [m]."""
    if not len(body.vertices):
        return np.zeros(3), 0.0
    low = body.vertices.min(axis=0).astype(np.float64)
    return low, float(np.max(body.vertices.max(axis=0) - low))


def _octahedral(normals: npt.NDArray[Any]) -> Ints:
    """Unit normals (n, 3) as points (n, 2) of the unfolded octahedron (Cigolle et al. 2014)."""
    n = normals.astype(np.float64)
    n = n / np.maximum(np.abs(n).sum(axis=1, keepdims=True), 1e-30)
    folded = (1.0 - np.abs(n[:, 1::-1])) * np.where(n[:, :2] >= 0.0, 1.0, -1.0)
    return rounded(np.where(n[:, 2:] >= 0.0, n[:, :2], folded), 1.0 / NORMAL_STEPS)
