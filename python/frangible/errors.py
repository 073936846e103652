"""Errors about files, each in one sentence."""

from __future__ import annotations

import errno
import re
from collections.abc import Iterator
from contextlib import contextmanager

from ._frangible import BuildError


class CacheError(ValueError):
    """A file that is not a cache, in one sentence."""


class OutputError(ValueError):
    """An output that cannot be written, in one sentence."""


@contextmanager
def one_sentence(path: str, kind: str, error: type[ValueError] = BuildError) -> Iterator[None]:
    """Answers with ``error`` in one sentence, whatever the block raises about the content of the
    file.

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
