"""The runs that a player shows: the loop of a function in a thread, or a job of many ranks."""

from __future__ import annotations

import atexit
import contextlib
import threading
import weakref
from abc import ABC, abstractmethod
from typing import Any, Protocol

__all__ = ["Face", "NoFace", "Play"]

LEAVE_S = 3.0  # how long the notebook's process waits for each play when it ends


class Face(Protocol):
    """The display of a play: a widget, or nothing."""

    def tell(self, **facts: Any) -> None:
        """Show these facts in addition to the run's state."""

    def hear(self, message: dict[str, Any]) -> None:
        """Show a message of the run: its state, or the refusal of an order."""

    def show(self, picture: bytes) -> None:
        """Show a picture: see `_live.pictures.Encoded`."""

    def leave(self) -> None:
        """Stop showing anything: the notebook's process ends."""


class NoFace:
    """Shows nothing."""

    def tell(self, **facts: Any) -> None:
        """Do nothing."""

    def hear(self, message: dict[str, Any]) -> None:
        """Do nothing."""

    def show(self, picture: bytes) -> None:
        """Do nothing."""

    def leave(self) -> None:
        """Do nothing."""


class Play(ABC):
    """A run in the background of the cells, which can be stopped."""

    title: str
    url: str | None = None
    """The address of its page."""

    def __init__(self) -> None:
        """Create the play; `start` starts it."""
        self.face: Face = NoFace()
        self.ending = "has ended"
        """How the run has ended, in a few words."""
        self._ended = threading.Event()
        self._error: BaseException | None = None
        _going_on.add(self)

    @abstractmethod
    def start(self) -> None:
        """Start the run."""

    @abstractmethod
    def stop(self) -> None:
        """Ask the run to end at a border between two frames. May be called from any thread."""

    @abstractmethod
    def order(self, order: dict[str, Any]) -> None:
        """Pass on a viewer's order."""

    @abstractmethod
    def looks(self) -> None:
        """Note that a page has opened, which has no picture yet."""

    @abstractmethod
    def seen(self, number: Any) -> None:
        """Note that the page has shown a picture."""

    def output(self) -> list[str]:
        """Return the last lines that the run has printed."""
        return []

    def wait(self, seconds: float | None) -> bool:
        """Wait for the run's end; return whether it has ended."""
        return self._ended.wait(seconds)

    def result(self) -> Any:
        """Return the run's result, or raise its error. Call it after the end."""
        if self._error is not None:
            raise self._error

    def end(self, ending: str, error: BaseException | None = None) -> None:
        """Record and show how the run has ended."""
        self.ending, self._error = ending, error
        reason = None if error is None else f"{type(error).__name__}: {error}"
        with contextlib.suppress(Exception):  # the notebook may be gone; waiting threads must wake up anyway
            self.face.tell(ended=True, notice=ending, error=reason, stop="Stop")
        _going_on.discard(self)
        self._ended.set()


_going_on: weakref.WeakSet[Play] = weakref.WeakSet()


@atexit.register
def _leave() -> None:
    """Stop all plays when the notebook's process ends, so that their logs and films are complete."""
    for play in list(_going_on):
        with contextlib.suppress(Exception):  # the other plays must be stopped, too
            play.face.leave()
            play.stop()
            play.wait(LEAVE_S)
