"""One page that plays a recording: the player that `web/` builds, with the recording's data
inside."""

from __future__ import annotations

import base64
import html
import os
from pathlib import Path

from ..errors import OutputError
from ..recording import Recording
from ..render.camera import frame_recording
from ..spool import Spool
from .page_data import encode

#: The product of `npm run build` in `web/`; it refers to nothing outside itself.
PLAYER = Path(__file__).parents[1] / "player.html"
#: The text that the recording replaces.
TITLE, DATA = "FRANGIBLE_TITLE", "FRANGIBLE_RECORDING"
#: Width over height of the window that the first view is made for.
ASPECT = 16 / 9


def write_html(recording: Recording, path: str) -> None:
    """Write a page that needs no other file and no network; `OutputError` without the player."""
    try:
        template = PLAYER.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise OutputError(
            f"{PLAYER}: is missing, make it with: npm ci && npm run build, in web/"
        ) from error
    template = template.replace(TITLE, html.escape(recording.shot or "Frangible"), 1)
    before, _, behind = template.partition(DATA)
    folder = os.path.dirname(os.path.abspath(path))
    camera = frame_recording(recording, ASPECT)
    with open(path, "wb") as file, Spool(folder) as data:
        file.write(before.encode())
        encode(recording, camera, data.add, folder)
        for chunk in data.chunks():
            file.write(base64.b64encode(chunk))
        file.write(behind.encode())
