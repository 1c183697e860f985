"""Who may use a world's engine now, and what the engine may call.

Only one call at a time uses the engine, and callbacks cannot call it. The garbage collector cannot see what
the engine holds, so the engine must not hold the world, which would never be collected.
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
        """Start a call, which `end` ends. Raises MotesError while another one runs."""
        self.check(call)
        if not self._lock.acquire(blocking=False):
            raise MotesError(self._refusal(call))
        self._call = call
        self._thread = threading.get_ident()

    def end(self) -> None:
        """End the call."""
        self._lock.release()

    def check(self, call: str) -> None:
        """Raise MotesError where another process or thread has the world, also between its calls."""
        if self.inherited:
            raise MotesError(
                f"{call} in a process that was forked off: this world is its parent's; make "
                "a new World there, or read what it needs before the fork"
            )
        if self._owner is not None and self._owner is not threading.current_thread():
            raise MotesError(
                f"{call} while motes.show runs this world's loop in a thread, which alone may use it: "
                "call wait() or stop() of what motes.show returned first"
            )

    @property
    def inherited(self) -> bool:
        """Whether the world was made by a process of which this one is a fork."""
        return os.getpid() != self._process

    def give_to(self, owner: threading.Thread | None) -> None:
        """Let only this thread use the engine from now on; None: any, one at a time.

        Raises MotesError while a call runs in another thread.
        """
        if owner is not None:
            self.begin("motes.show")
            self._lock.release()
        self._owner = owner

    @contextmanager
    def during(self, call: str) -> Iterator[None]:
        """Start a call, and end it with the block."""
        self.begin(call)
        try:
            yield
        finally:
            self._lock.release()

    @contextmanager
    def callback(self, name: str) -> Iterator[None]:
        """The engine calls a function of the script inside the block."""
        self._callback = name
        try:
            yield
        finally:
            self._callback = None

    def _refusal(self, call: str) -> str:
        if threading.get_ident() != self._thread:
            return (
                f"{call} in thread {threading.current_thread().name!r} while {self._call} runs in another: "
                "one thread at a time may use a world"
            )
        if self._callback is not None:
            return (
                f"{call} inside the callback {self._callback}: a callback changes the particles that it is "
                "given; it cannot record, step or read systems"
            )
        return f"{call} while {self._call} runs: call it before or after"


class Weakly:
    """Calls a method as long as its object lives, without keeping it alive."""

    def __init__(self, method: Callable[..., Any]) -> None:
        """Take a bound method."""
        self._method = weakref.WeakMethod(method)

    def __call__(self, *arguments: Any) -> Any:
        """Call it, or do nothing where its object is gone."""
        method = self._method()
        return None if method is None else method(*arguments)


class Describing:
    """Names ranks by the roles that they play now."""

    def __init__(self, cast: roles.Core) -> None:
        """Take the roles; a loss of ranks may change them."""
        self.cast = cast

    def __call__(self, rank: int) -> str:
        """Name a rank and its roles."""
        return f"rank {rank} ({_core.describe_role(self.cast, rank)})"
