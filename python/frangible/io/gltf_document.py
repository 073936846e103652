"""A glTF file as it is shipped: its document, and the numbers that its accessors stand for.

Sparse accessors, integers, and views that are compressed are read; bytes come from the file itself
or from regular files in its own folder.
"""

from __future__ import annotations

import base64
import json
import os
import struct
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import unquote, urlsplit

import numpy as np
import numpy.typing as npt

from .._frangible import BuildError, decode_meshopt
from .reading import file_fault

Json = dict[str, Any]
Array = npt.NDArray[Any]

#: The most bytes that compressed or missing views may stand for.
MOST_DECODED = 2**30
#: Extensions that compress views.
MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")

_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


@dataclass(slots=True)
class Document:
    """The JSON of a file, and what it refers to."""

    path: str
    json: Json
    #: The binary chunk of a GLB file.
    chunk: bytes | None
    buffers: dict[int, bytes] = field(default_factory=dict)
    views: dict[int, bytes] = field(default_factory=dict)
    #: Bytes that were made of less so far.
    decoded: int = 0

    def fail(self, reason: str) -> BuildError:
        """The sentence about what is wrong with the file."""
        return BuildError(f"{self.path}: is not a valid glTF file: {reason}")

    def items(self, key: str) -> list[Json]:
        """A list of the document, such as its nodes; empty if there is none."""
        found = self.json.get(key, [])
        if not isinstance(found, list) or not all(isinstance(item, dict) for item in found):
            asset = self.json.get("asset")
            version = asset.get("version") if isinstance(asset, dict) else None
            if str(version).startswith("1."):
                raise BuildError(f"{self.path}: is glTF of version {version}, must be of version 2")
            raise self.fail(f"its {key} are no list of objects")
        return found

    def item(self, key: str, index: Any) -> Json:
        """One of a list."""
        found = self.items(key)
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < len(found):
            raise self.fail(f"it refers to {key} {index}, and has {len(found)}")
        return found[index]

    def accessor(self, index: Any) -> Array:
        """The rows of an accessor (n, columns); integers that are fractions as those, all others as
        they are."""
        accessor = self.item("accessors", index)
        count, columns = _natural(accessor["count"]), _COLUMNS[accessor["type"]]
        dtype = np.dtype(_TYPES[accessor["componentType"]])
        if "bufferView" in accessor:
            data, stride = self.view(accessor["bufferView"])
            rows = self._rows(
                index, data, _natural(accessor.get("byteOffset", 0)), count, columns, dtype, stride
            )
        else:
            self._budget(count * columns * dtype.itemsize)
            rows = np.zeros((count, columns), dtype)
        if sparse := accessor.get("sparse"):
            # Some rows are others.
            changed = _natural(sparse["count"])
            places, values = sparse["indices"], sparse["values"]
            kind = np.dtype(_TYPES[places["componentType"]])
            data, _ = self.view(places["bufferView"])
            at = self._rows(
                index, data, _natural(places.get("byteOffset", 0)), changed, 1, kind, None
            ).ravel()
            if np.any(at >= count):
                raise self.fail(
                    f"accessor {index} has a sparse index {at.max()}, must be below {count}"
                )
            data, _ = self.view(values["bufferView"])
            rows = rows.copy()
            rows[at] = self._rows(
                index, data, _natural(values.get("byteOffset", 0)), changed, columns, dtype, None
            )
        if accessor.get("normalized") and dtype.kind in "iu":
            rows = np.maximum(rows.astype(np.float64) / np.iinfo(dtype).max, -1.0)
        return rows

    def _rows(
        self,
        index: Any,
        data: bytes,
        offset: int,
        count: int,
        columns: int,
        dtype: np.dtype[Any],
        stride: int | None,
    ) -> Array:
        size = columns * dtype.itemsize
        stride = max(stride or size, size)
        if count and offset + stride * (count - 1) + size > len(data):
            raise self.fail(f"accessor {index} reaches beyond its buffer")
        if count == 0:
            return np.zeros((0, columns), dtype)
        return np.ndarray((count, columns), dtype, data, offset, (stride, dtype.itemsize))

    def view(self, index: Any) -> tuple[bytes, int | None]:
        """The bytes of a view, and how far its rows are apart if it says so."""
        view = self.item("bufferViews", index)
        stride = _natural(view["byteStride"]) if "byteStride" in view else None
        if index not in self.views:
            extensions = view.get("extensions", {})
            packed = next((extensions[name] for name in MESHOPT if name in extensions), None)
            self.views[index] = (
                self._slice(index, view) if packed is None else self._unpacked(index, packed)
            )
        return self.views[index], stride

    def _slice(self, index: Any, view: Json) -> bytes:
        data = self.buffer(view["buffer"])
        begin = _natural(view.get("byteOffset", 0))
        end = begin + _natural(view["byteLength"])
        if end > len(data):
            raise self.fail(f"view {index} reaches beyond its buffer")
        return data[begin:end]

    def _unpacked(self, index: Any, packed: Json) -> bytes:
        count, stride = _natural(packed["count"]), _natural(packed["byteStride"])
        self._budget(count * stride)
        data = self._slice(index, packed)
        try:
            return decode_meshopt(
                data, count, stride, str(packed["mode"]), str(packed.get("filter", "NONE"))
            )
        except BuildError as error:
            raise self.fail(f"view {index} {error}") from None

    def _budget(self, size: int) -> None:
        self.decoded += size
        if self.decoded > MOST_DECODED:
            raise BuildError(
                f"{self.path}: unpacks to more than {MOST_DECODED} bytes, must be at most so many"
            )

    def buffer(self, index: Any) -> bytes:
        """The bytes of a buffer."""
        buffer = self.item("buffers", index)
        if index not in self.buffers:
            if "uri" in buffer:
                self.buffers[index] = self.read_uri(buffer["uri"], f"buffer {index}")
            elif index == 0 and self.chunk is not None:
                self.buffers[index] = self.chunk
            else:
                raise self.fail(f"buffer {index} is missing")
        return self.buffers[index]

    def read_uri(self, uri: Any, what: str) -> bytes:
        """The bytes that a URI names: its own in base64, or those of a file in the document's own
        folder."""
        if not isinstance(uri, str):
            raise self.fail(f"{what} has a URI that is no text")
        if uri.startswith("data:"):
            head, comma, data = uri.partition(",")
            if not comma or not head.endswith(";base64"):
                raise self.fail(f"{what} is embedded, but not as base64")
            return base64.b64decode(data, validate=True)
        name = own_file(self.path, uri)
        if name is None:
            raise self.fail(f"{what} is in {uri!r}, must be a file in the document's own folder")
        if fault := file_fault(name):
            raise self.fail(f"{what} in {uri!r} {fault}")
        with open(name, "rb") as file:
            return file.read()


