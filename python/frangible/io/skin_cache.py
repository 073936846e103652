"""Skins of bodies as plain arrays, and back: a part of the table in `cache`."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
import numpy.typing as npt

from ..materials import MAGNIFIED, MINIFIED, USD_WRAPS, Image, Material, Sampler
from ..recording import Body
from ..skin import NO_MATERIAL, Skin

Arrays = dict[str, npt.NDArray[Any]]

#: Fields of a material that hold an image, if any.
_IMAGES = ("image", "surface_image", "normal_image", "emission_image")


def _shares(count: int, most: float = 1.0) -> Callable[[Any], bool]:
    """True if a value is so many numbers from 0 to the most."""
    is_share = _number(0.0, most)

    def holds(value: Any) -> bool:
        return isinstance(value, list) and len(value) == count and all(map(is_share, value))

    return holds


def _number(least: float, most: float) -> Callable[[Any], bool]:
    return lambda value: type(value) in (int, float) and least <= value <= most


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and not any(
        sign == "\0" or "\ud800" <= sign <= "\udfff" for sign in value
    )


def _is_truth(value: Any) -> bool:
    return isinstance(value, bool)


#: Valid fields of a material, but for its images.
_FIELDS: dict[str, tuple[Callable[[Any], bool], str]] = {
    "colour": (_shares(3), "three numbers from 0 to 1"),
    "roughness": (_number(0.0, 1.0), "from 0 to 1"),
    "metallic": (_number(0.0, 1.0), "from 0 to 1"),
    "clear": (_number(0.0, 1.0), "from 0 to 1"),
    "name": (_is_text, "text"),
    "emission": (_shares(3, 1e6), "three numbers from 0 to 1e6"),
    "cutoff": (lambda value: value is None or _number(0.0, 1.0)(value), "from 0 to 1, or null"),
    "blended": (_is_truth, "true or false"),
    "corner_colours": (_is_truth, "true or false"),
    "double_sided": (_is_truth, "true or false"),
}


def _sampler(values: dict[str, Any]) -> Sampler:
    sampler = Sampler(**values)
    wraps = sampler.wrap_s in USD_WRAPS and sampler.wrap_t in USD_WRAPS
    filters = sampler.magnified in (None, *MAGNIFIED) and sampler.minified in (None, *MINIFIED)
    if not wraps or not filters:
        raise ValueError(f"materials: the sampler {str(values)[:40]}, must have glTF's numbers")
    return sampler


def no_constant(text: str) -> None:
    """`ValueError`: JSON has no such number."""
    raise ValueError(f"JSON holds {text}")


def rows(
    parts: Sequence[npt.NDArray[Any]], empty: tuple[int, ...], dtype: npt.DTypeLike
) -> npt.NDArray[Any]:
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
    files = [
        {"name": image.name, "mime": image.mime, "sampler": asdict(image.sampler)}
        for image in images
    ]
    data = [image.data for image in images]
    return {
        "paths": np.array(
            ["" if body.skin is None else json.dumps(body.skin.path) for body in bodies], np.str_
        ),
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
    listed = json.loads(str(arrays["materials"]), parse_constant=no_constant)
    firsts = arrays["image_offsets"].tolist()
    if len(listed["images"]) != len(firsts) - 1:
        raise ValueError(f"image_offsets: {len(firsts)}, must be one more than images")
    numbers = arrays["material"]
    if np.any(bad := numbers >= len(listed["materials"])):
        raise ValueError(f"material: {numbers[bad][0]}, must be below {len(listed['materials'])}")
    images = [
        Image(
            file["name"],
            file["mime"],
            arrays["image_data"][slice(*firsts[i : i + 2])].tobytes(),
            _sampler(file.get("sampler", {})),
        )
        for i, file in enumerate(listed["images"])
    ]

    def material(values: dict[str, Any]) -> Material:
        for key, (holds, rule) in _FIELDS.items():
            if key in values and not holds(values[key]):
                raise ValueError(f"materials: {key} is {str(values[key])[:40]}, must be {rule}")
        for key in _IMAGES:
            if values[key] is not None and not 0 <= values[key] < len(images):
                raise ValueError(f"materials: {key} is {values[key]}, must be below {len(images)}")
        own: dict[str, Any] = {
            key: tuple(value) if isinstance(value, list) else value for key, value in values.items()
        }
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
