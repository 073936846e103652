"""One page that plays a recording: the player that `web/` builds, with the recording's data
inside."""

from __future__ import annotations

import base64
import html
import re
from pathlib import Path

from ..errors import OutputError
from ..recording import Recording
from ..render.camera import frame_recording
from .page_data import encode

#: The product of `npm run build` in `web/`; it refers to nothing outside itself.
PLAYER = Path(__file__).parents[1] / "player.html"
#: The text that the recording replaces.
TITLE, DATA = "FRANGIBLE_TITLE", "FRANGIBLE_RECORDING"
#: Width over height of the window that the first view is made for.
ASPECT = 16 / 9


#: What the page's policy ends with, and begins with where a server streams the recording.
_POLICY, _STREAMED = "base-uri 'none'", "connect-src 'self'; base-uri 'none'"


def write_html(recording: Recording, path: str) -> None:
    """Write a page that needs no other file and no network; `OutputError` without the player."""
    page = page_of(recording)
    with open(path, "w", encoding="utf-8") as file:
        file.write(page)


def page_of(recording: Recording) -> str:
    """The page that plays a recording, which is inside it."""
    data = base64.b64encode(encode(recording, frame_recording(recording, ASPECT))).decode("ascii")
    return _filled(recording.shot, data)


def streaming_page(shot: str) -> str:
    """The page that plays what its server streams, at ``chunks`` beside it."""
    return _filled(shot, "").replace(_POLICY, _STREAMED, 1)


def policy_of(page: str) -> str:
    """The content security policy of a page, for the header that it is served with."""
    found = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', page)
    assert found is not None
    return found[1]


def _filled(shot: str, data: str) -> str:
    try:
        template = PLAYER.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise OutputError(
            f"{PLAYER}: is missing, make it with: npm ci && npm run build, in web/"
        ) from error
    title = html.escape(shot or "Frangible")
    return template.replace(TITLE, title, 1).replace(DATA, data, 1)
