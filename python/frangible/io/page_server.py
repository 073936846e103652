"""Serves one page to this machine alone.

The address holds a token that nobody can guess, so that no other page and no other user of the
machine finds it; a request by another name for the machine is refused, as a page would make that
binds its own name to this address.
"""

from __future__ import annotations

import hmac
import secrets
import sys
import threading
from collections.abc import Callable, Iterator
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from .page import policy_of

#: The only address that is listened at.
LOOPBACK = "127.0.0.1"
#: Where the page's data is, beside it.
CHUNKS = "chunks"
#: Of all answers: nothing is kept, guessed, framed or told on.
_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
}


class PageServer:
    """A page, and the blobs that it plays, if they are not inside it."""

    def __init__(self, page: str, follow: Callable[[], Iterator[bytes]] | None = None) -> None:
        """``follow`` gives all blobs to one reader as they come, and empty ones while none
        comes."""
        self.token = secrets.token_urlsafe(24)
        self.page = page.encode()
        self.policy = f"{policy_of(page)}; frame-ancestors 'none'"
        self.follow = follow
        self._server = _Server((LOOPBACK, 0), _Handler)
        self._server.owner = self
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)

    @property
    def host(self) -> str:
        """Of the address, with its port."""
        return f"{LOOPBACK}:{self._server.server_address[1]}"

    @property
    def address(self) -> str:
        """Of the page."""
        return f"http://{self.host}/{self.token}/"

    def __enter__(self) -> PageServer:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()
        self._server.server_close()


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    owner: PageServer

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A page that is closed while it asks is no error."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)


class _Handler(BaseHTTPRequestHandler):
    server: _Server

    def do_GET(self) -> None:
        """The page, its blobs, or nothing."""
        owner = self.server.owner
        if self.headers.get("Host") != owner.host:
            return self._answer(HTTPStatus.FORBIDDEN, b"")
        before, _, path = self.path.split("?", 1)[0].partition("/")
        token, *rest = path.split("/")
        if before or not hmac.compare_digest(token.encode(), owner.token.encode()):
            return self._answer(HTTPStatus.NOT_FOUND, b"")
        if rest == [""]:
            headers = {
                "Content-Type": "text/html; charset=utf-8",
                "Content-Security-Policy": owner.policy,
            }
            return self._answer(HTTPStatus.OK, owner.page, headers)
        if rest == [CHUNKS] and owner.follow is not None:
            return self._stream(owner.follow())
        return self._answer(HTTPStatus.NOT_FOUND, b"")

    def _answer(self, status: int, body: bytes, headers: dict[str, str] | None = None) -> None:
        self._begin(status, {**(headers or {}), "Content-Length": str(len(body))})
        self.wfile.write(body)

    def _stream(self, blobs: Iterator[bytes]) -> None:
        """Each blob after its length; the end of the connection ends them."""
        self._begin(HTTPStatus.OK, {"Content-Type": "application/octet-stream"})
        for blob in blobs:
            if blob:
                self.wfile.write(len(blob).to_bytes(4, "little") + blob)
            self.wfile.flush()

    def _begin(self, status: int, headers: dict[str, str]) -> None:
        self.send_response_only(status)
        for name, value in {**_HEADERS, **headers}.items():
            self.send_header(name, value)
        self.end_headers()

    def log_message(self, format: str, *args: object) -> None:
        """Nothing: the token would stand in it."""
