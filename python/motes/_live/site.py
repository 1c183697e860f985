"""Serves a page and its socket on one port of an asyncio loop, to viewers who know the token."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import logging
import secrets
import socket
import time
from abc import ABC, abstractmethod
from collections.abc import Mapping
from http import HTTPStatus
from typing import Any
from urllib.parse import parse_qs, urlsplit

from .. import _extras
from .._values.live import MOST_PORT, Live
from . import access, files
from .viewer import MOST_BYTES, Viewer

__all__ = ["Site"]

MOST_VIEWERS = 64
MOST_WAITING = 16
"""Most connections that have not shown the token yet. Further ones push out the oldest, so strangers cannot
use up the file descriptors that the run needs."""
MOST_PORTS = 100  # to try while ports are busy
STATE_S = 0.05  # between two messages about the run's state
_EVERYWHERE = ("0.0.0.0", "::")
_BUSY = (errno.EADDRINUSE, errno.EACCES)


class Site(ABC):
    """A page and its viewers. All methods are called in the thread of its loop."""

    _loop: asyncio.AbstractEventLoop

    def __init__(self, live: Live, about: dict[str, Any]) -> None:
        """Take address and port, and the constant part of the state, such as the title."""
        self._live = live
        self._about = about
        self._token = secrets.token_urlsafe(16)
        self._viewers: set[Viewer] = set()
        self._waiting: dict[Any, Any] = {}  # transports of connections before their handshake, oldest first
        self._state: dict[str, Any] = {}
        self._version = 0  # of the state
        self._told_s = 0.0
        self._tells_soon = False
        self._failure = ""
        self.port = 0

    @property
    def url(self) -> str:
        """The page's address, with the token."""
        host = socket.gethostname() if self._live.host in _EVERYWHERE else self._live.host
        shown = f"[{host}]" if ":" in host else host
        return f"http://{shown}:{self.port}/?k={self._token}"

    @property
    def viewers(self) -> int:
        """The number of viewers."""
        return len(self._viewers)

    # --- what servers define

    @abstractmethod
    def _viewer(self, connection: Any, query: Mapping[str, list[str]]) -> Viewer:
        """Return a new viewer; `query`: what its address asks for."""

    @abstractmethod
    def _came(self, viewer: Viewer) -> None:
        """Note that a viewer has joined."""

    @abstractmethod
    def _left(self, viewer: Viewer) -> None:
        """Note that a viewer has left."""

    # --- the port

    async def _bind(self) -> Any:
        """Return the server once it listens on `port`; None: it cannot, see `_failure`."""
        websockets = _extras.websockets("asyncio.server")
        quiet = logging.getLogger("motes.live")
        quiet.propagate, quiet.disabled = False, True
        first = self._live.port
        for port in range(first, min(first + MOST_PORTS, MOST_PORT + 1)) if first else (0,):
            try:
                server = await websockets.serve(
                    self._attend,
                    self._live.host,
                    port,
                    process_request=self._admit,
                    create_connection=_counted(websockets.ServerConnection, self._waiting),
                    backlog=MOST_WAITING,
                    compression=None,  # pictures are compressed
                    max_size=MOST_BYTES,
                    max_queue=8,
                    close_timeout=1,
                    logger=quiet,
                )
                self.port = int(next(iter(server.sockets)).getsockname()[1])
                return server
            except OSError as error:
                self._failure = f"{self._live.host}:{port}: {error.strerror or error}"
                if error.errno not in _BUSY:
                    return None
        return None

    async def _close(self, server: Any, seconds: float) -> None:
        """Give viewers what is left for them, and end the server, each at most for so long."""
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(asyncio.gather(*(v.finish() for v in list(self._viewers))), seconds)
        server.close()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(server.wait_closed(), seconds)

    def _admit(self, connection: Any, request: Any) -> Any:
        """Answer requests for the page and refuse strangers; None accepts a viewer's socket."""
        path = urlsplit(request.path).path
        host, origin = (_only(request.headers.get_all(name)) for name in ("Host", "Origin"))
        if not access.has_token(request.path, self._token):
            return connection.respond(
                HTTPStatus.FORBIDDEN, "The address lacks the token that the run has printed.\n"
            )
        if not access.own_page(origin, host, local=access.is_local(self._live.host)):
            return connection.respond(HTTPStatus.FORBIDDEN, "This page does not belong to the run.\n")
        if path == "/":
            return self._page(connection)
        if path != "/live":
            return connection.respond(HTTPStatus.NOT_FOUND, "There is no such page.\n")
        if len(self._viewers) >= MOST_VIEWERS:
            return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, "There are too many viewers.\n")
        return None

    def _page(self, connection: Any) -> Any:
        nonce = secrets.token_urlsafe(12)
        response = connection.respond(HTTPStatus.OK, files.page(nonce))
        allowed = (
            f"default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; "
            "img-src blob: data:; connect-src 'self' ws: wss:; base-uri 'none'; form-action 'none'; "
            "frame-ancestors 'self'"
        )
        del response.headers["Content-Type"]
        response.headers["Content-Type"] = "text/html; charset=utf-8"
        response.headers["Content-Security-Policy"] = allowed
        response.headers["Referrer-Policy"] = "no-referrer"
        response.headers["Cache-Control"] = "no-store"
        response.headers["X-Content-Type-Options"] = "nosniff"
        return response

    async def _attend(self, connection: Any) -> None:
        """Serve one viewer until it disconnects."""
        self._waiting.pop(connection, None)
        viewer = self._viewer(connection, parse_qs(urlsplit(connection.request.path).query))
        viewer.offer_state(self._version, {**self._about, **self._state})
        self._viewers.add(viewer)
        self._came(viewer)
        self._tell_all()
        try:
            await viewer.attend()
        finally:
            self._viewers.discard(viewer)
            self._left(viewer)
            self._tell_all()

    # --- the state

    def _tell_soon(self) -> None:
        """Send the state to all viewers, at most once per `STATE_S`."""
        self._loop.call_later(max(0.0, self._told_s + STATE_S - time.monotonic()), self._tell_all)

    def _tell_all(self) -> None:
        self._tells_soon = False
        self._told_s = time.monotonic()
        self._version += 1
        state = {**self._about, **self._state, "viewers": len(self._viewers)}
        for viewer in self._viewers:
            viewer.offer_state(self._version, state)


def _counted(connection: Any, waiting: dict[Any, Any]) -> Any:
    """Return a connection class that lets at most `MOST_WAITING` wait for their handshake."""

    class Counted(connection):  # type: ignore[misc]
        def connection_made(self, transport: Any) -> None:
            waiting[self] = transport
            while len(waiting) > MOST_WAITING:
                waiting.pop(next(iter(waiting))).abort()
            super().connection_made(transport)

        def connection_lost(self, error: Exception | None) -> None:
            waiting.pop(self, None)
            super().connection_lost(error)

    return Counted


def _only(values: list[str]) -> str | None:
    """Return a header's value; for several values, one that matches nothing."""
    return values[0] if len(values) == 1 else "several" if values else None
