"""The player as a widget of a notebook, with the frames of a world as somebody steps it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import anywidget
import traitlets
from IPython import get_ipython

from .io.live_reel import LiveReel
from .io.page import posted_page
from .recorder import Known, Recorder
from .report import StepReport

if TYPE_CHECKING:
    from ._frangible import World

_HERE = Path(__file__).parent


class LivePlayer(anywidget.AnyWidget):
    """A player that shows a world now, and each frame of it as it is made.

    >>> from frangible.notebook import live
    >>> player = live(world)
    >>> player                  # in a cell of its own
    >>> player.run(120)
    >>> player.picked           # the id of the body that was pressed on

    Frames are those that this steps, or that it is told of with `capture`.
    """

    _esm = (_HERE / "live_widget.js").read_text(encoding="utf-8")

    title = traitlets.Unicode().tag(sync=True)
    #: Of the frame [CSS px]; it is as wide as the notebook.
    height = traitlets.Int().tag(sync=True)
    page = traitlets.Unicode().tag(sync=True)
    #: The id of the picked body, as in `World.ids`; `None` without one. Assign to it to pick.
    picked = traitlets.Int(None, allow_none=True).tag(sync=True)

    def __init__(self, world: World, title: str, height: int) -> None:
        super().__init__(title=title, height=height, page=posted_page(title))
        self.world = world
        self._blobs: list[bytes] = []
        known = Known()
        self._reel = LiveReel(self, known, {}, (title, world.method, 1.0 / world.dt))
        self._recorder = Recorder(world, None, self._reel, known)
        self._reel.send()
        self.on_msg(self._answer)
        if (shell := get_ipython()) is not None:
            # The last frames of a cell.
            shell.events.register("post_run_cell", self._send_rest)

    def step(self) -> StepReport:
        """Step the world, and show the frame; the report."""
        report = self.world.step()
        self.capture(report)
        return report

    def run(self, frames: int) -> None:
        """Step the world that often."""
        for _ in range(frames):
            self.step()
        self._send_rest()

    def capture(self, report: StepReport) -> None:
        """Show the state that a step of the world led to."""
        self._recorder.capture(report)
        self._reel.send_when_due()

    def end(self) -> None:
        """Say that no more frames come."""
        self._reel.send(is_last=True)

    def add(self, blob: bytes) -> None:
        """Send one more chunk."""
        self._blobs.append(blob)
        self._send_blob(len(self._blobs) - 1)

    def _send_rest(self, *_: object) -> None:
        if self._reel.is_behind:
            self._reel.send()

    def _answer(self, _: Any, asked: dict[str, Any], __: Any) -> None:
        """A reader misses chunks from a number on."""
        for number in range(max(int(asked["from"]), 0), len(self._blobs)):
            self._send_blob(number)

    def _send_blob(self, number: int) -> None:
        self.send({"number": number}, buffers=[self._blobs[number]])
