"""The desk: serves the page of `motes live`, starts the runs that it shows, and keeps their pictures.

A run is a job of its own (`job.py`), to which the desk is connected only while a page is open. Then the desk
gets every picture, and the run waits at its end until its viewers have seen enough.
"""

from __future__ import annotations

import asyncio
import json
import signal
import struct
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from .. import _extras
from .._io.output import tell
from .._live import access
from .._live.pictures import MAGIC, Encoded
from .._live.site import Site
from .._live.viewer import Viewer
from .._values.live import Live
from ..errors import MotesError
from .board import Board
from .film import Film, Shot
from .job import Job
from .script import Script

__all__ = ["Desk", "Start"]

SHOWN_LINES = 40  # of output
LEAVE_S = 5.0  # from the last page's end until the run is left alone; a reloaded page comes back sooner
CLOSE_S = 2.0  # for viewers that do not read
OFFER_S = 1 / 60  # between two pictures for a page
BOARD_S = 0.4  # between two looks at the log
ROWS = 100  # in one order: it must fit into a viewer's message
_HEADER = struct.Struct("<4sIIII")
_FROM_FILM = 2  # kind of picture: from the film
_TO_RUN = (
    "orbit",
    "pan",
    "zoom",
    "camera",
    "set",
    "pause",
    "step",
    "pace",
    "stop",
    "balancer",
    "speeds",
    "resize",
)


class Start(NamedTuple):
    """How the desk starts jobs."""

    argv: Sequence[str]
    """The command of a job."""
    script: Path | None
    """The script that is watched; None: the program is a module or a piece of code."""
    arguments: Sequence[str]
    """The script's arguments."""
    live: Live
    """Where the page is served, and whether the first run waits or starts paused."""
    budget: int
    """The most bytes of pictures to keep."""
    reload: bool
    """Whether a saved script is reloaded, until a page says otherwise."""


class Hand:
    """Takes what one viewer says."""

    viewer: Viewer

    def __init__(self, desk: Desk) -> None:
        """Take the desk."""
        self._desk = desk

    def put(self, order: Any) -> None:
        """Obey. Raises ValueError, which says why, for an invalid order."""
        self._desk.obey(self.viewer, order)


