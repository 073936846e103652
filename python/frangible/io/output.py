"""Files that a run writes: one writer for each ending, and no file is ever half written."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from ..errors import OutputError
from ..extras import missing_packages
from ..recording import Recording
from ..render.camera import check_camera
from .drawing import View, check_renderer, drawn
from .whole import whole_file, whole_folder, whole_path


@dataclass(frozen=True, slots=True)
class Output:
    """A checked destination, ready to be written."""

    path: str
    writer: Callable[[Recording, str, int | None], None]
    #: The frame that a picture shows; the last one if not given.
    frame: int | None
    is_folder: bool = False

    def write(self, recording: Recording) -> None:
        """Write the whole file or none; an `OSError` names it."""
        whole = whole_folder if self.is_folder else whole_file
        try:
            with whole(self.path) as part:
                self.writer(recording, part, self.frame)
        except OSError as error:
            raise OSError(error.errno, error.strerror or str(error), self.path) from error


@dataclass(frozen=True, slots=True)
class _Format:
    writer: Callable[[Recording, str, int | None], None]
    #: Packages that it needs besides.
    extra: str | None = None


def _write_npz(recording: Recording, path: str, frame: int | None) -> None:
    from .cache import write_npz

    write_npz(recording, path)


def _write_usd(recording: Recording, path: str, frame: int | None) -> None:
    from .usd import geometry_path, write_usd

    with whole_file(geometry_path(whole_path(path))) as geometry:
        write_usd(recording, path, geometry)


def _write_usdz(recording: Recording, path: str, frame: int | None) -> None:
    from .usd import write_usdz

    write_usdz(recording, path)


def _write_abc(recording: Recording, path: str, frame: int | None) -> None:
    from .alembic import write_abc

    write_abc(recording, path)


def _write_glb(recording: Recording, path: str, frame: int | None) -> None:
    from .gltf import write_glb

    write_glb(recording, path)


def _write_html(recording: Recording, path: str, frame: int | None) -> None:
    from .page import write_html

    write_html(recording, path)


def _write_plot(recording: Recording, path: str, frame: int | None) -> None:
    from ..render.plot import write_plot

    write_plot(recording, path)


_FORMATS = {
    ".abc": _Format(_write_abc, "alembic"),
    ".glb": _Format(_write_glb),
    ".gif": _Format(drawn(".gif", View()), "film"),
    ".html": _Format(_write_html),
    ".mp4": _Format(drawn(".mp4", View()), "film"),
    ".npz": _Format(_write_npz),
    ".png": _Format(drawn(".png", View()), "render"),
    ".usda": _Format(_write_usd, "usd"),
    ".usdc": _Format(_write_usd, "usd"),
    ".usdz": _Format(_write_usdz, "usd"),
}

#: Endings that are drawn from a camera.
DRAWN = (".gif", ".mp4", ".png")

_PLOTS = {ending: _Format(_write_plot, "plot") for ending in (".pdf", ".png", ".svg")}


def open_output(path: str, frame: int | None = None, view: View | None = None) -> Output:
    """Check that a file can be written there, before anything is simulated; `OutputError` if not.

    A path that ends in a slash is a folder, which a film's frames fill.
    """
    if view is not None:
        check_camera(view.camera)
    if path.endswith("/"):
        return _open_folder(path.rstrip("/") or "/", view or View())
    output = _open(path, _FORMATS, frame)
    ending = os.path.splitext(path)[1].lower()
    if view is not None and ending in DRAWN:
        check_renderer(view, path)
        output = replace(output, writer=drawn(ending, view))
    return output


def _open_folder(path: str, view: View) -> Output:
    if os.path.lexists(path) and not os.path.isdir(path):
        raise OutputError(f"{path}: is a file, must be a folder")
    check_folder(path, os.path.dirname(path) or ".")
    if os.path.isdir(path):
        for name in sorted(os.listdir(path)):
            if not re.fullmatch(r"frame_\d+\.png", name):
                raise OutputError(f"{path}: holds {name!r}, must be new, or hold frames alone")
    if hint := missing_packages("render"):
        raise OutputError(f"{path}: {hint}")
    check_renderer(view, path)
    return Output(path, drawn("", view), None, is_folder=True)


def open_plot(path: str) -> Output:
    """The same for a plot of energy and momentum."""
    return _open(path, _PLOTS, None)


def _open(path: str, formats: dict[str, _Format], frame: int | None) -> Output:
    ending = check_destination(path, {ending: form.extra for ending, form in formats.items()})
    return Output(path, formats[ending].writer, frame)


def check_destination(path: str, extras: Mapping[str, str | None], besides: str = "") -> str:
    """The ending of a file that can be written, given the extra that each known ending needs;
    `OutputError` if it cannot.

    ``besides`` ends the sentence's list of what can be written.
    """
    # A link leads to what is written.
    folder = os.path.dirname(os.path.realpath(path) if os.path.islink(path) else path) or "."
    if not path:
        raise OutputError("--out: '', must be the name of a file")
    ending = os.path.splitext(path)[1].lower()
    if ending not in extras:
        known = ", ".join([*sorted(extras), *([besides] if besides else [])])
        raise OutputError(
            f"{path}: the ending {ending or '(none)'!r} is unknown, must be one of {known}"
        )
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
    """`OutputError` if nothing can be written into a folder; one that does not exist is made when a
    file is written."""
    while not os.path.exists(folder):
        folder = os.path.dirname(folder) or "."
    if not os.path.isdir(folder):
        raise OutputError(f"{path}: {folder!r} is no folder")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(f"{path}: the folder {folder!r} cannot be written to")
