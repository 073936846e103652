"""Files and folders that are there whole or not at all."""

from __future__ import annotations

import os
import secrets
import shutil
import signal
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress

#: Marks the name of what is not whole yet.
_PART = ".part"
#: Signals that end a program; they must not come between two steps of a swap.
_SIGNALS = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}


@contextmanager
def whole_file(path: str) -> Iterator[str]:
    """A temporary path that takes its name at the end, or vanishes if the block fails.

    It lies beside ``path``, or beside the file that a link there leads to. A pipe or a device gets
    the bytes at the end.
    """
    before = _status(path)
    if before is not None and not stat.S_ISREG(before.st_mode):
        with tempfile.TemporaryDirectory() as folder:
            part = os.path.join(folder, os.path.basename(path))
            yield part
            # By its own name: what /dev/stdout leads to may have none.
            with open(part, "rb") as source, open(path, "wb") as pipe:
                shutil.copyfileobj(source, pipe)
        return
    target = os.path.realpath(path)
    folder, name = os.path.split(target)
    os.makedirs(folder, exist_ok=True)
    stem, ending = os.path.splitext(name)
    part = os.path.join(folder, f".{stem}.{secrets.token_hex(4)}{_PART}{ending}")
    try:
        yield part
        if before is not None:
            os.chmod(part, stat.S_IMODE(before.st_mode))
        _sync(part)
        os.replace(part, target)
        _sync(folder)
    finally:
        with suppress(FileNotFoundError):
            os.unlink(part)


@contextmanager
def whole_folder(path: str) -> Iterator[str]:
    """A new temporary folder that takes its name at the end, in place of the one there; or vanishes
    if the block fails."""
    target = os.path.realpath(path)
    above, name = os.path.split(target)
    mark = f".{name}.{secrets.token_hex(4)}"
    part, old = (os.path.join(above, f"{mark}{ending}") for ending in (_PART, f".old{_PART}"))
    os.mkdir(part)
    try:
        yield part
        for found in os.listdir(part):
            _sync(os.path.join(part, found))
        _sync(part)
        with _undisturbed():
            before = _status(target)
            if before is not None:
                os.chmod(part, stat.S_IMODE(before.st_mode))
                os.rename(target, old)
            try:
                os.rename(part, target)
            except OSError:
                if before is not None:
                    os.rename(old, target)
                raise
            _sync(above)
            shutil.rmtree(old, ignore_errors=True)
    finally:
        shutil.rmtree(part, ignore_errors=True)


def whole_path(part: str) -> str:
    """The path that a temporary one of `whole_file` gets at the end; any other path as it is."""
    folder, name = os.path.split(part)
    stem, ending = os.path.splitext(name)
    if not (stem.startswith(".") and stem.endswith(_PART)):
        return part
    return os.path.join(folder, stem[1:].removesuffix(_PART).rpartition(".")[0] + ending)


def _status(path: str) -> os.stat_result | None:
    try:
        return os.stat(path)
    except FileNotFoundError:
        return None


def _sync(path: str) -> None:
    """Wait until a file or a folder is on the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        # Some file systems know no such thing of a folder.
        if not os.path.isdir(path):
            raise error
    finally:
        os.close(descriptor)


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Signals that end the program wait until the block is done."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
