"""Pictures: the views of a world's renderer, and the frames that the engine draws of them."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any

import numpy as np

from .. import _core
from .._live.steering import Steering
from .._picture.frame import Frame, add_layer, keep_all
from .._picture.rendering import LAYERS, PARTICLES, Renderer, camera_of, frame_arguments, view_of
from .._system.session import Session

__all__ = ["Pictures"]


class Pictures:
    """Turns views into frames."""

    def __init__(self, session: Session, renderer: Callable[[], Renderer | None]) -> None:
        """Create the pictures of a world; `renderer` returns its current renderer."""
        live = session.settings.live
        self._session = session
        self.steering = Steering(live)
        """What viewers did, as all ranks agreed on it: mainly where they look from."""
        self._renderer = renderer
        self._last: Callable[[], Frame | None] = lambda: None

    @property
    def renderer(self) -> Renderer | None:
        """The current renderer."""
        return self._renderer()

    def view(self, time: float, *, camera_only: bool = False) -> _core.View:
        """Return the renderer's view at `time` (s), with the viewers' camera if they have moved it.

        `camera_only`: the view of a frame without a picture, at whose camera the next one's streaks begin.
        """
        renderer = self._renderer()
        assert renderer is not None
        pose = self.steering.camera
        see = camera_of if camera_only else view_of
        return see(renderer, time, None if pose is None else tuple(pose))

    def take(self, engine: _core.Engine, index: int, time: float, view: _core.View) -> Frame:
        """Return the frame with the picture that the engine has drawn of `view`."""
        session, home = self._session, self._session.cast[1]
        pixels = engine.take_pixels(view.width, view.height) if session.rank == home else None
        frame = Frame(index, time, pixels, **frame_arguments(view, engine), home=home, rank=session.rank)
        if frame:
            self._last = weakref.ref(frame)
        return frame

    def add_particles(self, engine: _core.Engine, frame: Frame, view: _core.View) -> None:
        """Draw the particles of a picture alone, as its layer. Collective."""
        keep_all(frame)
        view.set_bare(True)
        view.set_linear(True)
        view.set_layers(1 << LAYERS.index("alpha"))
        engine.redraw(view, self.steering.agreement())
        if frame:
            alone = frame_arguments(view, engine)
            light, alpha = alone["linear"](), alone["layers"]["alpha"]()
            add_layer(frame, PARTICLES, np.dstack([light, alpha]).astype(np.float32))

    def absent(self, index: int, missing: str = "", *, left_out: bool = False) -> Frame:
        """Return a frame without a picture; `missing` says why, if one was requested."""
        time = (index + 1) * self._session.settings.dt
        facts: dict[str, Any] = {"home": None, "rank": self._session.rank, "left_out": left_out}
        return Frame(index, time, None, missing=missing, **facts)

    def keep_last(self) -> None:
        """Fetch the last picture's arrays before the engine overwrites them."""
        picture = self._last()
        if picture is not None:
            keep_all(picture)
