"""Streams of small whole numbers, as the player reads them (`web/src/streams.ts`).

A blob is a header (its length as little-endian uint32, then UTF-8 JSON), then the streams, zlib
around all. A stream holds whole numbers (rows, columns), column after column: differences of
neighbours, taken ``order`` times, folded to unsigned (0, -1, 1, -2, ...), the lowest byte of all
rows first, then the next.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from ..spool import Spool

Ints = npt.NDArray[np.int64]

#: The best level is a hundredth smaller and takes four to six times as long (five shots).
_LEVEL = 6


#: Rows of a stream that are written at a time.
_ROWS = 2**15


class Blob:
    """The streams, as they grow; what is large waits on a disk."""

    def __init__(self, folder: str | None = None) -> None:
        """``folder`` has room for them."""
        self.streams: dict[str, dict[str, int]] = {}
        self._folder = folder
        self._data = Spool(folder)

    def add(self, name: str, values: npt.NDArray[Any], order: int = 1) -> None:
        """Whole numbers (rows,) or (rows, columns) that int32 holds."""
        columns = values if values.ndim > 1 else values[:, None]
        self.add_blocks(name, columns.shape[1], lambda: iter([columns]), order)

    def add_blocks(
        self, name: str, columns: int, blocks: Callable[[], Iterator[Ints]], order: int = 1
    ) -> None:
        """The same of rows that come in blocks (n, columns), which are asked for once for each
        column."""
        with Spool(self._folder) as folded:
            rows = most = 0
            for column in range(columns):
                rows = 0
                # What the differences of each order begin with: the last of the block before.
                carried = np.zeros(order, np.int64)
                for block in blocks():
                    for first in range(0, len(block), _ROWS):
                        numbers = block[first : first + _ROWS, column].astype(np.int64)
                        # Differences may need a bit more than the numbers; they wrap around, and
                        # so do sums.
                        for level in range(order):
                            last, carried[level] = carried[level], numbers[-1]
                            numbers = np.diff(numbers, prepend=last)
                        wrapped = numbers.astype(np.uint32).view(np.int32)
                        unsigned = ((wrapped << 1) ^ (wrapped >> 31)).view(np.uint32)
                        most = max(most, int(unsigned.max()))
                        folded.add(unsigned.astype("<u4").tobytes())
                        rows += len(numbers)
            width = (most.bit_length() + 7) // 8
            self.streams[name] = {
                "offset": self._data.size,
                "rows": rows,
                "columns": columns,
                "bytes": width,
                "order": order,
            }
            for byte in range(width):
                for chunk in folded.chunks():
                    self._data.add(chunk[byte::4])

    def write(self, header: dict[str, Any], out: Callable[[bytes], object]) -> None:
        """Everything, compressed, piece by piece."""
        text = json.dumps({**header, "streams": self.streams}, separators=(",", ":")).encode()
        packer = zlib.compressobj(_LEVEL)
        out(packer.compress(len(text).to_bytes(4, "little") + text))
        for chunk in self._data.chunks():
            out(packer.compress(chunk))
        out(packer.flush())


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
