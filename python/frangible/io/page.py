"""One page that plays a recording: the player that `web/` builds, with the recording's data
inside."""

from __future__ import annotations

import base64
import html
import os
import re
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
#: In place of a recording that the page around this one posts; see `web/src/posted.ts`.
POSTED = "posted"
#: Width over height of the window that the first view is made for.
ASPECT = 16 / 9


#: What the page's policy ends with, and begins with where a server streams the recording.
_POLICY, _STREAMED = "base-uri 'none'", "connect-src 'self'; base-uri 'none'"


def write_html(recording: Recording, path: str) -> None:
    """Write a page that needs no other file and no network; `OutputError` without the player."""
    before, behind = _around_data(recording.shot)
    folder = os.path.dirname(os.path.abspath(path))
    camera = frame_recording(recording, ASPECT)
    with open(path, "wb") as file, Spool(folder) as data:
        file.write(before.encode())
        encode(recording, camera, data.add, folder)
        for chunk in data.chunks():
            file.write(base64.b64encode(chunk))
        file.write(behind.encode())


def page_of(recording: Recording) -> str:
    """The page that plays a recording, which is inside it."""
    before, behind = _around_data(recording.shot)
    pieces: list[bytes] = []
    encode(recording, frame_recording(recording, ASPECT), pieces.append)
    return before + base64.b64encode(b"".join(pieces)).decode("ascii") + behind


def streaming_page(shot: str) -> str:
    """The page that plays what its server streams, at ``chunks`` beside it."""
    return "".join(_around_data(shot)).replace(_POLICY, _STREAMED, 1)


def posted_page(title: str) -> str:
    """The page that plays what the page around it posts."""
    before, behind = _around_data(title)
    return before + POSTED + behind


def policy_of(page: str) -> str:
    """The content security policy of a page, for the header that it is served with."""
    found = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', page)
    assert found is not None
    return found[1]


def _around_data(shot: str) -> tuple[str, str]:
    """The page before and behind the place of the data."""
    try:
        template = PLAYER.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise OutputError(
            f"{PLAYER}: is missing, make it with: npm ci && npm run build, in web/"
        ) from error
    page = template.replace(TITLE, html.escape(shot or "Frangible"), 1)
    before, _, behind = page.partition(DATA)
    return before, behind
