"""Shared by all readers of files: bounds, and the reason why a file cannot be read."""

from __future__ import annotations

import os
import stat

#: The largest file, and the most memory that its compressed parts may take [bytes].
MOST_BYTES = 2**31


#: What Git LFS leaves in the place of a file that was not fetched, and its most bytes.
_POINTER, _LARGEST_POINTER = b"version https://git-lfs", 1024


class FileNote(UserWarning):
    """A sentence about what a reader left out of a file."""


def file_fault(path: str) -> str | None:
    """The reason why a file cannot be read, to follow its name; `None` for a regular file of a
    bounded size."""
    try:
        status = os.stat(path)
    except ValueError:
        return "is not a path"
    except OSError as error:
        return (
            "no such file"
            if isinstance(error, FileNotFoundError)
            else f"cannot be read: {error.strerror}"
        )
    if stat.S_ISDIR(status.st_mode):
        return "is a folder, must be a file"
    if not stat.S_ISREG(status.st_mode):
        return "is a device or a pipe, must be a regular file"
    if status.st_size > MOST_BYTES:
        return f"has {status.st_size} bytes, must have at most {MOST_BYTES}"
    if status.st_size < _LARGEST_POINTER and _begins(path, _POINTER):
        return "is a pointer of Git LFS, must be the file that it stands for (git lfs pull)"
    return None


def _begins(path: str, with_bytes: bytes) -> bool:
    try:
        with open(path, "rb") as file:
            return file.read(len(with_bytes)) == with_bytes
    except OSError:
        return False
