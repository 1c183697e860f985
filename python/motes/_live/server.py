"""The server of a live run: page and socket on one port, in a thread of the image generator's process.

Nothing here can hold up the run, which only hands over its newest picture. Each viewer has at most two
unacknowledged pictures; of the pictures made meanwhile it gets only the latest.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import logging
import secrets
import socket
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from http import HTTPStatus
from typing import Any
from urllib.parse import urlsplit

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from .._io.output import tell
from .._values.live import MOST_PORT, Live
from ..errors import MotesError
from . import access, files
from .orders import Orders
from .pictures import Encoded, Picture, jpeg, lossless
from .viewer import MOST_BYTES, Viewer

__all__ = ["Server"]

MOST_VIEWERS = 64
MOST_WAITING = 16
"""Most connections that have not shown the token yet. Further ones push out the oldest, so strangers cannot
use up the file descriptors that the run needs."""
MOST_PORTS = 100  # to try while ports are busy
START_S = 20.0
CLOSE_S = 4.0  # for viewers that do not read; others get the last message at once
STATE_S = 0.05  # between two messages about the run's state
STILL_S = 0.25  # a paused run's picture follows without loss after this time
STILL_RUNNING_S = 2.0  # a running one's picture does if no newer one has come for this long
_EVERYWHERE = ("0.0.0.0", "::")
_BUSY = (errno.EADDRINUSE, errno.EACCES)


class Server:
    """Serves a run to viewers until `close`."""

    def __init__(self, live: Live, orders: Orders, about: dict[str, Any]) -> None:
        """Start the thread. Raises MotesError if there is no free port or no such address.

        `about` is the constant part of the state: title, width, height, the file that is repeated.
        """
        self._live = live
        self._orders = orders
        self._about = about
        self._token = secrets.token_urlsafe(16)
        self._viewers: set[Viewer] = set()
        self._waiting: dict[Any, Any] = {}  # transports of connections before their handshake, oldest first
        self._state: dict[str, Any] = {}
        self._version = 0  # of the state
        self._told_s = 0.0
        self._tells_soon = False
        self._newest: Picture | None = None
        self._encoded: Encoded | None = None
        self._count = 0
        self._changed_s = 0.0
        self._waits = live.wait
        self._encoder = ThreadPoolExecutor(1, "motes-live-encoder")
        self._ready = threading.Event()
        self._failure = ""
        self.port = 0
        _extras.websockets("asyncio.server")  # here: a library may not begin in two threads at once
        _extras.simplejpeg()
        self._thread = threading.Thread(target=self._run, name="motes-live", daemon=True)
        self._thread.start()
        self._ready.wait(START_S)
        if self.port == 0:
            raise MotesError(f"the live view cannot be served: {self._failure or 'its server did not start'}")

    # --- what the run calls

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

    def show(self, pixels: NDArray[np.uint8], *, frame: int, orders: int) -> None:
        """Leave a picture for the viewers, and return at once."""
        self._count += 1
        self._newest = Picture(self._count, frame, orders, pixels)
        self._changed_s = time.monotonic()
        self._call(self._wake_encoder)

    def tell(self, state: dict[str, Any]) -> None:
        """Send the run's state to all viewers if it has changed, and return at once."""
        if state != self._state:
            self._state = state
            if not self._tells_soon:
                self._tells_soon = True
                self._call(self._tell_soon)

    def close(self) -> None:
        """Tell viewers that the run has ended, and end the thread."""
        self._call(lambda: self._closing.set())
        self._thread.join(CLOSE_S + 1)
        self._encoder.shutdown(wait=False, cancel_futures=True)

    def _call(self, function: Callable[[], object]) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(function)

    # --- the thread

    def _run(self) -> None:
        try:
            asyncio.run(self._serve())
        except Exception as error:  # any: the run must learn of it, or continue without viewers
            self._failure = self._failure or f"{type(error).__name__}: {error}"
        finally:
            self._ready.set()

    async def _serve(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._closing = asyncio.Event()
        self._fresh = asyncio.Event()
        server = await self._bind()
        if server is None:
            return
        self.port = int(next(iter(server.sockets)).getsockname()[1])
        self._ready.set()
        encoding = asyncio.create_task(self._encode_on())
        await self._closing.wait()
        encoding.cancel()
        self._state = {**self._state, "ended": True}
        await self._offer_last()
        self._tell_all()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(asyncio.gather(*(v.finish() for v in list(self._viewers))), CLOSE_S / 2)
        server.close()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(server.wait_closed(), CLOSE_S / 2)

    async def _bind(self) -> Any:
        websockets = _extras.websockets("asyncio.server")
        quiet = logging.getLogger("motes.live")
        quiet.propagate, quiet.disabled = False, True
        first = self._live.port
        for port in range(first, min(first + MOST_PORTS, MOST_PORT + 1)) if first else (0,):
            try:
                return await websockets.serve(
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
            except OSError as error:
                self._failure = f"{self._live.host}:{port}: {error.strerror or error}"
                if error.errno not in _BUSY:
                    return None
        return None

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
        viewer = Viewer(connection, self._orders, self._wake_encoder)
        viewer.offer_state(self._version, {**self._about, **self._state})
        if self._encoded is not None:
            viewer.offer(self._encoded)
        self._viewers.add(viewer)
        self._orders.joined() if self._waits else self._orders.wake()
        self._waits = False
        self._wake_encoder()
        self._tell_all()
        try:
            await viewer.attend()
        finally:
            self._viewers.discard(viewer)
            self._tell_all()

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
        self._wake_encoder()

    def _wake_encoder(self) -> None:
        self._fresh.set()

    async def _encode_on(self) -> None:
        try:
            await self._encode()
        except Exception as error:  # any: the run continues without pictures, and somebody should know why
            tell(f"motes: viewers get no more pictures: {type(error).__name__}: {error}")

    async def _encode(self) -> None:
        """Encode the newest picture whenever a viewer can take it."""
        pause = 1.0 / self._live.max_fps
        while True:
            self._fresh.clear()
            picture = self._newest
            began = time.monotonic()
            if picture is None or not any(viewer.wants(picture.number) for viewer in self._viewers):
                await self._rest(picture)
                continue
            if self._encoded is None or self._encoded.number != picture.number:
                self._encoded = await self._in_thread(jpeg, picture, self._live.quality)
            for viewer in self._viewers:
                viewer.offer(self._encoded)
            await asyncio.sleep(max(0.0, pause - (time.monotonic() - began)))

    async def _offer_last(self) -> None:
        """Offer viewers the last picture, which `max_fps` may have held back."""
        newest = self._newest
        if newest is None or not self._viewers:
            return
        if not self._is_encoded(newest):
            self._encoded = await self._in_thread(jpeg, newest, self._live.quality)
        assert self._encoded is not None
        for viewer in self._viewers:
            viewer.offer_last(self._encoded)

    async def _rest(self, picture: Picture | None) -> None:
        """Wait for work; send the picture again without loss if it has not changed for a while."""
        exact = self._encoded is not None and self._encoded.exact
        still = picture is not None and bool(self._viewers) and not (exact and self._is_encoded(picture))
        limit = STILL_S if self._state.get("paused") or self._state.get("ended") else STILL_RUNNING_S
        left = self._changed_s + limit - time.monotonic()
        if still and left <= 0 and picture is not None:
            self._encoded = await self._in_thread(lossless, picture)
            for viewer in self._viewers:
                viewer.offer(self._encoded)
            return
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(self._fresh.wait(), left if still else None)

    def _is_encoded(self, picture: Picture) -> bool:
        return self._encoded is not None and self._encoded.number == picture.number

    async def _in_thread(self, encode: Callable[..., Encoded], *arguments: Any) -> Encoded:
        return await self._loop.run_in_executor(self._encoder, encode, *arguments)


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
