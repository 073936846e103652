"""Recordings and worlds in a notebook: the player, in a frame of its own, and live."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

from .errors import OutputError
from .extras import missing_packages
from .io.page import page_of
from .recorder import Known, Memory, Recorder, assemble
from .recording import Recording

if TYPE_CHECKING:
    from ._frangible import World
    from .live_widget import LivePlayer

#: Of the frame, as wide as the notebook [CSS px].
HEIGHT = 520


def recording_html(recording: Recording, height: int = HEIGHT) -> str:
    """A frame with the player and the recording inside: nothing else is asked for."""
    page = html.escape(page_of(recording), quote=True)
    # Scripts run in it, apart from the notebook.
    return (
        f'<iframe srcdoc="{page}" sandbox="allow-scripts" allow="fullscreen" '
        f'title="{html.escape(recording.shot or "Recording")}" '
        f'style="width: 100%; height: {height}px; border: 0"></iframe>'
    )


def world_html(world: World, height: int = HEIGHT) -> str:
    """A world as it is now."""
    memory, known = Memory(), Known()
    Recorder(world, None, memory, known)
    now = assemble(memory, known, {}, ("World", world.method, 1.0 / world.dt))
    return recording_html(now, height)


def live(world: World, title: str = "World", height: int = HEIGHT) -> LivePlayer:
    """A widget that shows a world, and each frame as `LivePlayer.step` or `run` makes it.

    `LivePlayer.picked` is the id of the body that a reader pressed on. `OutputError` without the
    extra `notebook`.
    """
    if missing := missing_packages("notebook"):
        raise OutputError(f"a live player {missing}")
    from .live_widget import LivePlayer

    return LivePlayer(world, title, height)
