"""What a player plays: the loop of a function in a thread, or a job of many ranks."""

from __future__ import annotations

import atexit
import contextlib
import threading
import weakref
from abc import ABC, abstractmethod
from typing import Any, Protocol

__all__ = ["Face", "NoFace", "Play"]

LEAVE_S = 3.0  # how long the end of the notebook's process waits for what it plays


class Face(Protocol):
    """What shows a play: a widget, or nothing."""

    def tell(self, **facts: Any) -> None:
        """Show these facts beside those that the run itself tells."""

    def hear(self, message: dict[str, Any]) -> None:
        """Show what the run says: its state, or a refusal."""

    def show(self, picture: bytes) -> None:
        """Show a picture: see `_live.pictures.Encoded`."""

    def leave(self) -> None:
        """Show nothing any more: the notebook's process ends."""


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
    """Something that goes on beside the cells, and can be stopped."""

    title: str
    url: str | None = None
    """Where its page is."""

    def __init__(self) -> None:
        """Nothing goes on yet."""
        self.face: Face = NoFace()
        self.ending = "has ended"
        """How it has ended, in a few words."""
        self._ended = threading.Event()
        self._error: BaseException | None = None
        _going_on.add(self)

    @abstractmethod
    def start(self) -> None:
        """Begin."""

    @abstractmethod
    def stop(self) -> None:
        """Ask it to end at a border between two frames. Any thread may do so."""

    @abstractmethod
    def order(self, order: dict[str, Any]) -> None:
        """Pass on what a viewer asks for."""

    @abstractmethod
    def looks(self) -> None:
        """Note that somebody looks, who has no picture yet."""

    @abstractmethod
    def seen(self, number: Any) -> None:
        """Note that somebody has seen a picture."""

    def output(self) -> list[str]:
        """Return the last lines that it has printed."""
        return []

    def wait(self, seconds: float | None) -> bool:
        """Wait for the end; tell whether it has come."""
        return self._ended.wait(seconds)

    def result(self) -> Any:
        """Return what it has come to, or raise its error; after the end."""
        if self._error is not None:
            raise self._error

    def end(self, ending: str, error: BaseException | None = None) -> None:
        """Tell that it has ended."""
        self.ending, self._error = ending, error
        told = None if error is None else f"{type(error).__name__}: {error}"
        with contextlib.suppress(Exception):  # the notebook may be gone; who waits must hear of it anyway
            self.face.tell(ended=True, notice=ending, error=told, stop="Stop")
        _going_on.discard(self)
        self._ended.set()


_going_on: weakref.WeakSet[Play] = weakref.WeakSet()


@atexit.register
def _leave() -> None:
    """Stop what goes on when the notebook's process ends: log and film are whole then."""
    for play in list(_going_on):
        with contextlib.suppress(Exception):  # the others must be stopped, too
            play.face.leave()
            play.stop()
            play.wait(LEAVE_S)
