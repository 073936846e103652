"""Streams of small whole numbers, as the player reads them (`web/src/streams.ts`).

A blob is a header (its length as little-endian uint32, then UTF-8 JSON), then the streams, zlib
around all. A stream holds whole numbers (rows, columns), column after column: differences of
neighbours, taken ``order`` times, folded to unsigned (0, -1, 1, -2, ...), the lowest byte of all
rows first, then the next.
"""

from __future__ import annotations

import json
import zlib
from typing import Any

import numpy as np
import numpy.typing as npt

Ints = npt.NDArray[np.int64]

#: The best level is a hundredth smaller and takes four to six times as long (five shots).
_LEVEL = 6


class Blob:
    """The streams, as they grow."""

    def __init__(self) -> None:
        self.streams: dict[str, dict[str, int]] = {}
        self.parts: list[bytes] = []
        self.size = 0

    def add(self, name: str, values: npt.NDArray[Any], order: int = 1) -> None:
        """Whole numbers (rows,) or (rows, columns) that int32 holds."""
        columns = (values if values.ndim > 1 else values[:, None]).T.astype(np.int64)
        # Differences may need a bit more than the numbers; they wrap around, and so do sums.
        for _ in range(order):
            columns = np.diff(columns, prepend=0, axis=1)
        wrapped = columns.astype(np.uint32).view(np.int32)
        folded = ((wrapped << 1) ^ (wrapped >> 31)).view(np.uint32).ravel()
        width = (int(folded.max(initial=0)).bit_length() + 7) // 8
        planes = np.ascontiguousarray(folded.astype("<u4").view(np.uint8).reshape(-1, 4).T[:width])
        self.streams[name] = {
            "offset": self.size,
            "rows": columns.shape[1],
            "columns": columns.shape[0],
            "bytes": width,
            "order": order,
        }
        self.parts.append(planes.tobytes())
        self.size += planes.size

    def to_bytes(self, header: dict[str, Any]) -> bytes:
        """Everything, compressed."""
        text = json.dumps({**header, "streams": self.streams}, separators=(",", ":")).encode()
        return zlib.compress(b"".join([len(text).to_bytes(4, "little"), text, *self.parts]), _LEVEL)


def rounded(values: npt.NDArray[Any], step: float) -> Ints:
    """The nearest multiples of a step, as far as int32 goes."""
    limit = 2**31 - 1
    multiples: Ints = np.clip(np.rint(values / step), -limit, limit).astype(np.int64)
    return multiples


def stacked(parts: list[npt.NDArray[Any]], columns: int) -> Ints:
    """Rows of all parts, one below the other."""
    empty = np.zeros((0, columns), np.int64)
    return np.concatenate([empty, *(part.reshape(-1, columns) for part in parts)]).astype(np.int64)


def bits(values: npt.NDArray[Any]) -> Ints:
    """Single-precision numbers as the whole numbers with the same bits."""
    return values.astype(np.float32).view(np.int32).astype(np.int64)
