"""Skins of bodies as plain arrays, and back: a part of the table in `cache`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
import numpy.typing as npt

from .materials import Image, Material
from .recording import Body
from .skin import NO_MATERIAL, Skin

Arrays = dict[str, npt.NDArray[Any]]

#: Fields of a material that hold an image, if any.
_IMAGES = ("image", "surface_image", "normal_image", "emission_image")


def rows(parts: Sequence[npt.NDArray[Any]], empty: tuple[int, ...], dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    """The parts one after the other."""
    return np.concatenate(parts).astype(dtype) if parts else np.zeros(empty, dtype)


def offsets(parts: Sequence[npt.NDArray[Any] | bytes]) -> npt.NDArray[np.int64]:
    """The first row of each part, then the number of rows."""
    return np.cumsum([0, *(len(part) for part in parts)], dtype=np.int64)


def skin_arrays(bodies: list[Body]) -> Arrays:
    """Keys from ``paths`` on."""
    # Each material and each image once.
    materials: dict[Material, int] = {}
    images: dict[Image, int] = {}
    numbers, colours, normals = [], [], []
    for body in bodies:
        skin = body.skin or Skin((), np.full(len(body.triangles), NO_MATERIAL, np.int32))
        # The last entry is what -1 finds.
        index = [materials.setdefault(material, len(materials)) for material in skin.materials]
        numbers.append(np.array([*index, NO_MATERIAL], np.int32)[skin.material])
        colours.append(np.zeros((0, 3, 4), np.float32) if skin.colours is None else skin.colours)
        normals.append(np.zeros((0, 3, 3), np.float32) if skin.normals is None else skin.normals)

    def fields(material: Material) -> dict[str, Any]:
        values = asdict(material)
        for name in _IMAGES:
            image = getattr(material, name)
            values[name] = None if image is None else images.setdefault(image, len(images))
        return values

    described = [fields(material) for material in materials]
    files = [{"name": image.name, "mime": image.mime} for image in images]
    data = [image.data for image in images]
    return {
        "paths": np.array(["" if body.skin is None else json.dumps(body.skin.path) for body in bodies], np.str_),
        "materials": np.array(json.dumps({"materials": described, "images": files})),
        "image_data": np.frombuffer(b"".join(data), np.uint8),
        "image_offsets": offsets(data),
        "material": rows(numbers, (0,), np.int32),
        "colours": rows(colours, (0, 3, 4), np.float32),
        "colour_offsets": offsets(colours),
        "normals": rows(normals, (0, 3, 3), np.float32),
        "normal_offsets": offsets(normals),
    }


def read_skins(arrays: Arrays) -> list[Skin | None]:
    """The skin of each body; none in caches of format 3."""
    count = len(arrays["ids"])
    if "paths" not in arrays:
        return [None] * count

    # The materials, with their images.
    listed = json.loads(str(arrays["materials"]))
    firsts = arrays["image_offsets"].tolist()
    images = [
        Image(file["name"], file["mime"], arrays["image_data"][slice(*firsts[i : i + 2])].tobytes())
        for i, file in enumerate(listed["images"])
    ]

    def material(values: dict[str, Any]) -> Material:
        own: dict[str, Any] = {key: tuple(value) if isinstance(value, list) else value for key, value in values.items()}
        own |= {name: None if values[name] is None else images[values[name]] for name in _IMAGES}
        return Material(**own)

    materials = tuple(material(values) for values in listed["materials"])
    keys = ("triangle_offsets", "colour_offsets", "normal_offsets")
    triangles, colours, normals = (arrays[key].tolist() for key in keys)
    skins: list[Skin | None] = []
    for i, path in enumerate(arrays["paths"].tolist()):
        if not path:
            skins.append(None)
            continue
        own_colours = arrays["colours"][slice(*colours[i : i + 2])]
        own_normals = arrays["normals"][slice(*normals[i : i + 2])]
        skins.append(
            Skin(
                materials=materials,
                material=arrays["material"][slice(*triangles[i : i + 2])],
                colours=own_colours if len(own_colours) else None,
                normals=own_normals if len(own_normals) else None,
                path=tuple(json.loads(path)),
            )
        )
    return skins
