"""glTF: a binary ``.glb`` with one animation.

A small writer of our own: the format is a JSON chunk and a binary chunk, and general libraries write one buffer view and
one time accessor per channel, which at thousands of pieces makes the JSON larger than the motion.
"""

from __future__ import annotations

import base64
import json
import struct
from typing import Any

import numpy as np
import numpy.typing as npt

from .ground import with_visible_ground
from .materials import OUTSIDE, Material, Palette, plain
from .normals import shaded_mesh, textured_corners
from .paths import by_source, unique_names
from .pieces import Pieces
from .recording import Body, Recording

Json = dict[str, Any]

#: What our files say of themselves.
GENERATOR = "Frangible"

_FLOAT, _UINT32 = 5126, 5125
_ARRAY_BUFFER, _ELEMENT_ARRAY_BUFFER = 34962, 34963
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
# The binary chunk holds one buffer view for each kind of data.
_POSITIONS, _NORMALS, _COORDINATES, _INDICES, _MOTION = range(5)


def write_glb(recording: Recording, path: str) -> None:
    """Write a recording; lengths are metres, times seconds, y is up."""
    gltf = _Gltf({"shot": recording.shot, "frames": recording.frames, "fps": recording.fps}, recording.fps)
    families = by_source(with_visible_ground(recording).bodies)
    palette = Palette(families, gltf.add_material)

    # One node for each source, with its pieces as children.
    roots = []
    for family, name in zip(
        families.values(), unique_names(family[0].name for family in families.values()), strict=True
    ):
        pieces = zip(family, unique_names(body.name for body in family), strict=True)
        children = [gltf.add_body(body, piece, *palette.sides(body)) for body, piece in pieces]
        roots.append(gltf.add("nodes", {"name": name, "children": children}))
    gltf.document["scenes"] = [{"name": recording.shot or "World", "nodes": roots}]
    with open(path, "wb") as file:
        file.write(gltf.to_bytes())


def write_pieces(pieces: Pieces, path: str) -> None:
    """Write a broken mesh, ``.glb`` or ``.gltf``: a node with the pieces as children, each with its origin at its centre of mass."""
    gltf = _Gltf({"mesh": pieces.name}, 1.0)
    look = plain(OUTSIDE[0])
    outer, inner = gltf.add_material("outer", look.outside), gltf.add_material("inner", look.inside)
    children = [gltf.add_body(piece.body(index), piece.name, outer, inner) for index, piece in enumerate(pieces.pieces)]
    (name,) = unique_names([pieces.name])
    gltf.document["scenes"] = [{"name": name, "nodes": [gltf.add("nodes", {"name": name, "children": children})]}]
    with open(path, "wb") as file:
        file.write(gltf.to_bytes() if path.endswith(".glb") else gltf.to_text())


