"""Bytes that wait on a disk until their place in a file is known."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from types import TracebackType
from typing import IO

#: More than this goes to a disk [bytes].
IN_MEMORY = 2**20
#: Read back at a time [bytes]; a multiple of 12, so that base64 and words of four bytes fit.
CHUNK = 3 * 2**18


class Spool:
    """Grows by pieces, and is read back from its beginning. What is large is in a file without a
    name."""

    def __init__(self, folder: str | None = None) -> None:
        """``folder`` has room for it; the system's own for such files without one."""
        self.size = 0
        # Closed with the object.
        self._file: IO[bytes] = tempfile.SpooledTemporaryFile(IN_MEMORY, dir=folder)  # noqa: SIM115

    def add(self, data: bytes) -> None:
        """Behind all others."""
        self._file.write(data)
        self.size += len(data)

    def chunks(self) -> Iterator[bytes]:
        """All of it, in pieces of `CHUNK` bytes and the rest."""
        self._file.seek(0)
        while chunk := self._file.read(CHUNK):
            yield chunk
        self._file.seek(self.size)

    def close(self) -> None:
        """It is not needed any more."""
        self._file.close()

    def __enter__(self) -> Spool:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
