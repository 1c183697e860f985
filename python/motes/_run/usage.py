"""Guards for a world's engine: one call at a time, and weak callbacks.

Only one call at a time uses the engine, and callbacks cannot call it. The garbage collector cannot see
references from the engine: if it referred to the world, the world would never be collected.
"""

from __future__ import annotations

import os
import threading
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from .. import _core
from .._values import roles
from ..errors import MotesError

__all__ = ["Describing", "Usage", "Weakly"]


class Usage:
    """Lets one call at a time use the engine; every other call raises at once and says why."""

    __slots__ = ("_call", "_callback", "_lock", "_owner", "_process", "_thread")

    def __init__(self) -> None:
        """Start with no call in progress."""
        self._lock = threading.Lock()
        self._process = os.getpid()
        self._call = ""
        self._thread = 0
        self._callback: str | None = None
        self._owner: threading.Thread | None = None

    def begin(self, call: str) -> None:
        """Start a call, to be ended by `end`. Raises MotesError while another one runs."""
        self.check(call)
        if not self._lock.acquire(blocking=False):
            raise MotesError(self._refusal(call))
        self._call = call
        self._thread = threading.get_ident()

    def end(self) -> None:
        """End the call."""
        self._lock.release()

    def check(self, call: str) -> None:
        """Raise MotesError if the world belongs to another process or thread."""
        if self.inherited:
            raise MotesError(
                f"{call} in a forked process: this world belongs to its parent; create "
                "a new World there, or read what you need before the fork"
            )
        if self._owner is not None and self._owner is not threading.current_thread():
            raise MotesError(
                f"{call} while motes.show runs this world's loop in a thread: "
                "only that thread may use the world; call wait() or stop() of what motes.show returned first"
            )

    @property
    def inherited(self) -> bool:
        """Whether this process is a fork of the one that created the world."""
        return os.getpid() != self._process

    def give_to(self, owner: threading.Thread | None) -> None:
        """Let only the thread `owner` use the engine from now on; None: any thread, one at a time.

        Raises MotesError while a call runs in another thread.
        """
        if owner is not None:
            self.begin("motes.show")
            self._lock.release()
        self._owner = owner

    @contextmanager
    def during(self, call: str) -> Iterator[None]:
        """Run the block as one call."""
        self.begin(call)
        try:
            yield
        finally:
            self._lock.release()

    @contextmanager
    def callback(self, name: str) -> Iterator[None]:
        """Mark the block as a callback, a function of the script that the engine calls."""
        self._callback = name
        try:
            yield
        finally:
            self._callback = None

    def _refusal(self, call: str) -> str:
        if threading.get_ident() != self._thread:
            return (
                f"{call} in thread {threading.current_thread().name!r} while {self._call} runs in another: "
                "only one thread at a time may use a world"
            )
        if self._callback is not None:
            return (
                f"{call} inside the callback {self._callback}: a callback changes the particles that it is "
                "given; it cannot record, step or read systems"
            )
        return f"{call} while {self._call} runs: call it before or after"


class Weakly:
    """Calls a bound method while its object lives, without keeping the object alive."""

    def __init__(self, method: Callable[..., Any]) -> None:
        """Store a weak reference to a bound method."""
        self._method = weakref.WeakMethod(method)

    def __call__(self, *arguments: Any) -> Any:
        """Call the method; return None if its object is gone."""
        method = self._method()
        return None if method is None else method(*arguments)


class Describing:
    """Describes ranks by their current roles."""

    def __init__(self, cast: roles.Core) -> None:
        """Store the roles; `cast` is replaced when ranks are lost."""
        self.cast = cast

    def __call__(self, rank: int) -> str:
        """Describe a rank and its roles."""
        return f"rank {rank} ({_core.describe_role(self.cast, rank)})"
