"""Notices ranks that end before MPI has started: the others would wait in MPI_Init for ever.

mpirun ends the job if a rank fails before MPI_Init, but not if one exits with code 0, and with `--survive` in
neither case. So `motes run` starts each rank through `start_rank.py`, which leaves a watcher beside it. The
rank writes to the watcher through a pipe. The watcher reports to `motes run` in lines on standard error,
which arrive from any host: the rank starts, waits for MPI, has MPI, or has ended. It exits once the rank has
MPI.

A rank that is killed before it has a watcher is known only to mpirun, which started the process. So with
`--survive` mpirun has to tell which ranks fail (`LAUNCHER_TELLS`). Open MPI 5.0.11 may lose what another host
tells it of a rank that has just started. So ranks also count as gone if they do not start while others wait.
"""

from __future__ import annotations

import contextlib
import os
import re
import stat
import sys
import threading
from collections.abc import Callable, Sequence

from .._values import environment
from .rank_process import JOB, MARK

__all__ = ["LAUNCHER_TELLS", "Presence", "has_mpi", "started_by", "waits_for_mpi"]

_PIPE = "MOTES_RANK_PIPE"
"""The environment variable with the file descriptor of the pipe to the watcher."""

LAUNCHER_TELLS = {"PRTE_MCA_errmgr_base_verbose": "1"}
"""Variables with which mpirun of Open MPI 5 prints a line, `_FAILURE`, for each rank that fails."""

_GRACE_S = 1.0  # for mpirun to end the job by itself, with the rank's exit code
_ABSENT_S = 30.0  # how long ranks may wait for one that has not started; all start at about the same time
_LINE = re.compile(rb"\*\*\* motes: of rank (\d+): (starts|waits|has|ended)\b")
_FAILURE = re.compile(rb"errmgr:dvm: for proc \[[^]]*@(\d+),(\d+)\] state (.*)")
_SIGNAL = re.compile(rb"exited on\s+signal (\d+ \([^)]*\))")
_FAILED = re.compile(rb"Process name: \[[^]]*,\s*(\d+)\]|process\s+rank\s+(\d+)")


def started_by(program: Sequence[str], *, is_rank: bool) -> list[str]:
    """Return the command that starts a program under a watcher; `is_rank`: the program itself is the rank."""
    start = os.path.join(os.path.dirname(__file__), "start_rank.py")
    mark = " ".join((MARK, *JOB)) if is_rank else ""
    return [sys.executable, "-IS", start, _PIPE, mark, *program]


def waits_for_mpi() -> None:
    """Tell the watcher that this rank is about to start MPI."""
    _say(b"waits\n")


def has_mpi() -> None:
    """Tell the watcher that MPI has started in this rank, and `motes run` which memory MPICH shares."""
    _say(b"has\n")
    _name_memory()
    pipe = os.environ.pop(_PIPE, "")
    if pipe:
        with contextlib.suppress(OSError):
            os.close(int(pipe))


def _name_memory() -> None:
    """Leave the names of MPICH's shared memory to `motes run`: only ranks that end well remove it."""
    folder = os.path.dirname(environment.read("MOTES_OPEN_WORLDS") or "")
    if os.path.isdir(folder):  # on the host of `motes run`
        with contextlib.suppress(OSError), open("/proc/self/maps") as maps:
            for name in set(re.findall(r"/dev/shm/(mpich_\w+)$", maps.read(), re.MULTILINE)):
                os.close(os.open(os.path.join(folder, name), os.O_CREAT, 0o600))


def _say(word: bytes) -> None:
    pipe = os.environ.get(_PIPE, "")
    if not pipe:
        return
    try:
        if not stat.S_ISFIFO(os.fstat(int(pipe)).st_mode):
            raise OSError
        os.write(int(pipe), word)
    except OSError:  # closed by the script, which may have opened another file since
        os.environ.pop(_PIPE, None)


class Presence:
    """Collects the reports of watchers and of the launcher, and ends a job that can no longer start."""

    def __init__(self, end: Callable[[], object], ranks: int = 0) -> None:
        """`end` is called, in another thread, when ranks wait for one that is gone; `ranks`: their number."""
        self._end = end
        self._absent = set(range(ranks))
        self._waiting: set[int] = set()
        self._started: set[int] = set()
        self._gone: dict[int, str] = {}  # by rank, what the launcher says of it, if anything
        self._timers: dict[str, threading.Timer] = {}
        self.hopeless = False
        """Whether `end` was called."""

    def take(self, line: bytes) -> bool:
        """Process a line of output if it is a report; return whether it is."""
        if failure := _FAILURE.search(line):
            if failure[1] != b"0":  # the job of mpirun's own daemons
                self._lose(int(failure[2]), failure[3].decode(errors="replace").strip().lower())
        elif match := _LINE.search(line):
            rank = int(match[1])
            self._absent.discard(rank)
            if match[2] == b"waits":
                self._waiting.add(rank)
            elif match[2] == b"has":
                self._started.add(rank)
                self._waiting.discard(rank)
                self._gone.pop(rank, None)  # the launcher's report came first
            elif match[2] == b"ended":
                self._lose(rank, "")
        else:
            return False
        if self._is_hopeless():
            self._after(_GRACE_S, self._give_up)
        elif self._waiting and self._absent:
            self._after(_ABSENT_S, self._give_up_absent)
        return True

    def sentence(self, error: str, launcher: bytes) -> str:
        """Name the ranks that ended before MPI had started, with the error that was printed; or return "".

        `launcher` is the launcher's own messages, which name the rank that failed first.
        """
        if not self._gone:
            return ""
        first = _FAILED.search(launcher)
        failed = {int(next(filter(None, first.groups())))} & set(self._gone) if first else set()
        gone = sorted(failed or self._gone)
        who = f"rank{'s' if len(gone) > 1 else ''} {', '.join(map(str, gone))}"
        others = "; the others would wait forever" if self.hopeless else ""
        if self._absent and self._absent.issuperset(gone):
            return f"{who} did not start within {_ABSENT_S:.0f} s{others}"
        if signal := _SIGNAL.search(launcher):
            how = f", on signal {signal[1].decode()}"
        else:
            how = ", on a signal" if all("signal" in self._gone[rank] for rank in gone) else ""
        return f"{who} ended before MPI had started{how}{others}" + (f": {error}" if error else "")

    def close(self) -> None:
        """Stop waiting: the launcher has ended."""
        for timer in list(self._timers.values()):
            timer.cancel()

    def _after(self, seconds: float, act: Callable[[], None]) -> None:
        """Call a method later, unless it is going to be called already."""
        if act.__name__ not in self._timers:
            timer = self._timers[act.__name__] = threading.Timer(seconds, act)
            timer.daemon = True
            timer.start()

    def _lose(self, rank: int, how: str) -> None:
        self._absent.discard(rank)
        self._waiting.discard(rank)
        if rank not in self._started:
            self._gone[rank] = how or self._gone.get(rank, "")

    def _is_hopeless(self) -> bool:
        """Return whether ranks wait for one that is gone.

        Scripts that import mpi4py first wait in silence: if the launcher says that a rank failed, and MPI has
        not started in any other, they count as waiting.
        """
        failed = any(self._gone.values())
        return bool(self._gone) and (bool(self._waiting) or (failed and not self._started))

    def _give_up(self) -> None:
        self._timers.pop("_give_up", None)
        if self._is_hopeless():
            self.hopeless = True
            self._end()

    def _give_up_absent(self) -> None:
        self._timers.pop("_give_up_absent", None)
        if self._waiting:
            self._gone |= dict.fromkeys(self._absent, "")
            self._give_up()
