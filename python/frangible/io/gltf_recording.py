"""glTF files whose meshes move, as recordings for the player."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from ..errors import CacheError, one_sentence
from ..recording import Float64, Recording
from ..skin import NO_MATERIAL, Skin
from .gltf_document import Document, Json, open_document
from .gltf_pose import matrix
from .material_files import read_materials
from .reading import file_fault
from .rotations import matrices_of
from .shown_meshes import ShownMesh, recording_of

#: Words in the names of materials that cracks laid bare.
_INSIDE = ("inside", "inner", "interior")
#: Frames per second where the file does not say.
_RATE = 30.0
#: The most frames times nodes: some seconds.
_MOST = 20_000_000
_SIZES = {"translation": 3, "rotation": 4, "scale": 3}
_TRIANGLES = 4


def read_gltf_recording(path: str) -> Recording | None:
    """The motion of a file's meshes, by its first animation; `None` if it has none."""
    if fault := file_fault(path):
        raise CacheError(f"{path}: {fault}")
    document = open_document(path)
    if document is None or not document.items("animations"):
        return None
    with one_sentence(path, "glTF file", CacheError):
        return _Reader(path, document).recording()


class _Reader:
    def __init__(self, path: str, document: Document) -> None:
        self._path, self._document = path, document
        extras = document.json.get("asset", {}).get("extras", {})
        extras = extras if isinstance(extras, dict) else {}
        self._shot = str(extras.get("shot", os.path.splitext(os.path.basename(path))[0]))
        self._fps = float(extras.get("fps", _RATE))
        self._channels = self._read_channels()
        ends = [
            times[-1] for channels in self._channels.values() for times, _, _ in channels.values()
        ]
        frames = round(max(ends, default=0.0) * self._fps)
        self._frames = max(frames, int(extras.get("frames", 0)))
        if self._frames * len(document.items("nodes")) > _MOST:
            raise ValueError(f"{self._frames} frames of that many nodes are too many")
        self._materials = tuple(read_materials(path, path, [])[0])

    def recording(self) -> Recording:
        nodes = self._document.items("nodes")
        parents = {child: n for n, node in enumerate(nodes) for child in node.get("children", [])}
        worlds: dict[int, Float64] = {}

        def world(number: int, depth: int = 0) -> Float64:
            if depth > len(nodes):
                raise self._document.fail(f"node {number} is below itself")
            if number not in worlds:
                own = self._local(number, nodes[number])
                above = parents.get(number)
                worlds[number] = own if above is None else world(above, depth + 1) @ own
            return worlds[number]

        meshes = [
            found
            for number, node in enumerate(nodes)
            if "mesh" in node
            for found in [self._mesh(number, node, world(number), parents.get(number))]
            if found is not None
        ]
        return recording_of(self._shot, self._fps, self._frames, meshes)

    def _read_channels(self) -> dict[int, dict[str, tuple[Float64, Float64, str]]]:
        """Times, values and interpolation by node and path."""
        animation = self._document.items("animations")[0]
        found: dict[int, dict[str, tuple[Float64, Float64, str]]] = {}
        for channel in animation.get("channels", []):
            target = channel["target"]
            name = target.get("path")
            if "node" not in target or name not in _SIZES:
                continue
            sampler = animation["samplers"][channel["sampler"]]
            times = self._document.accessor(sampler["input"]).astype(np.float64).ravel()
            rows = self._document.accessor(sampler["output"]).astype(np.float64)
            kind = str(sampler.get("interpolation", "LINEAR"))
            if kind == "CUBICSPLINE":
                # The values between the tangents; frames are about as dense as keys.
                rows = rows.reshape(len(times), 3, -1)[:, 1]
            if len(times) == 0 or rows.shape != (len(times), _SIZES[name]):
                raise self._document.fail("an animation has not as many values as times")
            found.setdefault(int(target["node"]), {})[name] = (times, rows, kind)
        return found

    def _local(self, number: int, node: Json) -> Float64:
        """``parent_from_node`` at each frame, or once."""
        channels = self._channels.get(number)
        if not channels:
            return matrix(node)[None]
        parts = {
            name: self._sampled(channels[name])
            if name in channels
            else np.array([node.get(name, otherwise)], np.float64)
            for name, otherwise in (
                ("translation", (0, 0, 0)), ("rotation", (0, 0, 0, 1)), ("scale", (1, 1, 1)),
            )
        }  # fmt: skip
        made = np.tile(np.eye(4), (self._frames + 1, 1, 1))
        made[:, :3, :3] = matrices_of(parts["rotation"]) * parts["scale"][:, None, :]
        made[:, :3, 3] = parts["translation"]
        return made

    def _sampled(self, channel: tuple[Float64, Float64, str]) -> Float64:
        times, rows, kind = channel
        # Times are rounded to single precision: a key of a frame is there in it.
        at = np.arange(self._frames + 1) / self._fps + 1e-4 / self._fps
        if kind == "STEP":
            return rows[np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 1)]
        if rows.shape[1] == 4:
            flips = np.where(np.einsum("ij,ij->i", rows[1:], rows[:-1]) < 0.0, -1.0, 1.0)
            rows = rows * np.cumprod(np.concatenate([[1.0], flips]))[:, None]
        at = np.arange(self._frames + 1) / self._fps
        return np.stack([np.interp(at, times, column) for column in rows.T], axis=1)

    def _mesh(
        self, number: int, node: Json, matrices: Float64, above: int | None
    ) -> ShownMesh | None:
        """A node's triangles, of all its primitives."""
        document = self._document
        parts: list[tuple[Any, ...]] = []
        first = 0
        for primitive in document.item("meshes", node["mesh"]).get("primitives", []):
            attributes = primitive.get("attributes", {})
            if primitive.get("mode", _TRIANGLES) != _TRIANGLES or "POSITION" not in attributes:
                continue
            points = document.accessor(attributes["POSITION"]).astype(np.float64)
            indices = (
                document.accessor(primitive["indices"]).ravel().astype(np.int64)
                if "indices" in primitive
                else np.arange(len(points))
            )
            triangles = indices[: len(indices) // 3 * 3].reshape(-1, 3)
            if triangles.max(initial=-1) >= len(points):
                raise document.fail("an index is beyond its vertices")
            own = int(primitive.get("material", NO_MATERIAL))
            name = document.item("materials", own).get("name", "") if own >= 0 else ""
            inside = any(word in str(name).lower() for word in _INSIDE)
            parts.append(
                (
                    points,
                    triangles + first,
                    np.full(len(triangles), inside),
                    self._corners(attributes, "TEXCOORD_0", triangles, 2) * [1, -1] + [0, 1],
                    self._corners(attributes, "NORMAL", triangles, 3),
                    np.full(len(triangles), own, np.int32),
                )
            )
            first += len(points)
        if not parts:
            return None
        vertices, faces, interior, places, normals, material = (
            np.concatenate(part) for part in zip(*parts, strict=True)
        )
        skin = Skin(self._materials, material, normals=normals.astype(np.float32))
        return ShownMesh(
            str(node.get("name", f"node {number}")),
            str(above),
            vertices,
            faces.astype(np.uint32),
            interior,
            places.astype(np.float32),
            skin if self._materials else None,
            matrices,
            np.ones(1, np.bool_),
        )

    def _corners(self, attributes: Json, name: str, triangles: Any, columns: int) -> Float64:
        """An attribute at the corners of triangles; zeros where there is none."""
        if name not in attributes:
            return np.zeros((len(triangles), 3, columns))
        rows = self._document.accessor(attributes[name]).astype(np.float64)
        return np.asarray(rows[triangles][..., :columns], np.float64)
