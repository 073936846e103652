"""One page that plays a recording: the player that `web/` builds, with the recording's data inside."""

from __future__ import annotations

import base64
import html
from pathlib import Path

from .camera import Camera, frame_bodies
from .page_data import encode
from .recording import Recording

#: What `npm run build` in `web/` makes; it refers to nothing outside itself.
PLAYER = Path(__file__).with_name("player.html")
#: What the recording takes the place of.
TITLE, DATA = "FRANGIBLE_TITLE", "FRANGIBLE_RECORDING"
#: Width over height of the window that the first view is made for.
ASPECT = 16 / 9
#: The first view shows what flies apart so long after the last break [s].
AFTER_BREAK = 0.25


class PlayerError(ValueError):
    """The player is not there, in one sentence."""


def write_html(recording: Recording, path: str) -> None:
    """Write a page that needs no other file and no network."""
    try:
        template = PLAYER.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise PlayerError(f"{PLAYER}: is missing, make it with: npm ci && npm run build, in web/") from error
    data = base64.b64encode(encode(recording, first_view(recording))).decode("ascii")
    page = template.replace(TITLE, html.escape(recording.shot or "Frangible"), 1).replace(DATA, data, 1)
    with open(path, "w", encoding="utf-8") as file:
        file.write(page)


def first_view(recording: Recording) -> Camera:
    """A camera that sees what broke shortly after it did."""
    breaks = [body.birth_frame for body in recording.bodies if body.parent is not None]
    after = round(AFTER_BREAK * recording.fps)
    frame = min(breaks[0] + after, recording.frames) if breaks else 0
    return frame_bodies(recording.bodies, frame, ASPECT)