def own_file(path: str, uri: str) -> str | None:
    """The file that a relative URI names beside a document or below; `None` for whatever leads out
    of its folder."""
    name = unquote(uri)
    if (
        urlsplit(uri).scheme
        or "\0" in name
        or "\\" in name
        or os.path.isabs(name)
        or ".." in name.split("/")
    ):
        return None
    # Links lead out, too.
    folder = os.path.realpath(os.path.dirname(path) or ".")
    found = os.path.realpath(os.path.join(folder, name))
    return found if os.path.commonpath([folder, found]) == folder else None


def _natural(value: Any) -> int:
    if isinstance(value, bool) or value != int(value) or value < 0:
        raise ValueError(f"{value!r}, must be a whole number >= 0")
    return int(value)


def open_document(path: str) -> Document | None:
    """A document with its JSON read; `None` if that fails, as the core's reader says why."""
    with open(path, "rb") as file:
        content = file.read()
    chunk = None
    try:
        if content[:4] == b"glTF":
            text, chunk = _chunks(content)
        else:
            text = content
        document = json.loads(text)
    except (ValueError, RecursionError, struct.error):
        return None
    if not isinstance(document, dict):
        return None
    return Document(path, document, chunk)


def _chunks(content: bytes) -> tuple[bytes, bytes | None]:
    """The JSON of a GLB file, and its binary chunk."""
    length, kind = struct.unpack_from("<I4s", content, 12)
    if kind != b"JSON" or 20 + length > len(content):
        raise ValueError("no chunk of JSON")
    begin = 20 + length
    if begin + 8 > len(content):
        return content[20:begin], None
    size, kind = struct.unpack_from("<I4s", content, begin)
    chunk = content[begin + 8 : begin + 8 + size] if kind == b"BIN\0" else None
    return content[20:begin], chunk