class Desk(Site):
    """The page, its viewers, and the job that they see."""

    def __init__(self, start: Start) -> None:
        """Take how jobs start."""
        title = start.script.name if start.script is not None else "motes"
        super().__init__(start.live, {"title": title, "desk": True})
        self._start = start
        self._film = Film(start.budget)
        self._script = None if start.script is None else Script(start.script, start.arguments)
        self._job: Job | None = None
        self._take = 0
        self._newest: Encoded | None = None
        self._ranks: int | None = None  # of the run that was seen last
        self._count = 0  # of pictures, over all runs
        self._counted = (0, 0)  # the take and the number of the last one
        self._told: dict[str, Any] = {}  # the run's last state
        self._facts: dict[str, Any] = {"reloads": start.reload, "error": None, "notice": None}
        self._rows: list[dict[str, Any]] = []  # what has changed in this take, as in steer.jsonl
        self._first: list[dict[str, Any]] = []  # orders for a new run
        self._pending: list[dict[str, Any]] = []
        self._goal: int | None = None  # the frame that a new run has not reached yet
        self._restarting = False
        self._looked_at = False  # whether a page was ever open
        self._empty_since = 0.0
        self._offered_s = 0.0
        self._offers_soon = False
        self._boards: set[Viewer] = set()  # viewers who see the blackboard
        self._board: Board | None = None
        self._tasks: set[asyncio.Task[Any]] = set()
        self._goals: list[dict[str, Any]] = []  # what brings a run to its goal
        self._code = 0
        self._signal = 0

    async def serve(self) -> int:
        """Serve until the user or the last run ends it; return the exit code."""
        _extras.simplejpeg()
        self._loop = asyncio.get_running_loop()
        self._over = asyncio.Event()
        server = await self._bind()
        if server is None:
            raise MotesError(f"the live view cannot be served: {self._failure}")
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1):
            self._loop.add_signal_handler(number, self._signalled, number)
        tell(f"motes: live at {self.url}  ({access.from_afar(self._live.host, self.port)})")
        options = [word for word in ("wait", "paused") if getattr(self._live, word)]
        self._begin([], ",".join(["0", *options]))
        if self._script is not None:
            self._do(self._watch(self._script))
        await self._over.wait()
        self._facts["ended"] = True
        self._tell_all()
        for task in self._tasks:
            task.cancel()
        await self._close(server, CLOSE_S)
        return self._code

    # --- jobs

    def _begin(
        self,
        first: list[dict[str, Any]],
        live: str = "0,wait,paused",
        *,
        script: Path | None = None,
        goal: int = 1,
    ) -> None:
        """Start a job, which hears the orders `first`, and is good once it has reached the frame `goal`.

        `script`: the file to run in place of the script.
        """
        self._take += 1
        self._rows, self._told, self._first, self._goal = [], {"finished": False}, first, goal
        argv, variables = list(self._start.argv), {"MOTES_LIVE": live}
        if self._ranks is not None:
            argv[argv.index("--ranks") + 1] = str(self._ranks)
        if self._script is not None:
            place = len(argv) - 1 - len(self._start.arguments)
            argv[place] = str(script or self._script.starts())
        if self._take > 1:
            variables |= {"MOTES_FRESH": "1", "MOTES_ANYWAY": "1"}
        self._job = Job(argv, variables, self)
        self._facts |= {"job": "starting", "take": self._take, "notice": "the run is starting ..."}
        self._do(self._play(self._job))
        if self._viewers:
            self._job.connect()
        self._changed()

    async def _play(self, job: Job) -> None:
        """Run a job to its end, and decide what follows."""
        try:
            code = await job.run()
        except OSError as error:
            code = 1
            job.code = code
            job.lines.append(f"the run cannot be started: {error}")
        if self._job is not job:
            return
        if self._script is not None:
            self._script.forget()
        self._code = code
        failed = code != 0 and not job.stopping and not self._signal
        self._facts |= {"job": "failed" if failed else "ended", "notice": None}
        if failed:
            self._facts["error"] = "\n".join([f"the run has failed with exit code {code}", *job.last_words])
        self._changed()
        if self._restarting or (failed and self._goal is not None and self._go_back()):
            return
        if self._signal or not (self._looked_at or (code == 0 and _at_a_terminal())):
            self._over.set()
            return
        tell(f"motes: the run has {'failed' if failed else 'ended'}; its page stays until Ctrl-C: {self.url}")

    def _go_back(self) -> bool:
        """Start the last good script in place of one that failed on its way; return whether there is one."""
        good = None if self._script is None else self._script.starts_good()
        if good is None:
            return False
        self._facts["error"] += "\nThe last good script goes on."
        self._begin(self._goals, script=good, goal=self._goal or 1)
        return True

    async def _restart(self, first: list[dict[str, Any]], notice: str, goal: int = 1) -> None:
        """End the job and start another, which begins with these orders."""
        assert self._job is not None
        self._restarting = True
        self._facts |= {"notice": notice, "error": None, "job": "starting"}
        self._changed()
        try:
            await self._job.end()
        finally:
            self._restarting = False
        if self._signal:
            self._over.set()
            return
        self._goals = first
        self._begin(first, goal=goal)

    def _values(self) -> list[dict[str, Any]]:
        """Return the orders that give a new run the values of the controls, and the camera, of now."""
        state = self._state
        orders = [{"set": {name: control["value"]}} for name, control in state.get("controls", {}).items()]
        if state.get("turned") and state.get("camera"):
            orders.append({"camera": state["camera"]})
        for row in self._rows:
            orders += [{name: row[name]} for name in ("balancer", "speeds") if name in row]
        return [] if state.get("repeats") else orders

    def _on(self) -> list[dict[str, Any]]:
        return [{"pause": bool(self._state.get("paused"))}]

    def _again(self, to: int) -> list[dict[str, Any]]:
        """Return the orders that bring a new run to where this one is."""
        rows = [] if self._state.get("repeats") else self._rows
        parts = [rows[i : i + ROWS] for i in range(0, len(rows), ROWS)] or [[]]
        goal = {"to": to, "paused": bool(self._state.get("paused"))}
        return [{"again": {"rows": part, **goal}} for part in parts]

    async def _reload(self, script: Script) -> None:
        """Start the saved script at the same frame, if it passes a rehearsal."""
        self._facts |= {"notice": f"{script.path.name} was saved: trying it ..."}
        self._changed()
        problem = await script.rehearse()
        self._facts["notice"] = None
        if problem:
            self._facts["error"] = problem
            self._changed()
            return
        to, way, goal = int(self._state.get("frame") or 0), [], self._goal or 0
        if goal > max(to, 1):  # on its way: it has heard of some orders only
            to, way = goal, self._goals
        first = [*way, *self._again(to)]
        await self._restart(first, f"{script.path.name} was saved: starting it ...", max(to, 1))

    async def _watch(self, script: Script) -> None:
        """Reload the script whenever it is saved while a page is open."""
        while True:
            await script.saved()
            while self._restarting:
                await asyncio.sleep(0.1)
            if self._viewers and self._facts["reloads"] and not self._signal:
                await self._reload(script)

    def _signalled(self, number: int) -> None:
        """Pass a signal on to the job, which then ends, and with it the page."""
        self._signal = number
        if self._job is None or self._job.code is not None:
            self._over.set()
        else:
            self._job.signal(number)

    # --- what a job tells

    def joined(self, job: Job) -> None:
        """Give a new run its first orders."""
        first, self._first = self._first, []
        self._facts |= {"job": "running", "notice": None}
        self._pending = first
        self._changed()

    def said(self, job: Job, message: dict[str, Any]) -> None:
        """Take the run's state, or what it has changed, or its refusal of an order."""
        if job is not self._job:
            return
        if "row" in message:
            self._rows.append(message["row"])
            return
        if "refused" in message:
            for viewer in self._viewers:
                viewer.note(_text(message))
            return
        ready = "frame" in message
        self._told, self._ranks = message, message.get("ranks", self._ranks)
        if message.get("ended") and not message.get("finished"):
            self._facts["notice"] = "the run ends, or goes on with other ranks ..."
        if ready and self._goal is not None:
            self._approach(int(message["frame"]), self._goal)
        if ready and self._pending:
            first, self._pending = self._pending, []
            for order in first:
                job.say(order)
        self._changed()

    def _approach(self, frame: int, goal: int) -> None:
        """Show how far a new run is from its goal."""
        if frame < goal:
            self._facts["notice"] = f"on the way to frame {goal} ..." if goal > 1 else None
            return
        self._goal = self._facts["notice"] = None
        if self._script is not None:
            self._script.works()

    def shown(self, job: Job, picture: bytes) -> None:
        """Keep a picture, and offer it to the viewers."""
        if job is not self._job:
            return
        _, number, frame, _, kind = _HEADER.unpack_from(picture)
        if kind == 0:
            self._film.add(frame, Shot(self._take, picture[_HEADER.size :]))
        if (self._take, number) != self._counted:  # each run counts from 1; a picture may come twice
            self._counted = self._take, number
            self._count += 1
        head = _HEADER.pack(MAGIC, self._count, *_HEADER.unpack_from(picture)[2:])
        self._newest = Encoded(self._count, kind == 1, head + picture[_HEADER.size :])
        self._offer()

    def printed(self, job: Job) -> None:
        """Show the last lines."""
        if job is self._job:
            self._changed()

    # --- viewers

    def _viewer(self, connection: Any, query: Mapping[str, list[str]]) -> Viewer:
        hand = Hand(self)
        hand.viewer = Viewer(connection, hand, self._offer)
        if self._newest is not None:
            hand.viewer.offer(self._newest)
        return hand.viewer

    def _came(self, viewer: Viewer) -> None:
        self._looked_at = True
        if self._job is not None and self._job.code is None:
            self._job.connect()

    def _left(self, viewer: Viewer) -> None:
        self._boards.discard(viewer)
        if not self._viewers:
            self._empty_since = time.monotonic()
            self._loop.call_later(LEAVE_S, self._leave)

    def _leave(self) -> None:
        long_empty = not self._viewers and time.monotonic() - self._empty_since >= LEAVE_S - 0.1
        if long_empty and self._job is not None and self._job.connected:
            self._do(self._job.disconnect())

    def _offer(self) -> None:
        """Offer the newest picture to viewers who can take it, at most once per `OFFER_S`."""
        if not self._offers_soon:
            self._offers_soon = True
            self._loop.call_later(max(0.0, self._offered_s + OFFER_S - time.monotonic()), self._offer_now)

    def _offer_now(self) -> None:
        self._offers_soon, self._offered_s = False, time.monotonic()
        if (newest := self._newest) is not None:
            for viewer in self._viewers:
                viewer.keep(newest) if not newest.exact else viewer.offer(newest)

    def _changed(self) -> None:
        if not self._tells_soon:
            self._tells_soon = True
            self._tell_soon()

    def _tell_all(self) -> None:
        lines = [] if self._job is None else list(self._job.lines)[-SHOWN_LINES:]
        spans = {"spans": self._film.spans(), "kept": self._film.bytes}
        title = {"title": self._about["title"]}  # a run of the last good script has another name
        self._state = {**self._state, **self._told, **title, **self._facts, **spans, "output": lines}
        if self._facts["job"] in ("ended", "failed"):
            self._state["finished"] = True
        self._state["ended"] = bool(self._facts.get("ended"))
        super()._tell_all()

    # --- what viewers say

    def obey(self, viewer: Viewer, order: Any) -> None:
        """Obey a viewer. Raises ValueError, which says why, for an invalid order."""
        if not isinstance(order, dict) or len(order) != 1:
            raise ValueError("an order is an object with one name")
        (name, wish), *_ = order.items()
        if name == "seek":
            self._seek(viewer, wish)
        elif name == "restart" and wish is True:
            self._once(self._restart([*self._values(), *self._on()], "the run starts again ..."))
        elif name == "reload" and wish is True and self._script is not None:
            self._once(self._reload(self._script))
        elif name == "reloads" and isinstance(wish, bool):
            self._facts["reloads"] = wish
            self._changed()
        elif name == "board" and isinstance(wish, bool):
            self._show_board(viewer, wish)
        elif name == "dismiss" and wish is True:
            self._facts["error"] = None
            self._changed()
        elif name in _TO_RUN:
            self._to_run(name, order)
        else:
            raise ValueError(f"there is no order {str(name)[:100]!r} with this value")

    def _to_run(self, name: str, order: dict[str, Any]) -> None:
        if self._job is not None and self._job.connected:
            if name == "stop" and self._told.get("finished"):
                order = {"stay": False}
            self._job.say(order)
        elif name == "set":
            self._wish(order["set"])
        else:
            starting = self._facts["job"] == "starting"
            raise ValueError(
                "the run is just starting" if starting else "the run has ended; Restart begins it again"
            )

    def _wish(self, wishes: Any) -> None:
        """Note values for the next run; it checks them."""
        controls = self._state.get("controls", {})
        if not isinstance(wishes, dict) or set(wishes) - set(controls):
            raise ValueError("set takes an object that maps names of controls to values")
        self._told["controls"] = {
            name: {**one, "value": wishes.get(name, one["value"])} for name, one in controls.items()
        }
        self._changed()

    def _seek(self, viewer: Viewer, frame: Any) -> None:
        if type(frame) is not int or not 0 <= frame < 2**31:
            raise ValueError("seek takes the number of a frame")
        found = self._film.at(frame)
        if found is None:
            raise ValueError(
                f"frame {frame} has no picture yet: it was computed while no page was open, or never"
            )
        _, shot = found
        viewer.send(_HEADER.pack(MAGIC, shot.take, frame, 0, _FROM_FILM) + shot.data)

    def _show_board(self, viewer: Viewer, wish: bool) -> None:
        """Show a viewer the blackboard, or no longer. Somebody must look: else no log is read."""
        if not wish:
            self._boards.discard(viewer)
        elif viewer not in self._boards:
            self._boards.add(viewer)
            if len(self._boards) == 1:
                self._do(self._draw_boards())

    async def _draw_boards(self) -> None:
        """Read the run's log and tell those who look, until nobody does."""
        while self._boards:
            log, last = self._state.get("log"), self._facts["job"] in ("ended", "failed")
            if self._board is None or self._board.take != self._take or str(self._board.path) != log:
                self._board = None if log is None or self._job is None else Board(Path(log), self._take)
            told = {"missing": True} if self._board is None else await self._board.look(last=last)
            for viewer in self._boards:
                viewer.note(_text({"board": told}))
            await asyncio.sleep(BOARD_S)

    def _once(self, work: Any) -> None:
        """Do what must not be done twice at a time."""
        if self._restarting or self._facts["job"] == "starting":
            work.close()
            raise ValueError("the run is just starting")
        self._do(work)

    def _do(self, work: Any) -> None:
        task = self._loop.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._done)

    def _done(self, task: asyncio.Task[Any]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and (error := task.exception()) is not None:
            tell(f"motes: the desk: {type(error).__name__}: {error}")
            self._facts["error"] = f"{type(error).__name__}: {error}"
            self._changed()


def _at_a_terminal() -> bool:
    return sys.stdin is not None and sys.stdin.isatty()


def _text(message: Any) -> str:
    return json.dumps(message)
