"""How long a rank has waited for another one, and when it warns and gives up; the core's own waits agree."""

from __future__ import annotations

import time
from collections.abc import Callable

from ..errors import MotesError
from .output import tell

__all__ = ["Wait", "poll"]

WHILE_ALIVE = 10.0  # stall limits, after the warning, until a rank gives up


class Wait:
    """Seconds of one wait, not counting those in which this process was suspended (Ctrl-Z, a laptop's lid).

    The processes waited for may have been suspended just as long.
    """

    def __init__(self, limit_s: float, what: str) -> None:
        """Warn after `limit_s` and give up after ten times as long; `what`: "waited for ..." in messages."""
        self.limit_s = limit_s
        self.what = what
        self.waited_s = 0.0
        self._last = time.monotonic()
        self._warned = False

    def look(self) -> None:
        """Count the time since the last look; call this every few milliseconds.

        Raises MotesError if the limit has passed for good.
        """
        now = time.monotonic()
        # A longer gap means that this process did not run; on an overloaded machine such gaps are normal,
        # so each counts a little.
        self.waited_s += min(now - self._last, 1.0, self.limit_s / 4)
        self._last = now
        if self.waited_s > WHILE_ALIVE * self.limit_s:
            raise MotesError(self._text())
        if self.waited_s > self.limit_s and not self._warned:
            self._warned = True
            tell(f"motes: {self._text()}; it goes on waiting, for {WHILE_ALIVE * self.limit_s:.0f} s in all")

    def _text(self) -> str:
        limit = f"MOTES_STALL_S, now {self.limit_s:g} s, sets the limit"
        return f"waited {self.waited_s:.0f} s for {self.what} ({limit})"


def poll(done: Callable[[], bool], wait: Wait) -> None:
    """Call `done` until it returns true, first in quick succession, then less and less often."""
    pause = 0.0
    while not done():
        wait.look()
        time.sleep(pause)
        pause = min(pause + 1e-4, 5e-3)
