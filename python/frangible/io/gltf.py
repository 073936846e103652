"""glTF: a binary ``.glb`` with one animation.

A small writer of our own: the format is a JSON chunk and a binary chunk, and general libraries
write one buffer view and one time accessor per channel, which at thousands of pieces makes the JSON
larger than the motion.
"""

from __future__ import annotations

import base64
import hashlib
import json
import os
import struct
from collections.abc import Iterable, Iterator
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from ..materials import Image, Material, Sampler
from ..names import by_source, unique_names
from ..pieces import Pieces
from ..recording import Body, Bool, Float32, Recording, UInt32
from ..render.ground import with_visible_ground
from ..render.normals import corner_normals, shaded_mesh, textured_corners
from ..render.palette import Palette
from ..spool import Spool

Json = dict[str, Any]

#: The extension that holds light brighter than 1.
_EMISSION = "KHR_materials_emissive_strength"
#: Generator name in our files.
GENERATOR = "Frangible"

_FLOAT, _UINT32 = 5126, 5125
_ARRAY_BUFFER, _ELEMENT_ARRAY_BUFFER = 34962, 34963
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
# The binary chunk holds one buffer view for each kind of data.
_POSITIONS, _NORMALS, _COORDINATES, _INDICES, _MOTION, _COLOURS = range(6)
# Bytes from one item to the next, of what vertices have.
_STRIDES = {_POSITIONS: 12, _NORMALS: 12, _COORDINATES: 8, _COLOURS: 16}

# Of a body's triangles: the index of the material, and which of them have it.
Group = tuple[int, Bool]


def write_glb(recording: Recording, path: str) -> None:
    """Write a recording; lengths are metres, times seconds, y is up."""
    gltf = _Gltf(
        {"shot": recording.shot, "frames": recording.frames, "fps": recording.fps},
        recording.fps,
        os.path.dirname(os.path.abspath(path)),
    )
    families = by_source(with_visible_ground(recording).bodies)
    palette = Palette(families, gltf.add_material)

    # One node for each source, with its pieces as children.
    roots = []
    for family, name in zip(
        families.values(), unique_names(family[0].name for family in families.values()), strict=True
    ):
        roots.append(
            gltf.add_family(name, family, unique_names(body.name for body in family), palette)
        )
    gltf.document["scenes"] = [{"name": recording.shot or "World", "nodes": roots}]
    with open(path, "wb") as file:
        gltf.write(file)


def write_pieces(pieces: Pieces, path: str) -> None:
    """Write a broken mesh, ``.glb`` or ``.gltf``: a node with the pieces as children, each with its
    origin at its centre of mass."""
    gltf = _Gltf({"mesh": pieces.name}, 1.0)
    bodies = [piece.body(index) for index, piece in enumerate(pieces.pieces)]
    palette = Palette(by_source(bodies), gltf.add_material, ("outer", "inner"))
    (name,) = unique_names([pieces.name])
    root = gltf.add_family(name, bodies, (piece.name for piece in pieces.pieces), palette)
    gltf.document["scenes"] = [{"name": name, "nodes": [root]}]
    with open(path, "wb") as file:
        if path.endswith(".glb"):
            gltf.write(file)
        else:
            gltf.write_text(file)


def _sampler(sampler: Sampler) -> Json | None:
    """As glTF writes it; `None` for its defaults."""
    if sampler == Sampler():
        return None
    filters = {"magFilter": sampler.magnified, "minFilter": sampler.minified}
    given = {key: number for key, number in filters.items() if number is not None}
    return {"wrapS": sampler.wrap_s, "wrapT": sampler.wrap_t, **given}


