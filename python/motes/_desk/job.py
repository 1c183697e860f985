"""A job that the desk starts: `motes run` as a child process, its output, and the socket to its run."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import re
import signal
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from .._io.output import write_all
from .._launch.supervisor import start_of_child
from .._live import client

__all__ = ["Job", "Listener"]

MOST_LINES = 400  # of output, kept
MOST_WORDS = 12  # lines of the output that tell why a job has failed
MOST_LINE = 1 << 20  # bytes of a line
PATIENCE_S = 10.0  # for a run to end its frame before it is told to end again, as by a second Ctrl-C
GRACE_S = 5.0
_LIVE = re.compile(rb"motes: live at (\S+)")


class Listener(Protocol):
    """Who hears of a job."""

    def joined(self, job: Job) -> None:
        """Note that a run of the job has begun and is connected."""

    def said(self, job: Job, message: dict[str, Any]) -> None:
        """Hear a state, a row or a refusal."""

    def shown(self, job: Job, picture: bytes) -> None:
        """Take a picture: see `_live.pictures.Encoded`."""

    def printed(self, job: Job) -> None:
        """Note that the job has printed a line."""


class Job:
    """One start of the script."""

    def __init__(self, argv: Sequence[str], variables: Mapping[str, str], listener: Listener) -> None:
        """Take the command, the environment variables that it gets in addition, and who hears of it."""
        self._argv = argv
        self._variables = variables
        self._listener = listener
        self._process: asyncio.subprocess.Process | None = None
        self._readers: list[asyncio.Task[None]] = []
        self._link: asyncio.Task[None] | None = None
        self._out: asyncio.Queue[str] | None = None  # orders for the run; None: not connected
        self._url = ""
        self._wanted = False  # whether the desk wants to be connected
        self.lines: deque[str] = deque(maxlen=MOST_LINES)
        """The last lines of its output."""
        self.code: int | None = None
        """Its exit code; None: it has not ended."""
        self.stopping = False
        """Whether it was told to end."""

    async def run(self, *, echo: bool = True) -> int:
        """Run the job to its end and return its exit code; `echo`: print what it prints."""
        self._process = await asyncio.create_subprocess_exec(
            *self._argv,
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
            env={**os.environ, "PYTHONUNBUFFERED": "1", **self._variables},
            start_new_session=True,  # the desk passes a terminal's signals on
            preexec_fn=start_of_child(()),
            limit=MOST_LINE,
        )
        for pipe, to in ((self._process.stdout, 1), (self._process.stderr, 2)):
            self._readers.append(asyncio.create_task(self._read(pipe, to if echo else None)))
        code = await self._process.wait()
        with contextlib.suppress(TimeoutError):  # a child of the script may hold the pipe open
            await asyncio.wait_for(asyncio.gather(*self._readers), 1.0)
        await self.disconnect()
        self.code = code if code >= 0 else 128 - code
        return self.code

    @property
    def last_words(self) -> list[str]:
        """The last lines of its output that say something."""
        return [line for line in self.lines if line.strip()][-MOST_WORDS:]

    def signal(self, number: int) -> None:
        """Send the job a signal."""
        if self._process is not None and self._process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                self._process.send_signal(number)

    async def end(self) -> None:
        """End the job: after its frame if it answers, else as a second Ctrl-C would."""
        self.stopping = True
        if self.connected:
            self.say({"stay": False})
            self.say({"stop": True})
            if await self._ended(PATIENCE_S):
                return
        for number in (signal.SIGTERM, signal.SIGTERM, signal.SIGKILL):
            self.signal(number)
            if await self._ended(GRACE_S):
                return

    async def _ended(self, seconds: float) -> bool:
        limit = asyncio.get_running_loop().time() + seconds
        while self.code is None and asyncio.get_running_loop().time() < limit:
            await asyncio.sleep(0.02)
        return self.code is not None

    # --- the output

    async def _read(self, pipe: asyncio.StreamReader | None, to: int | None) -> None:
        assert pipe is not None
        while True:
            try:
                line = await pipe.readline()
            except ValueError:  # a line without end
                continue
            if not line:
                return
            if live := _LIVE.search(line):
                self._url = live[1].decode()
                self._connect()
                continue
            if to is not None:
                with contextlib.suppress(OSError):  # a full disk, or nobody reads
                    write_all(to, line)
            self.lines.append(line.decode(errors="replace").rstrip("\r\n"))
            self._listener.printed(self)

    # --- the socket

    @property
    def connected(self) -> bool:
        """Whether the run hears what is said."""
        return self._out is not None

    def connect(self) -> None:
        """Connect to the run as soon as there is one, and to the next ones."""
        self._wanted = True
        self._connect()

    async def disconnect(self) -> None:
        """Leave the run alone."""
        self._wanted = False
        if self._link is not None:
            if self.connected:  # its last messages
                self._link.cancel()
            with contextlib.suppress(asyncio.CancelledError, TimeoutError):
                await asyncio.wait_for(self._link, GRACE_S)

    def say(self, order: Mapping[str, Any]) -> None:
        """Send an order."""
        if self._out is not None:
            self._out.put_nowait(json.dumps(order))

    def _connect(self) -> None:
        if self._wanted and self._url and (self._link is None or self._link.done()):
            self._link = asyncio.create_task(self._attend())

    async def _attend(self) -> None:
        url = self._url
        try:
            async with client.connect(url, "&all=1") as socket:
                self._out = asyncio.Queue()
                self.say({"stay": True})
                self._listener.joined(self)
                await self._converse(socket, self._out)
        except (OSError, client.closed()):
            pass
        finally:
            self._out = None
        if self._url != url:  # the script's next world, or the same one on other ranks
            asyncio.get_running_loop().call_soon(self._connect)

    async def _converse(self, socket: Any, out: asyncio.Queue[str]) -> None:
        async def send() -> None:
            while True:
                await socket.send(await out.get())

        sending = asyncio.create_task(send())
        try:
            async for message in socket:
                if isinstance(message, bytes):
                    self._listener.shown(self, message)
                else:
                    self._listener.said(self, json.loads(message))
        finally:
            sending.cancel()
            await asyncio.gather(sending, return_exceptions=True)
