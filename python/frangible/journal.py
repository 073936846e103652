"""A file that only grows, in records that each can be checked: its writer may have been killed in
the middle of one.

A record is a line of JSON of known length, arrays behind it, and a checksum of both:

========= ======= =====================================================================
bytes     type    meaning
========= ======= =====================================================================
4         text    ``FRG1``
8         uint64  bytes of the JSON (little-endian, as all)
8         uint64  bytes of the arrays
4         uint32  CRC-32 of the JSON and the arrays
...       text    JSON: the fields, among them ``kind``, and as ``arrays`` a list of name,
                  `numpy.dtype.str` and shape
...               the arrays in C order, each filled up with zeros to 8 bytes; so is the JSON
========= ======= =====================================================================
"""

from __future__ import annotations

import json
import math
import os
import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

_MARK = b"FRG1"
_HEAD = struct.Struct("<4sQQI")
#: Arrays begin at multiples of so many bytes, so that they can be used where they lie. The head has
#: 24 bytes.
_ALIGNED = 8


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """A record that was read."""

    kind: str
    fields: dict[str, Any]
    #: Views of the bytes that were read.
    arrays: dict[str, Array]
    #: Where it ends in its file.
    end: int


def record_bytes(kind: str, fields: Mapping[str, Any], arrays: Mapping[str, Array]) -> bytes:
    """A record as it stands in a file."""
    solid = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    described = [[name, array.dtype.str, array.shape] for name, array in solid.items()]
    text = json.dumps({**fields, "kind": kind, "arrays": described}).encode()
    head = text + b" " * (-len(text) % _ALIGNED)
    body = b"".join(
        part for array in solid.values() for part in (array.tobytes(), bytes(_gap(array.nbytes)))
    )
    checksum = zlib.crc32(body, zlib.crc32(head))
    return _HEAD.pack(_MARK, len(head), len(body), checksum) + head + body


def _gap(length: int) -> int:
    return -length % _ALIGNED


class Journal:
    """A journal that is being written. Each record is with the system when `append` returns: what
    kills the process does not lose it."""

    def __init__(self, path: str, length: int = 0) -> None:
        """Goes on behind the first ``length`` bytes of a file; what is behind them is cut off."""
        self.path = path
        self.length = length
        self._file: BinaryIO = open(path, "r+b" if length else "wb", buffering=0)  # noqa: SIM115
        self._file.truncate(length)
        self._file.seek(length)

    def append(self, kind: str, fields: Mapping[str, Any], arrays: Mapping[str, Array]) -> None:
        """Write a record, or after an `OSError` nothing of it."""
        data = memoryview(record_bytes(kind, fields, arrays))
        try:
            while data:
                data = data[self._file.write(data) :]
        except OSError:
            self._file.truncate(self.length)
            self._file.seek(self.length)
            raise
        self.length = self._file.tell()

    def sync(self) -> None:
        """Have all of it on the disk."""
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """No more records."""
        self._file.close()


def read_journal(path: str, end: int | None = None) -> Iterator[Record]:
    """All whole records of a file, up to ``end``; the first that is cut off or damaged ends it.

    One record is in memory at a time.
    """
    with open(path, "rb", buffering=0) as file:
        size = os.fstat(file.fileno()).st_size
        place, end = 0, size if end is None else min(end, size)
        while (record := _record(file.fileno(), place, end)) is not None:
            yield record
            place = record.end


def begins_journal(path: str) -> bool:
    """True if a file is empty, or begins as a journal does."""
    with open(path, "rb") as file:
        mark = file.read(len(_MARK))
    return _MARK.startswith(mark)


def record_at(path: str, place: int) -> Record:
    """The record that begins there; `ValueError` if none does."""
    with open(path, "rb", buffering=0) as file:
        record = _record(file.fileno(), place, os.fstat(file.fileno()).st_size)
    if record is None:
        raise ValueError(f"{path}: has no record at {place}")
    return record


def _record(file: int, place: int, end: int) -> Record | None:
    if end - place < _HEAD.size:
        return None
    mark, head, body, checksum = _HEAD.unpack(os.pread(file, _HEAD.size, place))
    first = place + _HEAD.size
    past = first + head + body
    if mark != _MARK or past > end:
        return None
    data = os.pread(file, head + body, first)
    if len(data) != head + body or zlib.crc32(data) != checksum:
        return None
    fields = json.loads(data[:head])
    arrays, place = {}, head
    for name, dtype, shape in fields.pop("arrays"):
        kind = np.dtype(dtype)
        arrays[name] = np.frombuffer(data, kind, math.prod(shape), place).reshape(shape)
        length = math.prod(shape) * kind.itemsize
        place += length + _gap(length)
    return Record(fields.pop("kind"), fields, arrays, past)
