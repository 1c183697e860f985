"""The server of a live run: page and socket on one port, in a thread of the image generator's process.

Nothing here can hold up the run, which only hands over its newest picture. Each viewer has at most two
unacknowledged pictures; of the pictures made meanwhile it gets only the latest.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from .._io.output import tell
from .._values.live import Live
from ..errors import MotesError
from .orders import Orders
from .pictures import Encoded, Picture, jpeg, lossless
from .site import Site
from .viewer import Viewer

__all__ = ["Server"]

START_S = 20.0
CLOSE_S = 4.0  # for viewers that do not read; others get the last message at once
STILL_S = 0.25  # a paused run's picture follows without loss after this time
STILL_RUNNING_S = 2.0  # a running one's picture does if no newer one has come for this long
MOST_QUEUED = 4  # pictures on their way to a viewer that keeps all
PATIENCE_S = 0.2  # longest that a frame waits for room among them


class Server(Site):
    """Serves a run to viewers until `close`."""

    def __init__(self, live: Live, orders: Orders, about: dict[str, Any]) -> None:
        """Start the thread. Raises MotesError if there is no free port or no such address.

        `about` is the constant part of the state: title, width, height, the file that is repeated.
        """
        super().__init__(live, about)
        self._orders = orders
        self._newest: Picture | None = None
        self._queue: deque[Picture] = deque()  # for viewers that keep all pictures
        self._room = threading.Condition()
        self._keepers = 0
        self._encoded: Encoded | None = None
        self._count = 0
        self._changed_s = 0.0
        self._waits = live.wait
        self._encoder = ThreadPoolExecutor(1, "motes-live-encoder")
        self._ready = threading.Event()
        _extras.websockets("asyncio.server")  # here: a library may not begin in two threads at once
        _extras.simplejpeg()
        self._thread = threading.Thread(target=self._run, name="motes-live", daemon=True)
        self._thread.start()
        self._ready.wait(START_S)
        if self.port == 0:
            raise MotesError(f"the live view cannot be served: {self._failure or 'its server did not start'}")

    # --- what the run calls

    def show(self, pixels: NDArray[np.uint8], *, frame: int, orders: int) -> None:
        """Leave a picture for the viewers; wait a moment only for one that keeps all pictures."""
        self._count += 1
        picture = Picture(self._count, frame, orders, pixels)
        if self._keepers:
            with self._room:
                self._room.wait_for(lambda: len(self._queue) < MOST_QUEUED, PATIENCE_S)
                if len(self._queue) < MOST_QUEUED:
                    self._queue.append(picture)
        self._newest = picture
        self._changed_s = time.monotonic()
        if self._viewers:  # a new one wakes the thread itself
            self._call(self._fresh.set)

    def note(self, note: Mapping[str, Any]) -> None:
        """Send a note to the viewers that keep everything, in order."""
        if self._keepers:
            text = json.dumps(note)
            self._call(lambda: self._note(text))

    def refuse(self, why: str) -> None:
        """Tell all viewers why an order is not obeyed."""
        text = json.dumps({"refused": why})
        self._call(lambda: self._note(text, everyone=True))

    def _note(self, text: str, *, everyone: bool = False) -> None:
        for viewer in self._viewers:
            if everyone or viewer.keeps:
                viewer.note(text)

    def tell(self, state: dict[str, Any]) -> None:
        """Send the run's state to all viewers if it has changed, and return at once."""
        if state != self._state:
            self._state = state
            if self._viewers and not self._tells_soon:
                self._tells_soon = True
                self._call(self._tell_soon)

    def close(self) -> None:
        """Tell viewers that the run has ended, and end the thread."""
        self._call(self._closing.set)
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
        self._ready.set()
        encoding = asyncio.create_task(self._encode_on())
        await self._closing.wait()
        encoding.cancel()
        self._state = {**self._state, "ended": True}
        await self._offer_last()
        self._tell_all()
        await self._close(server, CLOSE_S / 2)

    def _viewer(self, connection: Any, query: Mapping[str, list[str]]) -> Viewer:
        viewer = Viewer(connection, self._orders, self._fresh.set, keeps=query.get("all") == ["1"])
        if self._encoded is not None:
            viewer.offer(self._encoded)
        return viewer

    def _came(self, viewer: Viewer) -> None:
        self._keepers += viewer.keeps
        self._orders.joined() if self._waits else self._orders.wake()
        self._waits = False

    def _left(self, viewer: Viewer) -> None:
        if viewer.keeps:
            self._keepers -= 1
            self._orders.left()

    def _tell_all(self) -> None:
        super()._tell_all()
        self._fresh.set()

    async def _encode_on(self) -> None:
        try:
            await self._encode()
        except Exception as error:  # any: the run continues without pictures, and somebody should know why
            tell(f"motes: viewers get no more pictures: {type(error).__name__}: {error}")

    async def _encode(self) -> None:
        """Encode pictures that a viewer keeps, and the newest one whenever a viewer can take it."""
        pause = 1.0 / self._live.max_fps
        while True:
            self._fresh.clear()
            while self._queue:
                await self._encode_kept(self._queue[0])
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

    async def _encode_kept(self, picture: Picture) -> None:
        self._encoded = await self._in_thread(jpeg, picture, self._live.quality)
        with self._room:
            self._queue.popleft()
            self._room.notify_all()
        for viewer in self._viewers:
            viewer.keep(self._encoded)

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
