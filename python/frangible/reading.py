"""Shared by all readers of files: bounds, and one sentence for a library's error about a damaged file."""

from __future__ import annotations

import errno
import os
import re
import stat
from collections.abc import Iterator
from contextlib import contextmanager

from ._frangible import BuildError

#: The largest file, and the most memory that its compressed parts may take [bytes].
MOST_BYTES = 2**31


class FileNote(UserWarning):
    """A sentence about what a reader left out of a file."""


@contextmanager
def one_sentence(path: str, kind: str, error: type[ValueError] = BuildError) -> Iterator[None]:
    """Answers with ``error`` in one sentence, whatever the block raises about the content of the file.

    Sentences of our own, and what the disk says, pass.
    """
    try:
        yield
    except (BuildError, error):
        raise
    except MemoryError:
        raise error(f"{path}: needs more memory than there is") from None
    except OSError as reason:
        # A place before the file's beginning, as archives name it, is no trouble of the disk.
        if reason.errno != errno.EINVAL:
            raise
        raise error(f"{path}: is not a readable {kind}") from reason
    except Exception as reason:  # Libraries have exceptions of their own.
        raise error(f"{path}: is not a readable {kind}{_in_brackets(reason)}") from reason


def _in_brackets(reason: BaseException) -> str:
    """The first line of a short reason, or nothing: some libraries answer with a page."""
    lines = str(reason).strip().splitlines()
    # USD's sentences come with the place in its own code.
    if len(lines) == 1 and (place := re.search(r" at line \d+ in file .* : '(.*)'$", lines[0])):
        lines = [place[1]]
    if len(lines) != 1 or len(lines[0]) > 160:
        return ""
    return f" ({lines[0]})"


def file_fault(path: str) -> str | None:
    """The reason why a file cannot be read, to follow its name; `None` for a regular file of a bounded size."""
    try:
        status = os.stat(path)
    except ValueError:
        return "is not a path"
    except OSError as error:
        return "no such file" if isinstance(error, FileNotFoundError) else f"cannot be read: {error.strerror}"
    if stat.S_ISDIR(status.st_mode):
        return "is a folder, must be a file"
    if not stat.S_ISREG(status.st_mode):
        return "is a device or a pipe, must be a regular file"
    if status.st_size > MOST_BYTES:
        return f"has {status.st_size} bytes, must have at most {MOST_BYTES}"
    return None
