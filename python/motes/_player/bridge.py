"""Connects a run's live server to the notebook that shows the run: a viewer in a background thread.

Messages to a notebook's page go through the kernel, which may be busy with a cell for minutes, and whose
server stores what no page fetches. So pictures wait for the page, and a silent page gets fewer and fewer.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import struct
import threading
import time
from collections.abc import Callable
from typing import Any

from .._live import client
from .._live.viewer import MOST_BYTES
from .plays import Face

__all__ = ["Bridge", "Flow"]

CLOSE_S = 3.0
STATE_S = 0.1  # between two messages about the run's state
SLOW_STATE_S = 1.0  # between them when the page does not answer
_NUMBER = struct.Struct("<4sI")


class Flow:
    """Decides when the next picture may be sent to a page."""

    MOST_IN_FLIGHT = 2
    PATIENCE_S, GROWTH, LONGEST_S = 0.5, 1.2, 10.0
    MOST_BYTES = 64_000_000

    def __init__(self) -> None:
        """Start without a page."""
        self.watched = False
        self._flying: dict[int, int] = {}  # number of a picture -> bytes
        self._last_s = 0.0

    @property
    def answers(self) -> bool:
        """Whether the page acknowledges pictures as fast as they are sent."""
        return self.watched and len(self._flying) <= self.MOST_IN_FLIGHT

    def sent(self, number: int, size: int, now_s: float) -> None:
        """Note that a picture was sent."""
        self._flying[number] = size
        self._last_s = now_s

    def seen(self, number: int) -> None:
        """Note that a picture, and so all before it, has arrived."""
        self._flying = {one: size for one, size in self._flying.items() if one > number}

    def wait_s(self, now_s: float) -> float | None:
        """Return the seconds until the next picture may be sent; None: not before the page answers."""
        if not self.watched or sum(self._flying.values()) > self.MOST_BYTES:
            return None
        more = len(self._flying) - self.MOST_IN_FLIGHT
        if more < 0:
            return 0.0
        return max(0.0, self._last_s + min(self.PATIENCE_S * self.GROWTH**more, self.LONGEST_S) - now_s)


class Bridge:
    """A viewer of one live server after another: passes pictures and states to a face, and orders back."""

    def __init__(self, face: Face, *, joined: Callable[[], object] = lambda: None) -> None:
        """Start the thread; `joined` is called in it when a server has accepted the connection."""
        self._face = face
        self._joined = joined
        self._flow = Flow()
        self._socket: Any = None
        self._waiting: bytes | None = None  # the newest picture that has not been passed on
        self._unanswered: list[int] = []  # pictures not acknowledged to the server yet
        self._last: bytes | None = None  # the picture that was passed on last
        self._state: dict[str, Any] | None = None
        self._told_s = 0.0
        self._timers: dict[str, asyncio.TimerHandle] = {}
        self._tasks: set[asyncio.Task[None]] = set()
        self._loop = asyncio.new_event_loop()
        client.load()
        self._thread = threading.Thread(target=self._run, name="motes-notebook", daemon=True)
        self._thread.start()

    # --- what any thread may call

    def join(self, url: str) -> None:
        """View the run at this address from now on."""
        self._call(lambda: self._begin(self._attend(url)))

    def say(self, order: dict[str, Any]) -> None:
        """Send an order, unless it is too long or not JSON."""
        with contextlib.suppress(TypeError, ValueError):
            text = json.dumps(order)
            if len(text) <= MOST_BYTES:
                self._call(lambda: self._begin(self._send(text)))

    def looks(self) -> None:
        """Note that a page has opened, which has no picture yet."""
        self._call(self._look)

    def seen(self, number: Any) -> None:
        """Note that the page has shown a picture."""
        if type(number) is int:
            self._call(lambda: self._answered(number))

    def close(self) -> None:
        """Pass on the closing server's last messages, and end the thread."""
        self._call(lambda: self._begin(self._end()))
        if threading.current_thread() is not self._thread:
            self._thread.join(CLOSE_S + 1)

    def _call(self, function: Callable[[], object]) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(function)

    # --- the thread

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_forever()
        finally:
            self._loop.close()

    def _begin(self, work: Any) -> None:
        task = self._loop.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _end(self) -> None:
        others = self._tasks - {asyncio.current_task(self._loop)}
        if others:  # wait for the server's last messages
            await asyncio.wait(others, timeout=CLOSE_S)
        for task in others:
            task.cancel()
        await asyncio.gather(*others, return_exceptions=True)
        self._tell_state()
        self._loop.stop()

    async def _attend(self, url: str) -> None:
        with contextlib.suppress(OSError, client.closed()):
            async with client.connect(url) as socket:
                self._socket = socket
                self._unanswered.clear()
                self._joined()
                async for message in socket:
                    self._hear(message)
        self._pass_on(at_once=True)

    async def _send(self, text: str) -> None:
        if self._socket is not None:
            with contextlib.suppress(client.closed()):
                await self._socket.send(text)

    def _hear(self, message: str | bytes) -> None:
        if isinstance(message, bytes):
            self._unanswered.append(_number(message))
            self._waiting = message
            self._pass_on()
            return
        content = json.loads(message)
        if "refused" in content:
            self._face.hear(content)
            return
        self._state = content
        now_s = time.monotonic()
        pause_s = STATE_S if self._flow.answers else SLOW_STATE_S
        self._later("state", self._told_s + pause_s - now_s, self._tell_state)

    def _tell_state(self) -> None:
        state, self._state = self._state, None
        if state is not None:
            self._told_s = time.monotonic()
            self._face.hear(state)

    def _answered(self, number: int) -> None:
        self._flow.seen(number)
        self._pass_on()

    def _look(self) -> None:
        """Give a new page the last picture."""
        if not self._flow.watched or self._waiting is None:
            self._waiting = self._waiting or self._last
        self._flow.watched = True
        self._pass_on(at_once=True)

    def _pass_on(self, *, at_once: bool = False) -> None:
        """Pass on the newest picture if it is due, and acknowledge it so that the server sends another."""
        if self._waiting is None or not self._flow.watched:
            return
        now_s = time.monotonic()
        wait_s = 0.0 if at_once else self._flow.wait_s(now_s)
        if wait_s is None:
            return
        if wait_s > 0:
            self._later("picture", wait_s, self._pass_on)
            return
        picture, self._waiting, self._last = self._waiting, None, self._waiting
        self._flow.sent(_number(picture), len(picture), now_s)
        self._face.show(picture)
        numbers, self._unanswered = self._unanswered, []
        for number in numbers:
            self._begin(self._send(json.dumps({"ack": number})))

    def _later(self, name: str, seconds: float, function: Callable[[], object]) -> None:
        """Call a function after a delay; requests of the same name meanwhile are ignored."""
        if name not in self._timers:

            def call() -> None:
                del self._timers[name]
                function()

            self._timers[name] = self._loop.call_later(max(0.0, seconds), call)


def _number(picture: bytes) -> int:
    return int(_NUMBER.unpack_from(picture)[1])
