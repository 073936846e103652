"""Materials of mesh files: MTL beside OBJ, glTF's own, and images that PLY names."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Container, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import one_sentence
from ..materials import MAGNIFIED, MINIFIED, REPEAT, USD_WRAPS, Colour, Image, Material, Sampler
from .gltf_document import Document, open_document, own_file
from .image_files import image_file, known_image
from .mesh_files import USD_ENDINGS, mesh_ending, stage_and_prim
from .reading import FileNote, file_fault

#: Of materials, by their numbers: what moves texture coordinates with v down (3, 3).
Transforms = dict[int, npt.NDArray[np.float64]]

#: Defaults of an OBJ file's material: glTF's, without the gloss.
ROUGHNESS = 0.7


#: Materials of stages that were read already, by file and path.
Known = dict[tuple[str, str], Material]


def read_materials(
    path: str, plain: str, names: list[str], known: Known | None = None
) -> tuple[list[Material], Transforms]:
    """The materials of those names: in OBJ and USD names or paths, in PLY images, in glTF numbers.

    One that is not found has a name only. Those of stages are looked up among the known ones first,
    and added to them.
    """
    if mesh_ending(path) in USD_ENDINGS:
        file, _ = stage_and_prim(path)
        found = {} if known is None else known
        missing = [name for name in names if (file, name) not in found]
        if missing:
            from .usd_looks import read_usd_materials

            for name, material in zip(missing, read_usd_materials(file, missing), strict=True):
                found[file, name] = material
        return [found[file, name] for name in names], {}
    if os.path.splitext(plain)[1].lower() == ".ply":
        return [_of_image(path, name) for name in names], {}
    if os.path.splitext(plain)[1].lower() == ".obj":
        named = _of_obj(path)
        return [
            named.get(name, Material((0.8, 0.8, 0.8), ROUGHNESS, name=name)) for name in names
        ], {}
    with one_sentence(path, "glTF file"):
        document = open_document(plain)
        return ([], {}) if document is None else _of_gltf(path, document)


def _of_image(path: str, name: str) -> Material:
    stem = os.path.splitext(os.path.basename(name.replace("\\", "/")))[0]
    return Material((1.0, 1.0, 1.0), ROUGHNESS, name=stem, image=image_file(path, name))


def _of_obj(path: str) -> dict[str, Material]:
    materials: dict[str, Material] = {}
    with open(path, encoding="utf-8", errors="replace") as file:
        libraries = [
            line.split(None, 1)[1].strip()
            for line in file
            if line.startswith("mtllib") and len(line.split()) > 1
        ]
    for library in dict.fromkeys(libraries):
        # A line may name several files, and a file may have blanks in its name.
        found = own_file(path, library)
        names = [library] if found is not None and os.path.isfile(found) else library.split()
        for name in names:
            file_name = own_file(path, name)
            if file_name is None or file_fault(file_name):
                warnings.warn(
                    f"{path}: has no materials {name!r} in its own folder", FileNote, stacklevel=2
                )
                continue
            with open(file_name, encoding="utf-8", errors="replace") as file:
                for own, statements in _statements(file):
                    materials.setdefault(own, _of_mtl(file_name, own, statements))
    return materials


def _statements(lines: Any) -> Iterator[tuple[str, dict[str, str]]]:
    """Name and statements of each material."""
    name: str | None = None
    statements: dict[str, str] = {}
    for line in lines:
        word, _, rest = line.strip().partition(" ")
        if word == "newmtl":
            if name is not None:
                yield name, statements
            name, statements = rest.strip(), {}
        elif word and not word.startswith("#"):
            statements[word.lower()] = rest.strip()
    if name is not None:
        yield name, statements


def _of_mtl(path: str, name: str, statements: dict[str, str]) -> Material:
    def numbers(key: str, otherwise: list[float]) -> list[float]:
        try:
            found = [float(word) for word in statements[key].split()][: len(otherwise)]
        except (KeyError, ValueError):
            return otherwise
        good = len(found) == len(otherwise) and bool(np.all(np.isfinite(found)))
        return found if good else otherwise

    def image(*keys: str) -> Image | None:
        for key in keys:
            if words := statements.get(key):
                # Options come first; the name may have blanks without them.
                return image_file(path, words.split()[-1] if words.startswith("-") else words)
        return None

    def share(value: float) -> float:
        return min(max(value, 0.0), 1.0)

    shine = numbers("ns", [-1.0])[0]
    roughness = ROUGHNESS if shine < 0.0 else 1.0 - min(shine / 1000.0, 1.0) ** 0.5
    picture = image("map_kd")
    # An image stands for the colour if that is black, as exporters write it.
    red, green, blue = map(share, numbers("kd", [0.8, 0.8, 0.8]))
    if picture is not None and not red + green + blue:
        red = green = blue = 1.0
    opacity = numbers("d", [1.0 - numbers("tr", [0.0])[0]])[0]
    glow: Colour = (
        share(numbers("ke", [0.0] * 3)[0]),
        share(numbers("ke", [0.0] * 3)[1]),
        share(numbers("ke", [0.0] * 3)[2]),
    )
    return Material(
        (red, green, blue),
        share(numbers("pr", [roughness])[0]),
        share(numbers("pm", [0.0])[0]),
        clear=1.0 - share(opacity),
        name=name,
        emission=glow,
        image=picture,
        normal_image=image("norm"),
        emission_image=image("map_ke"),
        blended="map_d" in statements,
    )


def _of_gltf(path: str, document: Document) -> tuple[list[Material], Transforms]:
    images: dict[int, Image | None] = {}

    def image(info: Any) -> Image | None:
        if not isinstance(info, dict):
            return None
        texture = document.item("textures", info["index"])
        source = texture.get("source")
        if source is None:
            return None
        if source not in images:
            images[source] = _gltf_image(path, document, source)
        found = images[source]
        if found is None or "sampler" not in texture:
            return found
        return replace(found, sampler=_sampler(document.item("samplers", texture["sampler"])))

    materials, transforms = [], {}
    for number, item in enumerate(document.items("materials")):
        materials.append(_gltf_material(number, item, image))
        base = item.get("pbrMetallicRoughness", {}).get("baseColorTexture", {})
        if (moved := base.get("extensions", {}).get("KHR_texture_transform")) is not None:
            transforms[number] = _transform(moved)
    return materials, transforms


def _gltf_image(path: str, document: Document, number: int) -> Image | None:
    item = document.item("images", number)
    uri = item.get("uri")
    name = str(
        item.get("name")
        or (
            os.path.basename(uri)
            if isinstance(uri, str) and not uri.startswith("data:")
            else f"image_{number}"
        )
    )
    if "bufferView" in item:
        data, _ = document.view(item["bufferView"])
    elif isinstance(uri, str) and uri.startswith("data:"):
        data = document.read_uri(uri, f"image {number}")
    else:
        return image_file(path, str(uri))
    found = known_image(path, name, data) if data else None
    if found is None:
        return None
    ending = "." + found.mime.rpartition("/")[2]
    stem, own = os.path.splitext(name)
    return Image(
        name if own.lower() in (".png", ".jpg", ".jpeg") else stem + ending, found.mime, found.data
    )


def _sampler(item: dict[str, Any]) -> Sampler:
    """Numbers that glTF does not have are left to the program that draws."""

    def number(key: str, known: Container[Any], otherwise: Any) -> Any:
        return item[key] if item.get(key) in known else otherwise

    return Sampler(
        number("wrapS", USD_WRAPS, REPEAT),
        number("wrapT", USD_WRAPS, REPEAT),
        number("magFilter", MAGNIFIED, None),
        number("minFilter", MINIFIED, None),
    )


def _gltf_material(
    number: int, item: dict[str, Any], image: Callable[[Any], Image | None]
) -> Material:
    surface = item.get("pbrMetallicRoughness", {})
    red, green, blue, opacity = (
        float(channel) for channel in surface.get("baseColorFactor", [1.0] * 4)
    )
    glow = [float(channel) for channel in item.get("emissiveFactor", [0.0] * 3)]
    extensions = item.get("extensions", {})
    strength = extensions.get("KHR_materials_emissive_strength", {})
    brighter = float(strength.get("emissiveStrength", 1.0))
    if np.isfinite(brighter) and 0.0 <= brighter <= 1e6:
        glow = [brighter * channel for channel in glow]
    mode = item.get("alphaMode", "OPAQUE")
    return Material(
        (red, green, blue),
        float(surface.get("roughnessFactor", 1.0)),
        float(surface.get("metallicFactor", 1.0)),
        clear=1.0 - opacity if mode == "BLEND" else 0.0,
        name=str(item.get("name") or f"material_{number}"),
        emission=(glow[0], glow[1], glow[2]),
        image=image(surface.get("baseColorTexture")),
        surface_image=image(surface.get("metallicRoughnessTexture")),
        normal_image=image(item.get("normalTexture")),
        emission_image=image(item.get("emissiveTexture")),
        cutoff=float(item.get("alphaCutoff", 0.5)) if mode == "MASK" else None,
        blended=mode == "BLEND",
        double_sided=item.get("doubleSided") is True,
    )


def _transform(moved: dict[str, Any]) -> npt.NDArray[np.float64]:
    """Of `KHR_texture_transform`."""
    (x, y), (across, down) = moved.get("offset", [0.0, 0.0]), moved.get("scale", [1.0, 1.0])
    cosine, sine = np.cos(moved.get("rotation", 0.0)), np.sin(moved.get("rotation", 0.0))
    return np.array(
        [[cosine * across, sine * down, x], [-sine * across, cosine * down, y], [0.0, 0.0, 1.0]]
    )
