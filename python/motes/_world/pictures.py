"""Pictures: what a world's renderer shows, and the frames that the engine makes of it."""

from __future__ import annotations

import weakref
from collections.abc import Callable

from .. import _core
from .._live.steering import Steering
from .._picture.frame import Frame, keep_all
from .._picture.rendering import Renderer, kept, view_of
from .._system.session import Session

__all__ = ["Pictures"]


class Pictures:
    """Turns views into frames."""

    def __init__(self, session: Session, renderer: Callable[[], Renderer | None]) -> None:
        """Take what gives the renderer of now."""
        live = session.settings.live
        self._session = session
        self.steering = Steering(paused=live is not None and live.paused, wait=live is not None and live.wait)
        """What all ranks agreed on of what viewers did: where they look, above all."""
        self._renderer = renderer
        self._last: Callable[[], Frame | None] = lambda: None

    @property
    def renderer(self) -> Renderer | None:
        """What pictures look like now."""
        return self._renderer()

    def view(self, time: float) -> _core.View:
        """Return what the renderer shows at a time (s), from where viewers look."""
        renderer = self._renderer()
        assert renderer is not None
        pose = self.steering.camera
        return view_of(renderer, time, None if pose is None else tuple(pose))

    def take(self, engine: _core.Engine, index: int, time: float, view: _core.View) -> Frame:
        """Return the picture that the engine has made of a view."""
        session, home = self._session, self._session.cast[1]
        pixels = engine.take_pixels(view.width, view.height) if session.rank == home else None
        frame = Frame(index, time, pixels, **kept(view, engine), home=home, rank=session.rank)
        if frame:
            self._last = weakref.ref(frame)
        return frame

    def absent(self, index: int, missing: str = "") -> Frame:
        """Return what stands for a frame without a picture; `missing` says why, where one was asked for."""
        time = (index + 1) * self._session.settings.dt
        return Frame(index, time, None, home=None, rank=self._session.rank, missing=missing)

    def keep_last(self) -> None:
        """Let the last picture keep its arrays: the engine forgets them."""
        picture = self._last()
        if picture is not None:
            keep_all(picture)
