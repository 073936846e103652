"""Files that a run writes: one writer for each ending, and no file is ever half written."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING

from .whole import whole_file as whole_file
from .whole import whole_path as whole_path

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
    #: What has to be installed besides.
    extra: str | None = None


def _write_npz(recording: Recording, path: str, frame: int | None) -> None:
    from .cache import write_npz

    write_npz(recording, path)


def _write_usd(recording: Recording, path: str, frame: int | None) -> None:
    from .usd import write_usd

    write_usd(recording, path)


def _write_glb(recording: Recording, path: str, frame: int | None) -> None:
    from .gltf import write_glb

    write_glb(recording, path)


def _write_html(recording: Recording, path: str, frame: int | None) -> None:
    from .page import write_html

    write_html(recording, path)


def _write_png(recording: Recording, path: str, frame: int | None) -> None:
    from .render import write_png

    write_png(recording, path, recording.frames if frame is None else frame)


def _write_plot(recording: Recording, path: str, frame: int | None) -> None:
    from .plot import write_plot

    write_plot(recording, path)


#: Modules that each extra of the installation brings.
_EXTRAS = {"exact": ("manifold3d",), "gltf": ("DracoPy",), "plot": ("matplotlib",), "render": ("embreex", "PIL"), "usd": ("pxr",)}

_FORMATS = {
    ".glb": _Format(_write_glb),
    ".html": _Format(_write_html),
    ".npz": _Format(_write_npz),
    ".png": _Format(_write_png, "render"),
    ".usda": _Format(_write_usd, "usd"),
    ".usdc": _Format(_write_usd, "usd"),
}

_PLOTS = {ending: _Format(_write_plot, "plot") for ending in (".pdf", ".png", ".svg")}


def open_output(path: str, frame: int | None = None) -> Output:
    """Check that a file can be written there, before anything is simulated; `OutputError` if not."""
    return _open(path, _FORMATS, frame)


def open_plot(path: str) -> Output:
    """The same for a plot of the books."""
    return _open(path, _PLOTS, None)


def _open(path: str, formats: dict[str, _Format], frame: int | None) -> Output:
    ending = check_destination(path, {ending: form.extra for ending, form in formats.items()})
    return Output(path, formats[ending].writer, frame)


def check_destination(path: str, extras: Mapping[str, str | None], besides: str = "") -> str:
    """The ending of a file that can be written, given the extra that each known ending needs; `OutputError` if it cannot.

    ``besides`` ends the sentence's list of what can be written.
    """
    # A link leads to what is written.
    folder = os.path.dirname(os.path.realpath(path) if os.path.islink(path) else path) or "."
    ending = os.path.splitext(path)[1].lower()
    if ending not in extras:
        known = ", ".join([*sorted(extras), *([besides] if besides else [])])
        raise OutputError(f"{path}: the ending {ending or '(none)'!r} is unknown, must be one of {known}")
    if os.path.isdir(path):
        raise OutputError(f"{path}: is a folder, must be a file")
    if os.path.exists(path) and not os.path.isfile(path):
        if not os.access(path, os.W_OK):
            raise OutputError(f"{path}: it cannot be written to")
    else:
        check_folder(path, folder)
    extra = extras[ending]
    if extra is not None and (hint := missing_packages(extra)):
        raise OutputError(f"{path}: {hint}")
    return ending


def check_folder(path: str, folder: str) -> None:
    """`OutputError` if nothing can be written into a folder; one that does not exist is made when a file is written."""
    while not os.path.exists(folder):
        folder = os.path.dirname(folder) or "."
    if not os.path.isdir(folder):
        raise OutputError(f"{path}: {folder!r} is no folder")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(f"{path}: the folder {folder!r} cannot be written to")


def missing_packages(extra: str) -> str | None:
    """How to install what an extra brings; `None` if all of it is there."""
    if all(find_spec(module) is not None for module in _EXTRAS[extra]):
        return None
    return f"needs an optional package, install it with: pip install 'frangible[{extra}]'"
