"""Viewers for tests: clients that communicate with a live run as its page does."""

from __future__ import annotations

import asyncio
import contextlib
import json
import struct
import threading
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

websockets = pytest.importorskip("websockets")
connect = pytest.importorskip("websockets.asyncio.client").connect
pytest.importorskip("simplejpeg")

HEAD = struct.Struct("<4sIIII")
START_S = 40


def address(url: str) -> str:
    """Return the address of a page's socket."""
    parts = urlsplit(url)
    return f"ws://{parts.netloc}/live?{parts.query}"


async def url_of(folder: Path) -> str:
    """Wait until the run prints its address."""
    limit = time.monotonic() + START_S
    while not (folder / "url").exists():
        assert time.monotonic() < limit, "the run does not say where it is"
        await asyncio.sleep(0.02)
    return (folder / "url").read_text()


class Client:
    """A viewer that stores all messages, and acknowledges pictures."""

    def __init__(self, socket: Any) -> None:
        self.socket = socket
        self.state: dict[str, Any] = {}
        self.pictures: list[tuple[int, int, int, int, int]] = []  # number, frame, orders, kind, bytes
        self.refusals: list[str] = []
        self.board: dict[str, Any] = {}
        self.last = b""
        self.acknowledges = True
        self._news = asyncio.Condition()

    @classmethod
    @contextlib.asynccontextmanager
    async def of(cls, url: str, **options: Any) -> Any:
        """Connect, and read in the background."""
        async with connect(address(url), max_size=None, **options) as socket:
            client = cls(socket)
            reading = asyncio.create_task(client._read())
            try:
                yield client
            finally:
                reading.cancel()
                with contextlib.suppress(asyncio.CancelledError):
                    await reading

    async def say(self, **order: Any) -> None:
        """Send an order."""
        await self.socket.send(json.dumps(order))

    async def until(self, true: Callable[[], bool], seconds: float = 20) -> None:
        """Wait until a condition on the received messages is true."""
        async with self._news:
            try:
                await asyncio.wait_for(self._news.wait_for(true), seconds)
            except TimeoutError:
                raise AssertionError(f"not within {seconds} s: {self.state}, {self.pictures[-3:]}") from None

    async def _read(self) -> None:
        with contextlib.suppress(websockets.exceptions.ConnectionClosed):
            async for message in self.socket:
                async with self._news:
                    self._take(message)
                    self._news.notify_all()
                if isinstance(message, bytes) and self.acknowledges:
                    # Closed, but there may be more to read.
                    with contextlib.suppress(websockets.exceptions.ConnectionClosed):
                        await self.say(ack=self.pictures[-1][0])
        async with self._news:
            self.state["closed"] = True
            self._news.notify_all()

    def _take(self, message: str | bytes) -> None:
        if isinstance(message, bytes):
            magic, *head = HEAD.unpack_from(message)
            assert magic == b"mote"
            self.last = message[HEAD.size :]
            self.pictures.append((*head, len(self.last)))
            return
        said = json.loads(message)
        if "refused" in said:
            self.refusals.append(said["refused"])
        elif "board" in said:
            self.board = said["board"]
        else:
            self.state = said


class Beside:
    """Runs viewers in a thread while a job runs, and re-raises their errors."""

    def __init__(self, play: Callable[[], Awaitable[None]]) -> None:
        self._failure: BaseException | None = None
        self._play = play
        self._thread = threading.Thread(target=self._run, daemon=True)

    def _run(self) -> None:
        try:
            asyncio.run(self._play())
        except BaseException as error:
            self._failure = error

    def check(self, _: int) -> None:
        """End the job if the viewers have failed; the job calls this as its `watch`."""
        if self._failure is not None:
            raise self._failure

    def __enter__(self) -> Beside:
        self._thread.start()
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        self._thread.join(1 if kind else 30)
        if self._failure is not None and kind is None:
            raise self._failure
        assert not self._thread.is_alive(), "viewers do not come to an end"
