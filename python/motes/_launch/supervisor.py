"""Supervises a launcher: passes signals on, ends it with this process, filters its output, checks all ranks.

What mpirun prints about a failed run would bury the message that says why. So mpirun's own messages go to a
file, and the first failing rank's message is repeated at the end.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import re
import select
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from types import FrameType
from typing import NamedTuple, Self

from .._io.output import tell, write_all
from .._mpi.presence import Presence
from .._run import open_worlds
from .._run.losses import END, LOST
from .files import folder_of_a_job
from .resizing import Resizing

__all__ = ["Ended", "Relay", "start_of_child", "supervise"]

_HANDED_ON = ("SIGTERM", "SIGHUP", "SIGINT", "SIGQUIT", "SIGUSR1", "SIGUSR2")
_ASKING = (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1)  # ask the run to stop at the end of a frame
_BLOCKED = (signal.SIGINT, signal.SIGTERM)
"""Signals that the launcher does not get: it would kill its ranks in the middle of a frame."""
_ENDING = signal.SIGHUP
"""The signal that ends the launcher instead."""
_GRACE_S = 5.0  # for a launcher to end its ranks before it is killed itself
_IDLE_S = 0.2  # how long to hold back a line that may start a message of the launcher
_DRAIN_S = 1.0  # how long output may still arrive after the launcher has ended
_PR_SET_PDEATHSIG = 1


class Ended(NamedTuple):
    """How a job ended."""

    code: int
    """The exit code; 1 if the launcher returned 0 although ranks on this host never ended."""
    lost: bool
    """Whether a process or a host was lost, so that a restart may succeed."""


def supervise(
    argv: Sequence[str],
    variables: Mapping[str, str] | None = None,
    ranks: int = 0,
    resizing: Resizing | None = None,
) -> Ended:
    """Run a launcher to its end, and return how the job ended.

    `variables` are added to its environment, unless this process has set them already. `ranks`: how many are
    to start, each under a watcher (`started_by`); 0: unknown. `resizing`: what answers SIGUSR2.

    SIGINT, SIGTERM and SIGUSR1 go to the ranks that are inside `with world:`, which then stop together. If
    this host has none, they go to the launcher, like a second SIGINT or SIGTERM and all other signals. On
    Linux the launcher ends when this process does, even if that is killed.
    """
    with (
        folder_of_a_job() as (folder, own),
        _Signals(worlds := os.path.join(folder, "worlds"), resizing) as signals,
    ):
        os.mkdir(worlds)
        environment = {**own, **(variables or {}), **os.environ, open_worlds.FOLDER: worlds}
        process = subprocess.Popen(
            argv, env=environment, stderr=subprocess.PIPE, preexec_fn=_start_of_launcher(), bufsize=0
        )
        assert process.stderr is not None
        reader = None
        try:
            signals.go_to(process)
            relay = Relay(lambda data: write_all(2, data), lambda: process.send_signal(_ENDING), ranks)
            reader = threading.Thread(target=relay.run, args=(process.stderr.fileno(),), daemon=True)
            reader.start()
            code = process.wait()
            reader.join(_DRAIN_S)  # a child that outlives the launcher may hold the pipe open
        finally:
            _end(process)
            if reader is None or not reader.is_alive():
                process.stderr.close()
        left = open_worlds.left_open(worlds)
    relay.close(failed=code != 0 or relay.code is not None or relay.presence.hopeless)
    if code == 0 and relay.code is None and left:
        tell(
            f"motes: the run did not end: rank(s) {', '.join(map(str, left))} stopped inside `with world:`, "
            "as when mpirun loses a host; its log shows how far it got"
        )
        return Ended(1, lost=True)
    message = relay.message
    if code == signal.SIGKILL and left and not message:  # mpiexec of MPICH returns the signal as it is
        code, message = -code, "a rank was killed inside `with world:`, and mpiexec has ended the others"
    code = 128 + signals.passed_on if code == -_ENDING and signals.passed_on else code
    code = code if code >= 0 else 128 - code
    if relay.code is not None:  # a rank ended the job through this process
        code = relay.code
    elif relay.presence.hopeless:
        code = 1
    if code != 0 and signals.insisted:
        code = 128 + signals.insisted
    if code != 0 and message and (resizing is None or resizing.wanted is None):
        tell(f"motes run: exit code {code}: {message}")
    stopped = code in (128 + signal.SIGINT, 128 + signal.SIGTERM)
    return Ended(code, lost=(code > 128 and not stopped) or relay.lost)


class _Signals:
    """Passes signals on to a process or its ranks, early ones as soon as the process has started."""

    def __init__(self, worlds: str, resizing: Resizing | None) -> None:
        self.insisted = 0
        """The second signal, which ends the job at once; 0: there was none."""
        self.passed_on = 0
        """The last signal that was passed to the launcher as `_ENDING`; 0: none."""
        self._folder = worlds
        self._resizing = resizing
        self._asked = False  # whether SIGINT or SIGTERM has asked the ranks to stop
        self._process: subprocess.Popen[bytes] | None = None
        self._early: list[int] = []
        self._before: dict[int, Callable[[int, FrameType | None], object] | int | None] = {}

    def go_to(self, process: subprocess.Popen[bytes]) -> None:
        self._process = process
        for number in self._early:
            self._hand_on(number, None)

    def _hand_on(self, number: int, _: FrameType | None) -> None:
        if number == signal.SIGQUIT and sys.stdin is not None and sys.stdin.isatty():
            return  # the terminal sends it to both processes
        if self._process is None:
            self._early.append(number)
        elif number == signal.SIGUSR2 and self._resizing is not None:
            self._resizing.ask(self._folder)
        elif not self._ask(number):
            self._pass_on(number)

    def _ask(self, number: int) -> bool:
        """Ask the ranks to stop; return False if there are none, or if they were asked before."""
        if number not in _ASKING:
            return False
        urgent = number != signal.SIGUSR1
        if urgent and self._asked:
            self.insisted = number
            return False
        if not open_worlds.send(self._folder, number):
            return False
        if urgent:
            self._asked = True
        name, more = signal.Signals(number).name, "; a second one ends it at once" if urgent else ""
        tell(f"motes: {name}: the run stops when this frame is done{more}")
        return True

    def _pass_on(self, number: int) -> None:
        assert self._process is not None
        if number in _BLOCKED:
            self.passed_on, number = number, _ENDING
        self._process.send_signal(number)

    def __enter__(self) -> Self:
        for name in _HANDED_ON:
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) != signal.SIG_IGN:  # ignored under nohup
                self._before[number] = signal.signal(number, self._hand_on)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)


def _start_of_launcher() -> Callable[[], None]:
    """Return a function that the launcher calls between fork and exec.

    Neither a terminal's Ctrl-C nor a scheduler's SIGTERM to all processes may end the launcher: it would kill
    its ranks, which stop by themselves when their frame is done.
    """
    return start_of_child(_BLOCKED, _ENDING)


def start_of_child(
    blocked: Iterable[int] = (signal.SIGINT,), at_death: int = signal.SIGTERM
) -> Callable[[], None]:
    """Return a function that a child calls between fork and exec.

    It blocks the signals `blocked`, by default a terminal's Ctrl-C. On Linux the child gets the signal
    `at_death` when this process dies.
    """
    parent, prctl = os.getpid(), ctypes.CDLL(None).prctl if sys.platform == "linux" else None

    def start() -> None:
        signal.pthread_sigmask(signal.SIG_BLOCK, blocked)
        if prctl is None:
            return
        # Once this process is gone, nobody reads the launcher's messages: SIGPIPE must not end the launcher
        # before it has ended its ranks.
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
        prctl(_PR_SET_PDEATHSIG, int(at_death), 0, 0, 0)
        if os.getppid() != parent:  # it has died already
            os._exit(1)

    return start


def _end(process: subprocess.Popen[bytes]) -> None:
    if process.poll() is not None:
        return
    process.send_signal(_ENDING)
    try:
        process.wait(_GRACE_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


class Relay:
    """Passes on what a launcher writes to standard error, except its own messages about a failed run.

    Those are enclosed by lines of dashes (Open MPI) or equals signs (MPICH).
    """

    _RULE = re.compile(rb"\s*(-{60,}|={60,})\s*")
    _OWN = re.compile(
        rb"\W*(MPI_ABORT was invoked|(prterun|mpirun|mpiexec)\S* (has exited|noticed|detected)"
        rb"|Primary job +terminated|=   BAD TERMINATION)"
    )
    # Printed by a rank that continues without a lost one: the collective under way has failed.
    _LOSS = re.compile(
        rb"(NBC_Progress: an error 7[5-7] was found during schedule .*"
        rb"|Error in NBC_Start_round\(\) \((-1|7[5-7])\))\s*"
    )
    _END = re.compile(re.escape(END.encode()) + rb"(\d+)")
    _OURS = b"*** motes: "
    _REPORT = re.compile(re.escape(_OURS) + rb"(.*)")
    _STOPPED = re.compile(rb"motes: stopped by SIG")
    _ERROR = re.compile(rb"([A-Za-z_][\w.]*(?:Error|Exception|Interrupt)\b.*)")
    _MOST_LINES = 100  # a longer block is not a message

    def __init__(
        self, write: Callable[[bytes], object], end: Callable[[], object] = lambda: None, ranks: int = 0
    ) -> None:
        """`write` takes what is passed on; `end` is called when a rank wants the job of `ranks` to end."""
        self.code: int | None = None
        """The exit code of a rank that ended the job (`losses.end_job`)."""
        self._end = end
        self.presence = Presence(end, ranks)
        self.own: list[bytes] = []
        """The lines of the launcher's messages."""
        self._write = write
        self._held: list[bytes] = []
        self._inside = False
        self._rest = b""
        self._after_loss = False
        self._report = self._error = b""
        self._stopped = False
        self._next_lost = False
        self.lost = False
        """Whether the first report is about a lost rank (`losses.LOST`)."""

    @property
    def message(self) -> str:
        """The message of the first failing rank, in one line."""
        report, error = (text.decode(errors="replace").strip() for text in (self._report, self._error))
        return report or self.presence.sentence(error, b"".join(self.own)) or error

    def run(self, file: int) -> None:
        """Read a file descriptor to its end."""
        with contextlib.suppress(OSError):
            while True:
                if not select.select([file], [], [], _IDLE_S)[0]:
                    self._give_up_holding()
                    continue
                data = os.read(file, 65536)
                if not data:
                    return
                self.feed(data)

    def feed(self, data: bytes) -> None:
        """Process some output, line by line."""
        *lines, rest = (self._rest + data).split(b"\n")
        self._rest = b""
        for line in lines:
            self._take(line + b"\n")
        ours = rest.startswith(self._OURS) or self._OURS.startswith(rest)
        if self._inside or self._held or ours or not rest.strip(b" \t\r\0-="):
            self._rest = rest  # may become a report, which crashing ranks write in parts, or a line of dashes
        else:
            self._pass_on(rest)  # such as a progress bar, which never ends its line

    def close(self, *, failed: bool) -> None:
        """Pass on what is held back. If the run failed, save the launcher's messages and name their file."""
        self._take(self._rest)
        self._give_up_holding()
        self.presence.close()
        if not self.own or (self._stopped and not self.message):  # the run itself says why it ended
            return
        if not failed or not self.message:  # nothing else says what happened
            self._pass_on(b"".join(self.own))
        if failed:
            with contextlib.suppress(OSError):
                file, path = tempfile.mkstemp(prefix="motes-mpirun-", suffix=".txt")
                with open(file, "wb") as target:
                    target.write(b"".join(self.own))
                tell(f"motes run: mpirun's own messages: {path}")

    def _take(self, line: bytes) -> None:
        if self.presence.take(line):
            return
        if end := self._END.search(line):
            if self.code is None:
                self.code = int(end[1])
                self._end()
            return
        if LOST.encode() in line:
            self._next_lost = True
            return
        if report := self._REPORT.search(line):
            self.lost = self.lost or (self._next_lost and not self._report)
            self._next_lost = False
            self._report = self._report or report[1]
        elif self._STOPPED.search(line):
            self._stopped = True
        elif error := self._ERROR.match(line):
            self._error = self._error or error[1]
        rule = self._RULE.fullmatch(line) is not None
        if self._inside:
            if report:  # a rank's line in between
                self._pass_on(line)
                return
            self._held.append(line)
            if rule:
                self.own += self._held
                self._held, self._inside = [], False
            elif len(self._held) > self._MOST_LINES:
                self._give_up_holding()
        elif self._held and self._OWN.match(line):
            self._held.append(line)
            self._inside = True
        elif rule:
            self._give_up_holding()
            self._held = [line]
        elif self._LOSS.fullmatch(line):
            self._after_loss = True
            return
        elif self._after_loss and line == b"\n":
            pass
        else:
            self._give_up_holding()
            self._pass_on(line)
        self._after_loss = False

    def _give_up_holding(self) -> None:
        held, self._held, self._inside = b"".join(self._held), [], False
        self._pass_on(held)

    def _pass_on(self, data: bytes) -> None:
        data = data.replace(b"\0", b"")  # PRRTE ends its texts with NUL
        if data:
            with contextlib.suppress(OSError):  # on a full disk, or without a reader, the run continues
                self._write(data)
