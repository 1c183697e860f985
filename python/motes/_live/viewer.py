"""One viewer's connection: pictures and states go out, orders come in."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections import deque
from collections.abc import Callable
from typing import Any, Protocol

from .. import _extras
from .pictures import Encoded

__all__ = ["MOST_BYTES", "Viewer"]

MOST_BYTES = 64 * 1024  # in one message from a viewer
MOST_IN_FLIGHT = 2  # unacknowledged pictures
MOST_KEPT = 64  # pictures that a viewer which keeps all has not read yet; older ones are dropped


class Taker(Protocol):
    """Who takes orders: `Orders`, or the desk."""

    def put(self, order: Any) -> None:
        """Queue a viewer's order. Raises ValueError, which says why, for an invalid one."""


class Viewer:
    """A browser or program that views the run. Used only in the server's thread."""

    def __init__(
        self, socket: Any, orders: Taker, wake: Callable[[], object], *, keeps: bool = False
    ) -> None:
        """Take the viewer's socket; `wake` is called when it can take another picture.

        `keeps`: it gets all pictures, at once, and need not acknowledge them.
        """
        self.keeps = keeps
        self._socket = socket
        self._orders = orders
        self._wake = wake
        self._something = asyncio.Event()
        self._offered: Encoded | None = None
        self._state: dict[str, Any] = {}
        self._version = -1
        self._told = -1
        self._sent = 0  # the number of the last picture sent
        self._exact = False  # whether that picture was lossless
        self._flying: list[int] = []
        self._kept: deque[bytes] = deque(maxlen=MOST_KEPT)
        self._notes: deque[str] = deque()
        self._most_in_flight = MOST_IN_FLIGHT
        self._refusal = ""
        self._idle = asyncio.Event()

    # --- what the server calls

    def wants(self, number: int) -> bool:
        """Return whether the viewer can take this picture and has not been offered it yet."""
        offered = 0 if self._offered is None else self._offered.number
        return len(self._flying) < MOST_IN_FLIGHT and max(self._sent, offered) < number

    def offer(self, picture: Encoded) -> None:
        """Offer a picture, in place of one that has not been sent yet."""
        self._offered = picture
        self._something.set()

    def keep(self, picture: Encoded) -> None:
        """Send a viewer that keeps all pictures this one, in turn; offer it to another."""
        if not self.keeps:
            if self.wants(picture.number):
                self.offer(picture)
            return
        self._sent, self._exact = picture.number, picture.exact
        self.send(picture.message)

    def send(self, message: bytes) -> None:
        """Send a picture that needs no acknowledgement."""
        self._kept.append(message)
        self._something.set()

    def note(self, text: str) -> None:
        """Send a note after those before it."""
        self._notes.append(text)
        self._something.set()

    def offer_last(self, picture: Encoded) -> None:
        """Offer the run's last picture, which may be sent before the others are acknowledged."""
        self._most_in_flight = MOST_IN_FLIGHT + 1
        self.offer(picture)

    def offer_state(self, version: int, state: dict[str, Any]) -> None:
        """Offer a state, in place of one that has not been sent yet."""
        self._version, self._state = version, state
        self._something.set()

    async def finish(self) -> None:
        """Wait until everything offered has been sent."""
        self._idle.clear()
        self._something.set()
        await self._idle.wait()

    async def attend(self) -> None:
        """Send and receive until the viewer disconnects."""
        closed: type[Exception] = _extras.websockets("exceptions").ConnectionClosed
        sending = asyncio.create_task(self._send())
        try:
            with contextlib.suppress(closed):
                async for message in self._socket:
                    self._hear(message)
        finally:
            sending.cancel()
            self._idle.set()
            with contextlib.suppress(asyncio.CancelledError, closed):
                await sending

    # --- the connection

    async def _send(self) -> None:
        try:
            while True:
                await self._something.wait()
                self._something.clear()
                if self._refusal:
                    refusal, self._refusal = self._refusal, ""
                    await self._socket.send(json.dumps({"refused": refusal}))
                while self._notes:
                    await self._socket.send(self._notes.popleft())
                while self._kept:
                    await self._socket.send(self._kept.popleft())
                if self._told < self._version:
                    self._told = self._version
                    await self._socket.send(json.dumps(self._state))
                if self._is_news():
                    await self._send_picture()
                if not self._something.is_set():
                    self._idle.set()
        finally:
            self._idle.set()

    def _is_news(self) -> bool:
        offered = self._offered
        if offered is None or len(self._flying) >= self._most_in_flight:
            return False
        return offered.number > self._sent or (
            offered.number == self._sent and offered.exact and not self._exact
        )

    async def _send_picture(self) -> None:
        offered = self._offered
        assert offered is not None
        self._offered = None
        self._sent, self._exact = offered.number, offered.exact
        if not self.keeps:
            self._flying.append(offered.number)
        await self._socket.send(offered.message)
        self._wake()

    def _hear(self, message: str | bytes) -> None:
        try:
            content = json.loads(message)
            if isinstance(content, dict) and set(content) == {"ack"}:
                self._acknowledge(content["ack"])
            else:
                self._orders.put(content)
        except (ValueError, ArithmeticError, RecursionError, TypeError) as error:
            self._refusal = str(error)[:300]
            self._something.set()

    def _acknowledge(self, number: Any) -> None:
        if number in self._flying:
            self._flying.remove(number)
            self._something.set()
            self._wake()
