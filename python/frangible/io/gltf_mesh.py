"""glTF files as they are shipped, made plain: the core reads single-precision vertices and lists of
triangles.

Compressed, quantised and sparse data is unpacked, skins and morph targets are posed, and instances
become nodes. Materials, textures and names go on as they are.
"""

from __future__ import annotations

import json
import struct
import warnings
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from .._frangible import BuildError
from ..errors import one_sentence
from ..extras import missing_packages
from .gltf_document import MESHOPT, Array, Document, Json, open_document, own_file
from .gltf_pose import joint_matrices, matrix, morphed, placed, pose, skinning, world_matrices
from .reading import FileNote, file_fault

#: Endings of glTF files.
ENDINGS = (".gltf", ".glb")

DRACO = "KHR_draco_mesh_compression"
INSTANCES = "EXT_mesh_gpu_instancing"
VISIBILITY = "KHR_node_visibility"
#: Extensions that change the shape, and that are read here.
_READ = {DRACO, INSTANCES, VISIBILITY, "KHR_mesh_quantization", *MESHOPT}
#: Beginnings and names of those that a shape does not need.
_LOOKS = (
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "EXT_texture_",
    "EXT_lights_",
    "MSFT_texture_",
    "ADOBE_materials_",
)
_OTHERS = {
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "KHR_animation_pointer",
    "MSFT_lod",
    "VRM",
    "VRMC_materials_mtoon",
}

#: The most instances of nodes: some seconds.
MOST_INSTANCES = 200_000
#: Where an instance is that says nothing.
_AT_REST = {"TRANSLATION": (0.0, 0.0, 0.0), "ROTATION": (0.0, 0.0, 0.0, 1.0), "SCALE": (1.0,) * 3}
_POSITION, _INDEX = "POSITION", "SCALAR"


def make_plain(path: str, glb: str, pose_time: float | None) -> bool:
    """Write a file as a plain GLB; nothing and false if it is plain already, or so damaged that the
    core says how.

    Without a pose time [s] nodes, joints and morph targets are as the file has them at rest.
    """
    with one_sentence(path, "glTF file"):
        document = open_document(path)
        if document is None:
            return False
        _check_extensions(document)
        if pose_time is None and not _needs_more(document):
            return False
        if pose_time is not None:
            pose(document, pose_time)
            if len(document.items("animations")) != 1:
                warnings.warn(f"{path}: {_posed_by(document)}", FileNote, stacklevel=2)
        content = _Plain(document).content()
    with open(glb, "wb") as file:
        file.write(content)
    return True


def _posed_by(document: Document) -> str:
    """The sentence about the animation that a pose is of, and about those that are left out."""
    animations = document.items("animations")
    if not animations:
        return "has 0 animations, posed by the rest pose"
    first, *others = (str(one.get("name", number))[:40] for number, one in enumerate(animations))
    named = ", ".join(map(repr, others[:5])) + (" and others" if len(others) > 5 else "")
    said = f"has {len(animations)} animations, posed by the first of them, {first!r}"
    return f"{said}; left out: {named}"


def _check_extensions(document: Document) -> None:
    for name in document.json.get("extensionsRequired", []):
        if name not in _READ and name not in _OTHERS and not str(name).startswith(_LOOKS):
            raise BuildError(f"{document.path}: requires the extension {name}, which is not read")
    used = document.json.get("extensionsUsed", [])
    if DRACO in used and (hint := missing_packages("gltf")):
        raise BuildError(f"{document.path}: is compressed with Draco: {hint}")


def _needs_more(document: Document) -> bool:
    """True if there is something that the core does not read by itself."""
    used = set(document.json.get("extensionsUsed", [])) | set(
        document.json.get("extensionsRequired", [])
    )
    if (
        used & _READ
        or document.items("skins")
        or any("source" not in texture for texture in document.items("textures"))
    ):
        return True
    if any(
        "sparse" in accessor or "bufferView" not in accessor
        for accessor in document.items("accessors")
    ):
        return True
    primitives = [
        primitive for mesh in document.items("meshes") for primitive in mesh.get("primitives", [])
    ]
    accessors = document.items("accessors")
    for primitive in primitives:
        place = primitive.get("attributes", {}).get(_POSITION)
        if "targets" in primitive:
            return True
        if (
            isinstance(place, int)
            and 0 <= place < len(accessors)
            and accessors[place].get("componentType") != 5126
        ):
            return True
    return False


