"""The orderly end of a run that a signal asks for: SIGINT (Ctrl-C), SIGTERM, or SIGUSR1 from a scheduler.

The core notes the signal (`cpp/comm/stop_signals.h`), ranks tell each other in the frame's reports, and all
stop after the same frame. A second SIGINT or SIGTERM does what it would do without all this.
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

SAME_S = 1.0  # a launcher and a scheduler may both pass a signal on to a rank within this time


def arm() -> None:
    """Let signals ask for a stop, but those that the script handles or ignores. Main thread only."""
    if threading.current_thread() is not threading.main_thread():
        return
    taken = []
    # Only Ctrl-C ends a cell, or the command at a prompt; the others end the session as ever.
    for name in ("SIGINT",) if interactive() else ("SIGINT", "SIGTERM", "SIGUSR1"):
        number = getattr(signal, name)
        if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            taken.append(number)
    if environment.is_set(FOLDER):  # `motes run` keeps them from mpirun
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT, signal.SIGTERM}.intersection(taken))
    alone = process.size == 1
    _core.note_stop_signals(taken, 0.0 if alone else SAME_S, alone and not interactive())


def disarm() -> None:
    """Let signals do what they did before, once no run is open.

    After a stop they stay as they are: the same signal may reach this rank late. In a notebook a loop that
    runs in a thread leaves them to the cells.
    """
    if interactive() and threading.current_thread() is not threading.main_thread():
        return
    if interactive() or (not process.runs and _core.stop_signal() == 0 and process.stopped == 0):
        _core.release_stop_signals()


def interactive() -> bool:
    """Whether a person types what runs: a prompt or a notebook, to which an interrupt returns."""
    return hasattr(sys, "ps1")


class Stop:
    """Whether the run of a world has stopped."""

    def __init__(self) -> None:
        """It goes on."""
        self.signal = 0
        """The signal that stopped it."""
        self._interrupted: int | None = None  # the frame at whose border an interrupt was raised

    def due(self, asked: int, frame: int) -> bool:
        """Tell whether it must stop at this border, before `frame`; `asked`: the signal that ranks agreed on.

        At a prompt, raises KeyboardInterrupt instead, once; then the run can go on.
        """
        if self.signal or not asked or self._interrupted == frame:
            return False
        if not interactive():
            return True
        self._interrupted = frame
        _core.forget_stop_signal()
        raise KeyboardInterrupt

    def ask_again(self) -> None:
        """Ranks have asked each other again at this border: another interrupt is another one."""
        self._interrupted = None

    def take(self, asked: int) -> None:
        """Stop: the process will end with the signal's exit code."""
        self.signal = process.stopped = asked
        _core.end_with_code(code_of(asked))


def check_stopped() -> None:
    """Raise Stopped where an earlier run of this process was stopped."""
    if process.stopped:
        raise Stopped(code_of(process.stopped))


def code_of(number: int) -> int:
    """Return the exit code of a process that stopped because of a signal."""
    return 130 if number == signal.SIGINT else 143


def _name_of(number: int) -> str:
    """Name a signal: "SIGTERM"."""
    return signal.Signals(number).name


def closing_line(number: int, *, frames: int, total: int, goes_on: bool) -> str:
    """Say in one line why a run stopped, after how many frames (of `total`, or 0), and what there is now.

    `goes_on`: there is a checkpoint of this frame.
    """
    of = f" of {total}" if total else ""
    rest = "; the same command goes on from there" if goes_on else ""
    return (
        f"motes: stopped by {_name_of(number)} after frame {frames}{of}; "
        f"the log and the film are whole up to it{rest}"
    )
