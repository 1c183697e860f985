"""The image generator's side of a live run: its server, and what it exchanges with the frames."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

from .. import _core
from .._io.output import tell
from .._picture.frame import Frame
from .._values.live import Live
from . import access
from .controls import Control, definition_of
from .orders import Orders
from .pose import Pose
from .server import Server
from .steering import Steering

__all__ = ["Viewing"]

_LOOK_S = 0.05
_LONGEST_S = 1.0  # longest pause between frames at film speed, since orders wait meanwhile


class Viewing:
    """Viewers, as the thread of a run's frames sees them. Only `wait` waits for viewers."""

    def __init__(
        self, live: Live, about: dict[str, Any], repeats: str | None, *, quiet: bool = False
    ) -> None:
        """Start the server, and print its address unless `quiet`. Raises MotesError if it cannot start."""
        self._orders = Orders(repeats)
        self._server = Server(live, self._orders, about)
        self._taken = 0  # number of orders taken for all ranks
        self._heard = 0
        self._due_s = 0.0  # when the next frame may start at film speed
        self.url = self._server.url
        if not quiet:
            tell(f"motes: live at {self.url}  ({access.from_afar(live.host, self._server.port)})")

    @property
    def watched(self) -> bool:
        """Whether there are viewers."""
        return self._server.viewers > 0

    def ask(self, order: dict[str, Any]) -> None:
        """Give an order as a viewer does. May be called from any thread."""
        self._orders.put(order)

    def judge(self, judge: Callable[[str], str]) -> None:
        """Let viewers choose the balancers that `judge` accepts."""
        self._orders.judge = judge

    def resize(self, resize: Callable[[int], None]) -> None:
        """Let viewers ask for another number of ranks."""
        self._orders.resize = resize

    def refuse(self, why: str) -> None:
        """Tell all viewers why what one of them has ordered is not done. May be called from any thread."""
        self._server.refuse(why)

    def know(self, controls: Mapping[str, Control]) -> None:
        """Let viewers set these controls."""
        self._orders.know(controls)

    def take(self, pose: Callable[[], Pose | None], near: float) -> str:
        """Return the orders since the last call, as text for all ranks."""
        text, self._taken = self._orders.take(pose, near)
        return text

    def begin_picture(self) -> None:
        """Note that pictures from here on show the effect of all orders taken so far."""
        self._heard = self._taken

    def show(self, frame: Frame) -> None:
        """Give viewers a new picture."""
        if frame:
            self._server.show(frame.pixels, frame=frame.index, orders=self._heard)

    def note(self, frame: int, row: Mapping[str, Any]) -> None:
        """Tell the desk what changes before a frame."""
        self._server.note({"row": {"frame": frame, **row}})

    def keep_pace(self, dt: float) -> None:
        """Wait until the film would show the next frame, if viewers want film speed."""
        now = time.monotonic()
        if self._orders.paced and now < self._due_s:
            time.sleep(min(self._due_s - now, _LONGEST_S))
        self._due_s = max(self._due_s, now) + min(dt, _LONGEST_S)
        self._due_s = min(self._due_s, time.monotonic() + min(dt, _LONGEST_S))

    def tell(self, steering: Steering, pose: Callable[[], Pose | None], **facts: Any) -> None:
        """Send viewers the state of the run."""
        controls = {
            name: {**definition_of(control), "value": steering.wished(name)}
            for name, control in steering.controls.items()
        }
        turned = steering.camera is not None
        if self.watched:
            facts["camera"] = None if (now := pose()) is None else now.to_dict()
        facts["paced"] = self._orders.paced
        self._server.tell({**facts, "paused": steering.paused, "turned": turned, "controls": controls})

    def wait(self, seconds: float) -> None:
        """Wait for an order, at most this many seconds, or for a signal."""
        end = time.monotonic() + seconds
        while time.monotonic() < end and _core.stop_signal() == 0:
            if self._orders.wait(_LOOK_S):
                return

    def close(self) -> None:
        """Tell viewers that the run has ended, and close the server."""
        self._server.close()
