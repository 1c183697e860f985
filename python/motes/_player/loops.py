"""Runs a function's loop of frames in a thread; no other thread may use its world meanwhile."""

from __future__ import annotations

import inspect
import threading
from collections.abc import Callable
from typing import Any

from .._world.world import World, running_of, session_of
from ..errors import ArgumentError, MotesError, Stopped
from .bridge import Bridge
from .plays import NoFace, Play

__all__ = ["LoopPlay"]


class LoopPlay(Play):
    """A function's loop in a thread, started by `motes.show`."""

    def __init__(self, world: World, loop: Callable[..., Any], *, paused: bool) -> None:
        """Take world and loop. Raises ArgumentError for a function with other arguments."""
        self._arguments = (world,) if _takes_world(loop) else ()
        super().__init__()
        self.title = getattr(loop, "__name__", "motes")
        self._session = session_of(world)
        self._viewers = running_of(world).viewers
        self._loop = loop
        self._paused = paused
        self._value: Any = None
        self._stops = False
        self._bridge: Bridge | None = None
        self._thread = threading.Thread(target=self._run, name="motes.show", daemon=True)

    def start(self) -> None:
        """Take over the world and start the thread. Raises MotesError if the world is in use."""
        session = self._session
        if session.open_views:
            raise MotesError(f"motes.show inside `with` {session.open_views[-1].name!r}`.local()`")
        if session.ended:
            raise MotesError("this world has ended; make a new one")
        session.usage.give_to(self._thread)
        try:
            self._viewing = self._viewers.attach(self.title)
            self.url = self._viewing.url
            if self._paused:
                self._viewers.steering.hold()
            self.face.tell(stop="Stop", error=None, ended=False)
            if not isinstance(self.face, NoFace):
                self._bridge = Bridge(self.face)
                self._bridge.join(self.url)
            self._thread.start()
        except BaseException:
            self._viewers.detach()
            session.usage.give_to(None)
            raise

    def result(self) -> Any:
        """Return the loop's result, or raise its error."""
        super().result()
        return self._value

    def stop(self) -> None:
        """End the loop of frames at the next border."""
        if not self.wait(0) and not self._stops:
            self._stops = True
            self.face.tell(stop="Stopping ...", stopping=True)
            self._viewing.ask({"stop": True})

    def order(self, order: dict[str, Any]) -> None:
        """Pass on a viewer's order."""
        if self._bridge is not None:
            self._bridge.say(order)

    def looks(self) -> None:
        """Note that a page has opened, which has no picture yet."""
        if self._bridge is not None:
            self._bridge.looks()

    def seen(self, number: Any) -> None:
        """Note that the page has shown a picture."""
        if self._bridge is not None:
            self._bridge.seen(number)

    def _run(self) -> None:
        """Run the loop; the work of the thread."""
        error: BaseException | None = None
        try:
            self._value = self._loop(*self._arguments)
        except Stopped:
            self._stops = True
        except BaseException as failure:  # any: `result` raises it
            error = failure
        frame = self._session.frame
        try:
            self._viewers.detach()
            if self._bridge is not None:
                self._bridge.close()
        finally:
            self._session.usage.give_to(None)
            how = "failed" if error is not None else "stopped" if self._stops else "ended"
            self.end(f"{how} after {frame} frames", error)


def _takes_world(loop: Callable[..., Any]) -> bool:
    """Return whether the function needs one argument. Raises ArgumentError if it needs more."""
    try:
        signature = inspect.signature(loop)
    except (TypeError, ValueError):  # a built-in function without signature
        return False
    for given in ((), (None,)):
        try:
            signature.bind(*given)
        except TypeError:
            continue
        return bool(given)
    raise ArgumentError("loop", loop, "a function without arguments, or of the world")
