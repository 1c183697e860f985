"""Another number of ranks, or other hosts, in the middle of a run: what a request is, and how it is answered.

`motes resize` finds the launcher in the run's log (run.json), writes a request into its folder and sends it
SIGUSR2. The launcher checks the request, answers, and asks the ranks to stop after their frame, as SIGUSR1
does: they write a checkpoint. Then it starts the same command with other ranks, which continue from there.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from .._io import files
from .._io.output import tell
from .._run import open_worlds
from .._run.peers import Peer, lives
from ..errors import ArgumentError, MotesError

__all__ = ["LAUNCHER", "Resizing", "Size", "ask", "request"]

LAUNCHER = "MOTES_LAUNCHER"
"""Environment variable of ranks: `Resizing.address` of their launcher."""
STOPPED = 143
"""The exit code of ranks that stop because they are asked to."""
_REQUEST, _ANSWER = "resize.json", "resized.json"
_WAIT_S = 30.0  # for the launcher's answer, and for a run that is just starting
_AGAIN_S = 0.5  # after which a signal is repeated
_LATE_S = 2.0  # within which a signal may still belong to a request that was answered
_BUSY = "no rank is inside `with world:`: the run is just starting, or ending"
_HOW = "the number of ranks changes only under `motes run`"


class Size(NamedTuple):
    """With how many ranks a job runs, and where."""

    ranks: int
    hosts: str | None = None

    def __str__(self) -> str:
        """Return "3 ranks", and the hosts."""
        ranks = "1 rank" if self.ranks == 1 else f"{self.ranks} ranks"
        return ranks if self.hosts is None else f"{ranks} on {self.hosts}"


class Resizing:
    """The launcher's side: a request, from SIGUSR2 until the job has ended."""

    def __init__(self, folder: str, size: Size, check: Callable[[Size], object]) -> None:
        """Begin with a size.

        `folder`: where requests come, the same as long as this process lives; `check` raises MotesError for a
        size that the launcher cannot start.
        """
        self.size = size
        self.wanted: Size | None = None
        """The next size, once the ranks have been asked to stop for it."""
        self._folder = Path(folder)
        self._check = check
        self._answered_s = -_LATE_S

    @property
    def address(self) -> str:
        """Where `request` finds this process, for its ranks."""
        here = Peer.here(rank=0, role="")
        return json.dumps([here.host, here.pid, here.started, here.space, os.fspath(self._folder)])

    def ask(self, worlds: str) -> None:
        """Obey a request; `worlds`: where the job's ranks note that they are in a world.

        A signal without a request restarts the job as it is, on the hosts that there are now.
        """
        has = open_worlds.keeps_checkpoints(worlds)
        starts = self.wanted is not None or has is None or not open_worlds.left_open(worlds)
        wanted = self._requested()
        if wanted is None:
            if starts or time.monotonic() - self._answered_s < _LATE_S:  # a second signal of a request
                return
            wanted = self.size
        if starts:
            return self._answer(_BUSY)
        try:
            if not has:
                raise MotesError(
                    "the run has no checkpoints to go on from: give its world World(checkpoint=...), and "
                    "start it again"
                )
            self._check(wanted)
        except MotesError as error:
            self._answer(str(error))
            return tell(f"motes run: it goes on with {self.size}: {error}")
        if not open_worlds.send(worlds, signal.SIGUSR1):
            return self._answer(_BUSY)
        self.wanted = wanted
        self._answer("")
        tell(f"motes run: goes on with {wanted} when this frame is done")

    def _requested(self) -> Size | None:
        path = self._folder / _REQUEST
        try:
            ranks, hosts = json.loads(path.read_bytes())
            path.unlink()
        except FileNotFoundError:
            return None
        return Size(ranks, self.size.hosts if hosts is None else hosts)

    def _answer(self, problem: str) -> None:
        self._answered_s = time.monotonic()
        with contextlib.suppress(OSError):
            files.write_whole(self._folder / _ANSWER, json.dumps(problem).encode())

    def take(self, code: int) -> bool:
        """Return whether a job that ended with this code starts again with the size that was wanted."""
        wanted, self.wanted = self.wanted, None
        if wanted is None or code != STOPPED:
            return False
        self.size = wanted
        return True


def request(run: Path, size: Size) -> None:
    """Ask the launcher of a run for another size; `run`: the directory of its log.

    Raises MotesError if the run has no launcher that could change it, or if that refuses.
    """
    ask(_launcher_of(run), size, os.fspath(run))


def ask(address: str, size: Size, run: str) -> None:
    """Ask the launcher at an address (`Resizing.address`) for another size; `run` is named in messages.

    Raises MotesError if it runs on another host, has ended, or refuses.
    """
    host, pid, started, space, folder = json.loads(address)
    here = Peer.here(rank=0, role="")
    if space != here.space:
        raise MotesError(f"the launcher of {run} runs on {host}: call `motes resize` there")
    if not lives(here._replace(pid=pid, started=started)):
        raise MotesError(f"{run} has ended: start it again with the number of ranks that you want")
    launcher = here._replace(pid=pid, started=started)
    deadline = time.monotonic() + _WAIT_S
    while (problem := _ask(launcher, Path(folder), size)) == _BUSY and time.monotonic() < deadline:
        time.sleep(0.2)
    if problem:
        raise MotesError(f"{run}: {problem}")


def _ask(launcher: Peer, folder: Path, size: Size) -> str:
    """Send a request to a launcher; return what prevents it, or ""."""
    answer = folder / _ANSWER
    answer.unlink(missing_ok=True)
    files.write_whole(folder / _REQUEST, json.dumps(size).encode())
    start = asked = time.monotonic()
    os.kill(launcher.pid, signal.SIGUSR2)
    while not answer.exists():
        now = time.monotonic()
        if not lives(launcher):
            return "the run has ended"
        if now - start > _WAIT_S:
            return "its launcher does not answer"
        if now - asked > _AGAIN_S and (folder / _REQUEST).exists():  # it was between two starts of the job
            os.kill(launcher.pid, signal.SIGUSR2)
            asked = now
        time.sleep(0.02)
    problem: str = json.loads(answer.read_bytes())
    return problem


def _launcher_of(run: Path) -> str:
    try:
        facts = json.loads((run / "run.json").read_bytes())
        launcher = [facts, *facts.get("continued", [])][-1].get("launcher")
    except FileNotFoundError:
        raise ArgumentError("RUN", os.fspath(run), "the directory of a run's log, World(log=...)") from None
    except (OSError, ValueError, AttributeError) as error:
        raise MotesError(f"{run}/run.json cannot be read: {error}") from None
    if not launcher:
        raise MotesError(
            f"{run} was started without a launcher of motes: {_HOW} (a single rank needs --restarts 1). "
            "SIGTERM ends it with a checkpoint, if it has World(checkpoint=...); the same script continues "
            "with any number of ranks"
        )
    return str(launcher)
