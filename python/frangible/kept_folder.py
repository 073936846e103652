"""The folder of a run, for one process at a time; what is not ours in it is never deleted."""

from __future__ import annotations

import fcntl
import os
from contextlib import suppress
from typing import IO

from .errors import CacheError
from .journal import begins_journal

#: The file of the records, that of the last checkpoint, and how it is called while it is written.
JOURNAL, CHECKPOINT, NEW_CHECKPOINT = "frames", "checkpoint", "checkpoint.new"
#: Whoever writes the folder holds this file's lock. The system lets go of it when the process ends,
#: however it ends.
LOCK = "lock"
_OURS = {JOURNAL, CHECKPOINT, NEW_CHECKPOINT, LOCK}

_WAY_OUT = "or --out must name another file"


def check_kept_folder(path: str) -> None:
    """`CacheError` if a run cannot be kept at ``path``: something else is there, or the run of
    another process."""
    _check_ours(path)
    if os.path.exists(os.path.join(path, LOCK)):
        KeptFolder(path, is_new=False).let_go()


def _check_ours(path: str) -> None:
    if not os.path.lexists(path):
        return
    if not os.path.isdir(path):
        raise CacheError(f"{path}: is no folder of a run, must be moved away, {_WAY_OUT}")
    foreign = sorted(set(os.listdir(path)) - _OURS)
    journal = os.path.join(path, JOURNAL)
    if not foreign and os.path.lexists(journal) and not begins_journal(journal):
        foreign = [JOURNAL]
    if foreign:
        raise CacheError(
            f"{path}: holds {foreign[0]!r}, which no run wrote there, must be moved away, "
            f"{_WAY_OUT}"
        )


class KeptFolder:
    """A folder that this process alone writes."""

    def __init__(self, path: str, is_new: bool) -> None:
        """Take the folder, a new one if it ``is_new``; `CacheError` if it is not ours, or another
        process has it."""
        self.path = path
        if is_new:
            os.makedirs(path, exist_ok=True)
        _check_ours(path)
        self._lock = self._taken()

    def _taken(self) -> IO[bytes]:
        """The file of the lock; another one if its folder went while we waited for it."""
        name = os.path.join(self.path, LOCK)
        while True:
            # Closed with the object.
            file = open(name, "ab", buffering=0)  # noqa: SIM115
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if _is_at(file, name):
                    return file
            except BlockingIOError:
                raise CacheError(
                    f"{self.path}: another run writes it, must end first, {_WAY_OUT}"
                ) from None
            except OSError:
                # A file system that knows no locks.
                return file

    def clear(self) -> None:
        """Delete what an earlier run left."""
        for name in _OURS - {LOCK}:
            with suppress(FileNotFoundError):
                os.unlink(os.path.join(self.path, name))

    def remove(self) -> None:
        """Delete it, but for what is not ours."""
        with suppress(OSError):
            self.clear()
            os.unlink(os.path.join(self.path, LOCK))
            os.rmdir(self.path)
        self.let_go()

    def let_go(self) -> None:
        """Others may write it."""
        self._lock.close()


def _is_at(file: IO[bytes], path: str) -> bool:
    try:
        return os.path.samestat(os.fstat(file.fileno()), os.stat(path))
    except FileNotFoundError:
        return False
