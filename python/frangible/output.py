"""Files that a run writes: one writer for each ending, and no file is ever half written."""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .recording import Recording


class OutputError(ValueError):
    """An output that cannot be written, in one sentence."""


@dataclass(frozen=True, slots=True)
class Output:
    """A checked destination, ready to be written."""

    path: str
    writer: Callable[[Recording, str, int | None], None]
    #: The frame that a picture shows; the last one if not given.
    frame: int | None

    def write(self, recording: Recording) -> None:
        """Write the whole file or none; an `OSError` names it."""
        try:
            with whole_file(self.path) as part:
                self.writer(recording, part, self.frame)
        except OSError as error:
            raise OSError(error.errno, error.strerror or str(error), self.path) from error


@dataclass(frozen=True, slots=True)
class _Format:
    writer: Callable[[Recording, str, int | None], None]
    #: Modules beyond the base installation, and the extra that brings them.
    modules: tuple[str, ...] = ()
    extra: str = ""


def _write_npz(recording: Recording, path: str, frame: int | None) -> None:
    from .cache import write_npz

    write_npz(recording, path)


def _write_usd(recording: Recording, path: str, frame: int | None) -> None:
    from .usd import write_usd

    write_usd(recording, path)


def _write_glb(recording: Recording, path: str, frame: int | None) -> None:
    from .gltf import write_glb

    write_glb(recording, path)


def _write_png(recording: Recording, path: str, frame: int | None) -> None:
    from .render import write_png

    write_png(recording, path, recording.frames if frame is None else frame)


_FORMATS = {
    ".glb": _Format(_write_glb),
    ".npz": _Format(_write_npz),
    ".png": _Format(_write_png, ("embreex", "PIL"), "render"),
    ".usda": _Format(_write_usd, ("pxr",), "usd"),
    ".usdc": _Format(_write_usd, ("pxr",), "usd"),
}


def open_output(path: str, frame: int | None = None) -> Output:
    """Check that a file can be written there, before anything is simulated; `OutputError` if not."""
    folder = os.path.dirname(path) or "."
    ending = os.path.splitext(path)[1].lower()
    if ending not in _FORMATS:
        known = ", ".join(sorted(_FORMATS))
        raise OutputError(f"{path}: the ending {ending or '(none)'!r} is unknown, must be one of {known}")
    if not os.path.isdir(folder):
        raise OutputError(f"{path}: the folder {folder!r} does not exist, create it first")
    if os.path.isdir(path):
        raise OutputError(f"{path}: is a folder, must be a file")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(f"{path}: the folder {folder!r} cannot be written to")
    if hint := missing_packages(ending):
        raise OutputError(f"{path}: {hint}")
    return Output(path, _FORMATS[ending].writer, frame)


def missing_packages(ending: str) -> str | None:
    """How to install what a format needs; `None` if all of it is there."""
    form = _FORMATS[ending]
    if all(find_spec(module) is not None for module in form.modules):
        return None
    return f"needs an optional package, install it with: pip install 'frangible[{form.extra}]'"


@contextmanager
def whole_file(path: str) -> Iterator[str]:
    """A temporary path beside ``path`` that takes its name at the end, or vanishes if the block fails."""
    folder, name = os.path.split(path)
    stem, ending = os.path.splitext(name)
    part = os.path.join(folder, f".{stem}.{secrets.token_hex(4)}.part{ending}")
    try:
        yield part
        os.replace(part, path)
    finally:
        with suppress(FileNotFoundError):
            os.unlink(part)