class _Gltf:
    """The JSON document and the binary data, as they grow."""

    def __init__(self, extras: Json, fps: float) -> None:
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
            "accessors": [],
        }
        self.channels: list[Json] = []
        self.samplers: list[Json] = []
        self.parts: list[list[bytes]] = [[], [], [], [], []]
        self.sizes = [0, 0, 0, 0, 0]
        # Equal shapes share a mesh, and equal times an accessor.
        self.meshes: dict[bytes, int] = {}
        self.times: dict[bytes, int] = {}

    def add(self, kind: str, item: Json) -> int:
        self.document[kind].append(item)
        return len(self.document[kind]) - 1

    def add_accessor(self, view: int, array: npt.NDArray[Any], *, bounds: bool = False) -> int:
        data = array.astype(np.uint32 if view == _INDICES else np.float32)
        accessor: Json = {
            "bufferView": view,
            "byteOffset": self.sizes[view],
            "componentType": _UINT32 if view == _INDICES else _FLOAT,
            "count": len(data),
            "type": _TYPES[1 if data.ndim == 1 else data.shape[1]],
        }
        if bounds:
            accessor["min"] = np.atleast_1d(data.min(axis=0)).tolist()
            accessor["max"] = np.atleast_1d(data.max(axis=0)).tolist()
        self.parts[view].append(data.tobytes())
        self.sizes[view] += data.nbytes
        return self.add("accessors", accessor)

    def add_material(self, name: str, material: Material) -> int:
        surface = {
            "baseColorFactor": [*material.colour, 1.0 - material.clear],
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        }
        item: Json = {"name": name, "pbrMetallicRoughness": surface}
        if material.clear > 0.0:
            item["alphaMode"] = "BLEND"
        return self.add("materials", item)

    def add_body(self, body: Body, name: str, outside: int, inside: int) -> int:
        # The node rests in the state of frame 0, where what is not yet born has no size.
        node: Json = {
            "name": name,
            "translation": body.positions[0].astype(np.float32).tolist(),
            "rotation": body.orientations[0].astype(np.float32).tolist(),
        }
        if len(body.triangles):
            node["mesh"] = self.add_mesh(body, name, outside, inside)
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
            self.add_channel(index, "scale", np.array(frames_of_life), np.repeat(sizes, 3).reshape(-1, 3), "STEP")
        return index

    def add_mesh(self, body: Body, name: str, outside: int, inside: int) -> int:
        arrays = (body.vertices, body.triangles, body.interior, body.coordinates)
        key = b"".join([*(array.tobytes() for array in arrays), struct.pack("<I", outside)])
        if key in self.meshes:
            return self.meshes[key]

        # One primitive for the outside and one for what cracks laid bare.
        shaded = shaded_mesh(body.vertices, body.triangles, body.interior)
        primitives = []
        for material, faces in ((outside, ~body.interior), (inside, body.interior)):
            if not faces.any():
                continue
            # A vertex for each place in space and in the texture.
            used, coordinates, indices = textured_corners(shaded.triangles[faces], body.coordinates[faces])
            attributes = {
                "POSITION": self.add_accessor(_POSITIONS, body.vertices[shaded.vertex[used]], bounds=True),
                "NORMAL": self.add_accessor(_NORMALS, shaded.normals[used]),
                "TEXCOORD_0": self.add_accessor(_COORDINATES, coordinates),
            }
            primitives.append(
                {
                    "attributes": attributes,
                    "indices": self.add_accessor(_INDICES, indices.ravel()),
                    "material": material,
                }
            )
        self.meshes[key] = self.add("meshes", {"name": name, "primitives": primitives})
        return self.meshes[key]

    def add_channel(
        self, node: int, target: str, frames: npt.NDArray[Any], values: npt.NDArray[Any], interpolation: str
    ) -> None:
        times = (frames / self.fps).astype(np.float32)
        key = times.tobytes()
        if key not in self.times:
            self.times[key] = self.add_accessor(_MOTION, times, bounds=True)
        output = self.add_accessor(_MOTION, values)
        self.samplers.append({"input": self.times[key], "output": output, "interpolation": interpolation})
        self.channels.append({"sampler": len(self.samplers) - 1, "target": {"node": node, "path": target}})

    def to_bytes(self) -> bytes:
        """As a ``.glb``."""
        document, data = self._finished()
        # The header and the two chunks, each padded to four bytes; all data is made of four-byte words already.
        text = json.dumps(document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        if data:
            chunks += struct.pack("<I4s", len(data), b"BIN\0") + data
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def to_text(self) -> bytes:
        """As a ``.gltf`` that holds its data as well."""
        document, data = self._finished()
        for buffer in document.get("buffers", []):
            buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
        return json.dumps(document).encode()

    def _finished(self) -> tuple[Json, bytes]:
        """The document, and its data."""
        # Buffer views, without those that hold nothing.
        views: list[Json] = []
        renumbered: dict[int, int] = {}
        data = b""
        for view, parts in enumerate(self.parts):
            if not parts:
                continue
            renumbered[view] = len(views)
            item: Json = {"buffer": 0, "byteOffset": len(data), "byteLength": self.sizes[view]}
            if view in (_POSITIONS, _NORMALS):
                item |= {"byteStride": 12, "target": _ARRAY_BUFFER}
            if view == _COORDINATES:
                item |= {"byteStride": 8, "target": _ARRAY_BUFFER}
            if view == _INDICES:
                item["target"] = _ELEMENT_ARRAY_BUFFER
            views.append(item)
            data += b"".join(parts)
        for accessor in self.document["accessors"]:
            accessor["bufferView"] = renumbered[accessor["bufferView"]]

        # glTF forbids empty lists.
        document = {key: value for key, value in self.document.items() if value != []}
        if self.channels:
            document["animations"] = [
                {"name": "simulation", "channels": self.channels, "samplers": self.samplers}
            ]
        if data:
            document["buffers"] = [{"byteLength": len(data)}]
            document["bufferViews"] = views
        return document, data


def describe_glb(path: str) -> dict[str, object] | None:
    """Shot, frames, frame rate and bodies of a cache that `write_glb` wrote; `None` for any other file."""
    with open(path, "rb") as file:
        header = file.read(20)
        if len(header) < 20 or header[:4] != b"glTF":
            return None
        try:
            document = json.loads(file.read(struct.unpack("<I", header[12:16])[0]))
        except ValueError:
            return None
    if not isinstance(document, dict) or document.get("asset", {}).get("generator") != GENERATOR:
        return None
    bodies = sum(len(node.get("children", ())) for node in document["nodes"])
    return {**document["asset"]["extras"], "bodies": bodies}