@dataclass(slots=True)
class _Plain:
    """The plain document, as it grows."""

    old: Document
    new: Json = field(default_factory=dict)
    data: bytearray = field(default_factory=bytearray)
    #: Numbers of new meshes, by what they were made of.
    meshes: dict[str, int] = field(default_factory=dict)

    def content(self) -> bytes:
        """The bytes of the file."""
        document = self.old
        self.new = {
            key: document.json[key]
            for key in ("scene", "scenes", "materials", "samplers")
            if key in document.json
        }
        self.new |= {
            "asset": {"version": "2.0"},
            "nodes": [],
            "meshes": [],
            "accessors": [],
            "bufferViews": [],
        }
        worlds = world_matrices(document)
        extra: list[Json] = []
        nodes = document.items("nodes")
        for number, node in enumerate(nodes):
            self.new["nodes"].append(self._node(node, worlds[number], worlds, len(nodes), extra))
        self.new["nodes"] += extra
        self._textures()

        # glTF has no empty lists.
        document_json = {key: value for key, value in self.new.items() if value != []}
        if self.data:
            document_json["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(document_json, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        if self.data:
            chunks += struct.pack("<I4s", len(self.data), b"BIN\0") + bytes(self.data)
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def _node(
        self, node: Json, world: Any, worlds: list[Any], count: int, extra: list[Json]
    ) -> Json:
        """A node with its mesh made plain; its instances go to ``extra``, whose first has the
        number ``count``."""
        made: Json = {key: node[key] for key in ("name", "children") if key in node}
        made["matrix"] = matrix(node).T.ravel().tolist()
        extensions = node.get("extensions", {})
        if extensions.get(VISIBILITY, {}).get("visible", True) is False:
            made.pop("children", None)
            return made
        if "mesh" not in node:
            return made
        mesh = self._mesh(node, world, worlds)
        if INSTANCES not in extensions:
            return made | {"mesh": mesh}

        # A node for each instance.
        columns = {
            name: self.old.accessor(index)
            for name, index in extensions[INSTANCES]["attributes"].items()
        }
        length = min(len(rows) for rows in columns.values())
        if len(extra) + length > MOST_INSTANCES:
            raise BuildError(
                f"{self.old.path}: has more than {MOST_INSTANCES} instances, must have at most so "
                "many"
            )
        first = count + len(extra)
        where = placed(
            *(
                columns[name][:length] if name in columns else np.tile(otherwise, (length, 1))
                for name, otherwise in _AT_REST.items()
            )
        )
        matrices = where.transpose(0, 2, 1).reshape(length, 16).tolist()
        name = node.get("name", "instance")
        extra += [
            {"name": f"{name}_{row}", "mesh": mesh, "matrix": own}
            for row, own in enumerate(matrices)
        ]
        return made | {"children": [*made.get("children", []), *range(first, first + length)]}

    def _mesh(self, node: Json, world: Any, worlds: list[Any]) -> int:
        """The number of a node's mesh, which it may share with others."""
        mesh = self.old.item("meshes", node["mesh"])
        weights = [float(weight) for weight in node.get("weights") or mesh.get("weights") or []]
        joints: npt.NDArray[np.float64] | None = None
        if "skin" in node:
            joints = np.linalg.inv(world) @ joint_matrices(
                self.old, self.old.item("skins", node["skin"]), worlds
            )
        key = json.dumps([node["mesh"], weights, None if joints is None else joints.tolist()])
        if key not in self.meshes:
            self.meshes[key] = len(self.new["meshes"])
            placed_ones = (one for one in mesh["primitives"] if _POSITION in one["attributes"])
            primitives = [self._primitive(primitive, weights, joints) for primitive in placed_ones]
            self.new["meshes"].append({"name": mesh.get("name", ""), "primitives": primitives})
        return self.meshes[key]

    def _primitive(self, primitive: Json, weights: list[float], joints: Any) -> Json:
        # The parts as they are shipped.
        attributes = primitive["attributes"]
        draco = primitive.get("extensions", {}).get(DRACO)
        packed = {} if draco is None else self._draco(draco)
        rows = {
            name: packed[name] if name in packed else self.old.accessor(index)
            for name, index in attributes.items()
            if name in (_POSITION, "NORMAL") or name.startswith(("TEXCOORD_", "COLOR_"))
        }
        vertices = len(rows[_POSITION])

        # Its pose.
        for name in (_POSITION, "NORMAL"):
            if name in rows:
                rows[name] = morphed(
                    self.old, primitive, name, rows[name].astype(np.float64), weights
                )
        if joints is not None and len(joints):
            joined = {
                name: index
                for name, index in attributes.items()
                if name.startswith(("JOINTS_", "WEIGHTS_"))
            }
            blend = skinning(self.old, joined, joints, vertices, packed)
            rows[_POSITION] = (
                np.einsum("vij,vj->vi", blend[:, :3, :3], rows[_POSITION]) + blend[:, :3, 3]
            )
            if "NORMAL" in rows:
                rows["NORMAL"] = np.einsum("vij,vj->vi", blend[:, :3, :3], rows["NORMAL"])

        # The plain form.
        made: Json = {
            "attributes": {name: self._add(name, values) for name, values in rows.items()}
        }
        made |= {key: primitive[key] for key in ("material", "mode") if key in primitive}
        if draco is not None:
            made |= {"indices": self._add(_INDEX, packed[_INDEX]), "mode": 4}
        elif "indices" in primitive:
            made["indices"] = self._add(_INDEX, self.old.accessor(primitive["indices"]))
        return made

    def _draco(self, draco: Json) -> dict[str, Array]:
        """Attributes and corners of a compressed primitive."""
        import DracoPy

        data, _ = self.old.view(draco["bufferView"])
        mesh = DracoPy.decode(data)
        unpacked: dict[str, Array] = {_INDEX: np.asarray(mesh.faces, np.uint32).reshape(-1, 1)}
        for name, number in draco["attributes"].items():
            values = np.asarray(mesh.get_attribute_by_unique_id(number)["data"])
            unpacked[name] = values.reshape(len(values), -1)
        return unpacked

    def _add(self, name: str, values: Array) -> int:
        """The number of a new accessor."""
        if name == _INDEX:
            if values.dtype.kind not in "iu":
                raise self.old.fail("indices that are not unsigned integers")
            kind, columns = 5125, 1
            rows: npt.NDArray[Any] = values.astype("<u4").reshape(-1, 1)
        else:
            kind, columns = 5126, values.shape[1]
            with np.errstate(over="ignore"):
                rows = values.astype("<f4")
        if name in (_POSITION, "NORMAL") and columns != 3:
            raise self.old.fail(f"{name} has {columns} numbers a vertex, must have 3")
        accessor: Json = {
            "bufferView": len(self.new["bufferViews"]),
            "componentType": kind,
            "count": len(rows),
            "type": {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[columns],
        }
        if name == _POSITION:
            low, high = (
                (rows.min(axis=0), rows.max(axis=0)) if len(rows) else (np.zeros(3), np.zeros(3))
            )
            # JSON has no other numbers than finite ones; the core judges the vertices themselves.
            accessor |= {"min": np.nan_to_num(low).tolist(), "max": np.nan_to_num(high).tolist()}
        self._add_view(rows.tobytes())
        self.new["accessors"].append(accessor)
        return len(self.new["accessors"]) - 1

    def _add_view(self, content: bytes) -> int:
        self.new["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(content)}
        )
        self.data += content + b"\0" * (-len(content) % 4)
        return len(self.new["bufferViews"]) - 1

    def _textures(self) -> None:
        """Textures and the images themselves: the plain file lies in another folder."""
        self.new["images"] = [self._image(image) for image in self.old.items("images")]
        self.new["textures"] = []
        for texture in self.old.items("textures"):
            others = (
                extension.get("source") for extension in texture.get("extensions", {}).values()
            )
            source = texture.get(
                "source", next((other for other in others if other is not None), None)
            )
            made = {key: texture[key] for key in ("name", "sampler") if key in texture}
            # One without an image must have one all the same.
            self.new["textures"].append(
                made | {"source": self._no_image() if source is None else source}
            )

    def _image(self, image: Json) -> Json:
        made = {key: image[key] for key in ("name", "mimeType") if key in image}
        uri = image.get("uri")
        if "bufferView" in image:
            content, _ = self.old.view(image["bufferView"])
        elif isinstance(uri, str) and not uri.startswith("data:"):
            file = own_file(self.old.path, uri)
            if file is None or file_fault(file):
                warnings.warn(
                    f"{self.old.path}: has no image {uri!r} in its own folder",
                    FileNote,
                    stacklevel=2,
                )
                return made | {"uri": "data:image/png;base64,"}
            content = self.old.read_uri(uri, "image")
            made.setdefault("mimeType", "image/jpeg" if content[:2] == b"\xff\xd8" else "image/png")
        else:
            return image
        return made | {
            "bufferView": self._add_view(content),
            "mimeType": made.get("mimeType", "image/png"),
        }

    def _no_image(self) -> int:
        self.new["images"].append({"uri": "data:image/png;base64,"})
        return len(self.new["images"]) - 1
