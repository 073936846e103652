"""Pictures and films of recordings, by one of two renderers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from ..errors import OutputError
from ..extras import missing_packages
from ..recording import Recording
from ..render.camera import camera_for
from ..render.shutter import CLOSED, Shutter

#: The one of `render.picture`, and Blender's path tracer.
RENDERERS = ("own", "blender")
#: Width and height of pictures, and of films: half of it, so that a film takes minutes [pixels].
PICTURE_SIZE, FILM_SIZE = (1280, 720), (960, 540)


@dataclass(frozen=True, slots=True)
class View:
    """How pictures and films are taken."""

    #: ``fit``, ``stage``, or the file of a camera.
    camera: str = "fit"
    #: Width and height [pixels]; `None` for what a picture or a film has by default.
    size: tuple[int, int] | None = None
    #: Called with how much is drawn, and of how much.
    progress: Callable[[int, int], None] | None = None
    #: When light comes in.
    shutter: Shutter = CLOSED
    #: One of `RENDERERS`.
    renderer: str = RENDERERS[0]
    #: Rays of a pixel in Blender.
    rays: int = 64
    #: The first frame of a film, and the last one; `None` for the recording's.
    first: int = 0
    last: int | None = None


def check_renderer(view: View, path: str) -> None:
    """`OutputError` if what a view is drawn with is not installed."""
    if view.renderer != "blender":
        return
    from .blender import missing_blender

    if hint := missing_blender() or missing_packages("usd"):
        raise OutputError(f"{path}: {hint}")


def drawn(ending: str, view: View) -> Callable[[Recording, str, int | None], None]:
    """Writes a picture, ``.png``, or with any other ending a film."""

    def write(recording: Recording, path: str, frame: int | None) -> None:
        size = view.size or (PICTURE_SIZE if ending == ".png" else FILM_SIZE)
        camera = camera_for(recording, view.camera, size[0] / size[1])
        shown = recording.frames if frame is None else frame
        if view.renderer == "blender":
            from .blender import BlenderFilm, blender_pictures, write_blender_png

            made = BlenderFilm(recording, camera, *size, view.shutter, view.rays)
            if ending == ".png":
                write_blender_png(made, path, shown)
                return
            draw = partial(blender_pictures, made)
        elif ending == ".png":
            from ..render.picture import write_png

            write_png(recording, path, shown, camera, size, view.progress, view.shutter)
            return
        else:
            from ..render.film_processes import Film, film_pictures

            draw = partial(film_pictures, Film(recording, camera, *size, view.shutter))
        from ..render.film import write_film

        last = recording.frames if view.last is None else view.last
        frames = range(min(view.first, last), last + 1)
        write_film(path, ending, recording.fps, frames, draw, view.progress)

    return write
