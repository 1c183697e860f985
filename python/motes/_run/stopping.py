"""The orderly stop of a run on a signal: SIGINT (Ctrl-C), SIGTERM, or SIGUSR1 from a scheduler.

The core notes the signal (`cpp/comm/stop_signals.h`), the frame's reports carry it to all ranks, and all stop
after the same frame. A second SIGINT or SIGTERM has its usual effect.
"""

from __future__ import annotations

import signal
import sys
import threading

from .. import _core
from .._values import environment
from ..errors import Stopped
from .open_worlds import FOLDER
from .process import process

__all__ = ["Stop", "arm", "check_stopped", "closing_line", "code_of", "disarm", "interactive"]

SAME_S = 1.0  # signals within this time count as one: launcher and scheduler may both forward it to a rank


def arm() -> None:
    """Let signals request a stop, except those that the script handles or ignores. Main thread only."""
    if threading.current_thread() is not threading.main_thread():
        return
    taken = []
    # In an interactive session, only Ctrl-C requests a stop; the other signals end the session as usual.
    for name in ("SIGINT",) if interactive() else ("SIGINT", "SIGTERM", "SIGUSR1"):
        number = getattr(signal, name)
        if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            taken.append(number)
    if environment.is_set(FOLDER):  # `motes run` blocks them, to keep them from mpirun
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT, signal.SIGTERM}.intersection(taken))
    alone = process.size == 1
    _core.note_stop_signals(taken, 0.0 if alone else SAME_S, alone and not interactive())


def disarm() -> None:
    """Restore the previous handling of signals once no run is open.

    After a stop it is not restored, since the same signal may still reach this rank. In a notebook, a loop in
    a thread leaves signals to the cells.
    """
    if interactive() and threading.current_thread() is not threading.main_thread():
        return
    if interactive() or (not process.runs and _core.stop_signal() == 0 and process.stopped == 0):
        _core.release_stop_signals()


def interactive() -> bool:
    """Return whether this is an interactive session: a prompt or a notebook, to which Ctrl-C returns."""
    return hasattr(sys, "ps1")


class Stop:
    """Whether the run of a world has stopped."""

    def __init__(self) -> None:
        """Start with a run that continues."""
        self.signal = 0
        """The signal that stopped the run, or 0."""
        self._interrupted: int | None = None  # the frame before which KeyboardInterrupt was raised

    def due(self, number: int, frame: int) -> bool:
        """Return whether the run must stop before `frame`; `number`: the signal that ranks agreed on, or 0.

        In an interactive session, raise KeyboardInterrupt once instead; the run can then continue.
        """
        if self.signal or not number or self._interrupted == frame:
            return False
        if not interactive():
            return True
        self._interrupted = frame
        _core.forget_stop_signal()
        raise KeyboardInterrupt

    def ask_again(self) -> None:
        """Treat the next interrupt before this frame as a new one: ranks have agreed on signals again."""
        self._interrupted = None

    def take(self, number: int) -> None:
        """Stop the run; the process will end with the signal's exit code."""
        self.signal = process.stopped = number
        _core.end_with_code(code_of(number))


def check_stopped() -> None:
    """Raise Stopped if an earlier run of this process was stopped."""
    if process.stopped:
        raise Stopped(code_of(process.stopped))


def code_of(number: int) -> int:
    """Return the exit code of a process that a signal stopped."""
    return 130 if number == signal.SIGINT else 143


def _name_of(number: int) -> str:
    """Return a signal's name, such as "SIGTERM"."""
    return signal.Signals(number).name


def closing_line(number: int, *, frames: int, total: int, goes_on: bool) -> str:
    """Return one line on why a run stopped and after how many frames; `total`: all frames, or 0 if unknown.

    `goes_on`: there is a checkpoint of this frame.
    """
    of = f" of {total}" if total else ""
    rest = "; the same command continues from there" if goes_on else ""
    return (
        f"motes: stopped by {_name_of(number)} after frame {frames}{of}; "
        f"the log and the film are complete up to it{rest}"
    )
