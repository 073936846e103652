"""Pieces as OBJ: an object for each, materials and images beside."""

from __future__ import annotations

import os

import numpy as np

from ..materials import Material
from ..names import by_source
from ..pieces import Piece, Pieces
from ..recording import Float32, Float64, Int64
from ..render.normals import corner_normals, shaded_mesh
from ..render.palette import Palette
from .image_folder import ImageFolder


class ObjWriter:
    """The materials of some pieces, and their objects."""

    def __init__(self, pieces: Pieces, images: ImageFolder) -> None:
        self._images = images
        self._lines: list[str] = []
        self._taken: set[str] = set()
        self._bodies = [piece.body(index) for index, piece in enumerate(pieces.pieces)]
        self._palette = Palette(by_source(self._bodies), self._material, ("outer", "inner"))
        self._groups = [self._palette.groups(body) for body in self._bodies]

    def write_materials(self, path: str) -> None:
        """The .mtl file."""
        with open(path, "w", encoding="utf-8") as file:
            file.write("\n".join(self._lines) + "\n")

    def write(self, pieces: list[tuple[int, Piece]], path: str, materials: str) -> None:
        """The .obj file of some pieces, with their numbers among all."""
        lines = [f"mtllib {materials}"]
        vertex, place, normal = 1, 1, 1
        for number, piece in pieces:
            body = self._bodies[number]
            lines.append(f"o {piece.name}")
            if piece.skin is not None and piece.skin.path:
                lines.append(f"g {'/'.join(piece.skin.path)}")
            lines += _vertices(piece)
            places, place_of = _distinct(piece.coordinates)
            lines += [f"vt {u:.7g} {v:.7g}" for u, v in places.tolist()]
            corners = [(piece.triangles + vertex).tolist(), (place_of + place).tolist()]
            normals = np.zeros((0, 3))
            if piece.skin is not None and piece.skin.normals is not None:
                normals, normal_of = _distinct(
                    corner_normals(body, shaded_mesh(body.vertices, body.triangles, body.interior))
                )
                lines += [f"vn {x:.7g} {y:.7g} {z:.7g}" for x, y, z in normals.tolist()]
                corners.append((normal_of + normal).tolist())
            faces = [
                "f " + " ".join("/".join(map(str, one)) for one in zip(*each, strict=True))
                for each in zip(*corners, strict=True)
            ]
            for name, group, _ in self._groups[number]:
                lines.append(f"usemtl {name}")
                lines += [faces[face] for face in np.flatnonzero(group).tolist()]
            vertex, place, normal = (
                vertex + len(piece.vertices),
                place + len(places),
                normal + len(normals),
            )
        with open(path, "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")

    def _material(self, name: str, material: Material) -> str:
        own = material.name if material.name and material.name not in self._taken else name
        self._taken.add(own)
        numbers: dict[str, tuple[float, ...]] = {
            "Kd": material.colour,
            "Pr": (material.roughness,),
            "Pm": (material.metallic,),
            "d": (1.0 - material.clear,),
        }
        if any(material.emission):
            numbers["Ke"] = material.emission
        self._lines.append(f"newmtl {own}")
        self._lines += [
            f"{key} {' '.join(f'{number:g}' for number in values)}"
            for key, values in numbers.items()
        ]
        for key, image in (
            ("map_Kd", material.image),
            ("map_Ke", material.emission_image),
            ("norm", material.normal_image),
        ):
            if image is not None:
                self._lines.append(f"{key} {self._images.path(image)}")
        return own


def _vertices(piece: Piece) -> list[str]:
    """Places, and colours where there are some: the mean of the corners', as sRGB. Python's
    shortest digits read back to the same numbers."""
    rows = piece.vertices.tolist()
    if piece.skin is None or piece.skin.colours is None:
        return [f"v {x!r} {y!r} {z!r}" for x, y, z in rows]
    outer = ~piece.inner
    index = piece.triangles[outer].ravel()
    count = np.bincount(index, minlength=len(rows))
    sums = [
        np.bincount(index, piece.skin.colours[outer][..., axis].ravel(), len(rows))
        for axis in range(3)
    ]
    linear = np.where(
        count[:, None] > 0, np.stack(sums, axis=1) / np.maximum(count, 1)[:, None], 1.0
    )
    colours = np.where(
        linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0.0) ** (1.0 / 2.4) - 0.055
    ).tolist()
    return [
        f"v {x!r} {y!r} {z!r} {r:.6g} {g:.6g} {b:.6g}"
        for (x, y, z), (r, g, b) in zip(rows, colours, strict=True)
    ]


def _distinct(values: Float32) -> tuple[Float64, Int64]:
    """The distinct rows of corners (t, 3, n), and the number of each (t, 3)."""
    rows, index = np.unique(values.reshape(-1, values.shape[2]), axis=0, return_inverse=True)
    return rows.astype(np.float64), index.reshape(-1, 3)


def write_obj(pieces: Pieces, path: str, materials: str, materials_name: str) -> None:
    """All pieces in one file, with the materials in another that it knows by a name; images go into
    a folder beside."""
    stem = os.path.splitext(os.path.join(os.path.dirname(path), materials_name))[0]
    writer = ObjWriter(pieces, ImageFolder(f"{stem}_textures"))
    writer.write_materials(materials)
    writer.write(list(enumerate(pieces.pieces)), path, materials_name)


def write_folder(pieces: Pieces, folder: str) -> None:
    """A file for each piece, the materials, and the images in a folder below."""
    writer = ObjWriter(pieces, ImageFolder(os.path.join(folder, "textures")))
    writer.write_materials(os.path.join(folder, "materials.mtl"))
    for number, piece in enumerate(pieces.pieces):
        writer.write([(number, piece)], os.path.join(folder, f"{piece.name}.obj"), "materials.mtl")
