"""Runs a script on many ranks as a child of the notebook's process."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from .._io.output import tell
from .._launch import starting
from .._launch.supervisor import start_of_child
from .._values import arguments as checks
from ..errors import ArgumentError, MotesError
from .bridge import Bridge
from .plays import NoFace, Play

__all__ = ["Job", "JobPlay", "checked"]

MOST_LINES = 1000  # of output, kept
SHOWN_LINES = 12  # below the picture, and in errors
SHOWN_EVERY_S = 0.2
INSIST_S = 1.0  # between two SIGTERMs: the first asks the ranks to stop, the second ends the launcher
_LIVE = re.compile(r"motes: live at (\S+)")


class Job(NamedTuple):
    """The arguments of `motes.launch`, checked."""

    script: str
    ranks: int
    arguments: tuple[str, ...]
    paused: bool


def checked(script: Any, n: Any, arguments: Any, paused: Any) -> Job:
    """Return the arguments of `motes.launch` as a job. Raises ArgumentError."""
    path = checks.file_path("script", script)
    if not path.is_file():
        raise ArgumentError("script", script, "the path of an existing script")
    ranks = checks.integer("n", n, low=1, high=starting.most_ranks())
    allowed = "a list of the script's command line arguments"
    if isinstance(arguments, (str, bytes)) or not isinstance(arguments, Sequence):
        raise ArgumentError("arguments", arguments, allowed)
    given = tuple(str(one) for one in arguments)
    return Job(os.fspath(path), ranks, given, checks.flag("paused", paused))


class JobPlay(Play):
    """A script on many ranks, started by `motes.launch`."""

    def __init__(self, job: Job) -> None:
        """Take the job."""
        super().__init__()
        self._job = job
        self.title = Path(job.script).name
        self._lines: deque[str] = deque(maxlen=MOST_LINES)
        self._asked = 0  # how often `stop` was called
        self._joined = False
        self._shown = threading.Event()

    def start(self) -> None:
        """Start the ranks. Raises OSError if that fails."""
        job = self._job
        argv = [sys.executable, "-m", "motes", "run", "-n", str(job.ranks), job.script, *job.arguments]
        # The first frame waits for a viewer, the bridge, so that it misses no picture.
        live = "0,wait,paused" if job.paused else "0,wait"
        starts = f"starting {job.ranks} rank{'s' * (job.ranks > 1)} ..."
        self.face.tell(notice=starts, stop="Stop", ended=False)
        self._bridge = Bridge(self.face, joined=self._let_in)
        self._process = subprocess.Popen(
            argv,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env={**os.environ, "MOTES_LIVE": live, "PYTHONUNBUFFERED": "1"},
            start_new_session=True,  # the ranks must not get signals to the kernel's group
            preexec_fn=start_of_child(),
        )
        threading.Thread(target=self._read, name="motes.launch", daemon=True).start()

    def output(self) -> list[str]:
        """Return the last lines that the ranks have printed."""
        return list(self._lines)

    def stop(self) -> None:
        """Ask the ranks to stop after a frame; the second time, or before they have begun, terminate them."""
        if self.wait(0):
            return
        self._asked += 1
        if self._asked == 1 and self._joined:
            self.face.tell(stop="End now")
            self._bridge.say({"stop": True})
        elif self._asked <= 2:
            self._asked = 2
            self.face.tell(stop="Ending ...", stopping=True)
            threading.Thread(target=self._terminate, name="motes.launch end", daemon=True).start()

    def order(self, order: dict[str, Any]) -> None:
        """Pass on a viewer's order."""
        self._bridge.say(order)

    def looks(self) -> None:
        """Note that a page has opened, which has no picture yet."""
        self._bridge.looks()

    def seen(self, number: Any) -> None:
        """Note that the page has shown a picture."""
        self._bridge.seen(number)

    def _let_in(self) -> None:
        self._joined = True
        self.face.tell(notice=None)

    def _read(self) -> None:
        """Read the output to its end, and record how the job ended; runs in a thread."""
        assert self._process.stdout is not None
        timer: threading.Timer | None = None
        with self._process.stdout as pipe:
            for line in pipe:
                self._take(line.decode(errors="replace").rstrip("\r\n"))
                if timer is None or not timer.is_alive():
                    timer = threading.Timer(SHOWN_EVERY_S, self._show_lines)
                    timer.daemon = True
                    timer.start()
        code = self._process.wait()
        if timer is not None:
            timer.join()
        self._bridge.close()
        self._show_lines()
        self._end_with(code)

    def _take(self, line: str) -> None:
        live = _LIVE.search(line)
        if live:
            self.url = live[1]
            self._bridge.join(live[1])
        else:  # the page's address has a token, which must not be saved with the notebook
            self._lines.append(line)
        if isinstance(self.face, NoFace):
            tell(line)

    def _show_lines(self) -> None:
        self.face.tell(output=list(self._lines)[-SHOWN_LINES:])

    def _end_with(self, code: int) -> None:
        if code == 0:
            self.end("stopped" if self._asked else "ended")
        elif self._asked >= 2:
            self.end("terminated")
        else:
            last = "\n".join(list(self._lines)[-SHOWN_LINES:])
            ending = f"{self.title} on {self._job.ranks} ranks: exit code {code}"
            self.end(f"failed with exit code {code}", MotesError(f"{ending}\n{last}".rstrip()))

    def _terminate(self) -> None:
        for number in (signal.SIGTERM, signal.SIGTERM, signal.SIGKILL):
            with contextlib.suppress(ProcessLookupError):
                self._process.send_signal(number)
            if self.wait(INSIST_S if number == signal.SIGTERM else None):
                return