class _Gltf:
    """The JSON document and the binary data, as they grow."""

    def __init__(self, extras: Json, fps: float, folder: str | None = None) -> None:
        """``folder`` has room for the data until the file is written."""
        self.fps = fps
        self.document: Json = {
            "asset": {
                "version": "2.0",
                "generator": GENERATOR,
                "extras": extras,
            },
            "scene": 0,
            "nodes": [],
            "meshes": [],
            "materials": [],
            "textures": [],
            "images": [],
            "accessors": [],
        }
        self.extensions: set[str] = set()
        self.channels: list[Json] = []
        self.samplers: list[Json] = []
        self.parts = [Spool(folder) for _ in range(6)]
        # Equal shapes share a mesh, equal times an accessor (both by digests), images a texture.
        self.meshes: dict[bytes, int] = {}
        self.times: dict[bytes, int] = {}
        self.textures: dict[Image, int] = {}

    def add(self, kind: str, item: Json) -> int:
        self.document[kind].append(item)
        return len(self.document[kind]) - 1

    def add_accessor(self, view: int, array: npt.NDArray[Any], *, bounds: bool = False) -> int:
        data = array.astype(np.uint32 if view == _INDICES else np.float32)
        accessor: Json = {
            "bufferView": view,
            "byteOffset": self.parts[view].size,
            "componentType": _UINT32 if view == _INDICES else _FLOAT,
            "count": len(data),
            "type": _TYPES[1 if data.ndim == 1 else data.shape[1]],
        }
        if bounds:
            accessor["min"] = np.atleast_1d(data.min(axis=0)).tolist()
            accessor["max"] = np.atleast_1d(data.max(axis=0)).tolist()
        self.parts[view].add(data.tobytes())
        return self.add("accessors", accessor)

    def add_material(self, name: str, material: Material) -> int:
        """A material keeps the name that it has in the mesh's file."""
        surface: Json = {
            "baseColorFactor": [*material.colour, 1.0 - material.clear],
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        }
        item: Json = {"name": material.name or name, "pbrMetallicRoughness": surface}
        for holder, key, image in (
            (surface, "baseColorTexture", material.image),
            (surface, "metallicRoughnessTexture", material.surface_image),
            (item, "normalTexture", material.normal_image),
            (item, "emissiveTexture", material.emission_image),
        ):
            if image is not None:
                holder[key] = {"index": self.add_texture(image)}
        if any(material.emission):
            # A factor is at most 1.
            strength = max(1.0, *material.emission)
            item["emissiveFactor"] = [channel / strength for channel in material.emission]
            if strength > 1.0:
                item["extensions"] = {_EMISSION: {"emissiveStrength": strength}}
                self.extensions.add(_EMISSION)
        if material.double_sided:
            item["doubleSided"] = True
        if material.cutoff is not None:
            item |= {"alphaMode": "MASK", "alphaCutoff": material.cutoff}
        elif material.clear > 0.0 or material.blended:
            item["alphaMode"] = "BLEND"
        return self.add("materials", item)

    def add_texture(self, image: Image) -> int:
        if image not in self.textures:
            # The number of the image stands for its buffer view until all others are known.
            source = self.add(
                "images",
                {"name": image.name, "mimeType": image.mime, "bufferView": len(self.textures)},
            )
            texture = {"source": source}
            if (sampler := _sampler(image.sampler)) is not None:
                held = self.document.setdefault("samplers", [])
                if sampler not in held:
                    held.append(sampler)
                texture["sampler"] = held.index(sampler)
            self.textures[image] = self.add("textures", texture)
        return self.textures[image]

    def add_family(
        self, name: str, bodies: list[Body], names: Iterable[str], palette: Palette[int]
    ) -> int:
        """A node with the bodies below it, each under the nodes that its mesh has in its file."""
        branches: dict[tuple[str, ...], Json] = {}

        def branch(path: tuple[str, ...]) -> Json:
            if path not in branches:
                branches[path] = node = {"name": path[-1] if path else name, "children": []}
                if path:
                    branch(path[:-1])["children"].append(self.add("nodes", node))
            return branches[path]

        branch(())
        for body, own in zip(bodies, names, strict=True):
            groups = [(material, faces) for material, faces, _ in palette.groups(body)]
            branch(() if body.skin is None else body.skin.path)["children"].append(
                self.add_body(body, own, groups)
            )
        return self.add("nodes", branches[()])

    def add_body(self, body: Body, name: str, groups: list[Group]) -> int:
        # The node rests in the state of frame 0, where what is not yet born has no size.
        node: Json = {
            "name": name,
            "translation": body.positions[0].astype(np.float32).tolist(),
            "rotation": body.orientations[0].astype(np.float32).tolist(),
        }
        if len(body.triangles):
            node["mesh"] = self.add_mesh(body, name, groups)
        if body.birth_frame > 0:
            node["scale"] = [0.0, 0.0, 0.0]
        index = self.add("nodes", node)

        # Motion while it lives, without constant channels.
        frames = body.birth_frame + np.arange(len(body.positions))
        for target, values in (("translation", body.positions), ("rotation", body.orientations)):
            values = values.astype(np.float32)
            if np.any(values != values[0]):
                self.add_channel(index, target, frames, values, "LINEAR")

        # Birth and death are steps of the scale.
        frames_of_life, sizes = [body.birth_frame], [1.0]
        if body.birth_frame > 0:
            frames_of_life, sizes = [0, *frames_of_life], [0.0, *sizes]
        if body.death_frame is not None:
            frames_of_life, sizes = [*frames_of_life, body.death_frame], [*sizes, 0.0]
        if len(sizes) > 1:
            self.add_channel(
                index, "scale", np.array(frames_of_life), np.repeat(sizes, 3).reshape(-1, 3), "STEP"
            )
        return index

    def add_mesh(self, body: Body, name: str, groups: list[Group]) -> int:
        skin = body.skin
        arrays = [body.vertices, body.triangles, body.interior, body.coordinates]
        arrays += (
            []
            if skin is None
            else [
                array for array in (skin.material, skin.colours, skin.normals) if array is not None
            ]
        )
        digest = hashlib.sha256(struct.pack("<I", groups[0][0]))
        for array in arrays:
            digest.update(struct.pack("<Q", array.nbytes))
            digest.update(array.tobytes())
        key = digest.digest()
        if key in self.meshes:
            return self.meshes[key]

        # One primitive for each material. glTF's texture coordinates have v down.
        shaded = shaded_mesh(body.vertices, body.triangles, body.interior)
        coordinates = np.stack([body.coordinates[..., 0], 1.0 - body.coordinates[..., 1]], axis=-1)
        primitives = []
        for material, faces in groups:
            if skin is not None and (skin.colours is not None or skin.normals is not None):
                attributes, indices = self.add_corners(
                    body, corner_normals(body, shaded)[faces], coordinates, faces
                )
            else:
                # A vertex for each place in space and in the texture.
                used, places, indices = textured_corners(
                    shaded.triangles[faces], coordinates[faces]
                )
                attributes = {
                    "POSITION": self.add_accessor(
                        _POSITIONS, body.vertices[shaded.vertex[used]], bounds=True
                    ),
                    "NORMAL": self.add_accessor(_NORMALS, shaded.normals[used]),
                    "TEXCOORD_0": self.add_accessor(_COORDINATES, places),
                }
            primitive = {
                "attributes": attributes,
                "indices": self.add_accessor(_INDICES, indices.ravel()),
                "material": material,
            }
            primitives.append(primitive)
        self.meshes[key] = self.add("meshes", {"name": name, "primitives": primitives})
        return self.meshes[key]

    def add_corners(
        self, body: Body, normals: Float32, coordinates: Float32, faces: Bool
    ) -> tuple[Json, UInt32]:
        """Attributes of the distinct corners of some triangles, and the three of each triangle."""
        columns = [normals.reshape(-1, 3), coordinates[faces].reshape(-1, 2)]
        if body.skin is not None and body.skin.colours is not None:
            columns.append(np.clip(body.skin.colours[faces].reshape(-1, 4), 0.0, 1.0))
        numbers = np.ascontiguousarray(np.concatenate(columns, axis=1), np.float32)
        rows = np.column_stack([body.triangles[faces].ravel(), numbers.view(np.uint32)])
        _, first, indices = np.unique(rows, axis=0, return_index=True, return_inverse=True)
        vertices = body.vertices[body.triangles[faces].ravel()[first]]
        attributes: Json = {"POSITION": self.add_accessor(_POSITIONS, vertices, bounds=True)}
        for view, name, columns_of in (
            (_NORMALS, "NORMAL", slice(0, 3)),
            (_COORDINATES, "TEXCOORD_0", slice(3, 5)),
            (_COLOURS, "COLOR_0", slice(5, 9)),
        ):
            if columns_of.start < numbers.shape[1]:
                attributes[name] = self.add_accessor(view, numbers[first, columns_of])
        return attributes, indices.ravel().astype(np.uint32)

    def add_channel(
        self,
        node: int,
        target: str,
        frames: npt.NDArray[Any],
        values: npt.NDArray[Any],
        interpolation: str,
    ) -> None:
        times = (frames / self.fps).astype(np.float32)
        key = hashlib.sha256(times.tobytes()).digest()
        if key not in self.times:
            self.times[key] = self.add_accessor(_MOTION, times, bounds=True)
        output = self.add_accessor(_MOTION, values)
        self.samplers.append(
            {"input": self.times[key], "output": output, "interpolation": interpolation}
        )
        self.channels.append(
            {"sampler": len(self.samplers) - 1, "target": {"node": node, "path": target}}
        )

    def write(self, file: IO[bytes]) -> None:
        """As a ``.glb``."""
        document, size = self._finished()
        # The header and the two chunks, each padded to four bytes; all data is made of four-byte
        # words already.
        text = json.dumps(document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        whole = 20 + len(text) + (8 + size if size else 0)
        file.write(struct.pack("<4sII", b"glTF", 2, whole))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        if size:
            file.write(struct.pack("<I4s", size, b"BIN\0"))
            file.writelines(self._data())

    def write_text(self, file: IO[bytes]) -> None:
        """As a ``.gltf`` that holds its data as well."""
        document, _ = self._finished()
        for buffer in document.get("buffers", []):
            data = base64.b64encode(b"".join(self._data())).decode()
            buffer["uri"] = f"data:application/octet-stream;base64,{data}"
        file.write(json.dumps(document).encode())

    def _data(self) -> Iterator[bytes]:
        """The views one behind the other, then the images, from multiples of four bytes on."""
        for part in self.parts:
            yield from part.chunks()
        for image in self.textures:
            yield image.data + b"\0" * (-len(image.data) % 4)

    def _finished(self) -> tuple[Json, int]:
        """The document, and the bytes of its data."""
        # Buffer views, without those that hold nothing.
        views: list[Json] = []
        renumbered: dict[int, int] = {}
        size = 0
        for view, part in enumerate(self.parts):
            if not part.size:
                continue
            renumbered[view] = len(views)
            item: Json = {"buffer": 0, "byteOffset": size, "byteLength": part.size}
            if view in _STRIDES:
                item |= {"byteStride": _STRIDES[view], "target": _ARRAY_BUFFER}
            if view == _INDICES:
                item["target"] = _ELEMENT_ARRAY_BUFFER
            views.append(item)
            size += part.size
        for accessor in self.document["accessors"]:
            accessor["bufferView"] = renumbered[accessor["bufferView"]]

        # A view for each image, from a multiple of four bytes on.
        for item, image in zip(self.document["images"], self.textures, strict=True):
            item["bufferView"] = len(views)
            views.append({"buffer": 0, "byteOffset": size, "byteLength": len(image.data)})
            size += len(image.data) + -len(image.data) % 4

        # glTF forbids empty lists.
        document = {key: value for key, value in self.document.items() if value != []}
        if self.channels:
            document["animations"] = [
                {"name": "simulation", "channels": self.channels, "samplers": self.samplers}
            ]
        if self.extensions:
            document["extensionsUsed"] = sorted(self.extensions)
        if size:
            document["buffers"] = [{"byteLength": size}]
            document["bufferViews"] = views
        return document, size
