"""How long a rank has waited for another one, and when it warns and gives up; the core's own waits agree.

While the process waited for lives, a wait warns once per minute and goes on. It ends where that process is
gone, and where nobody could tell for ten minutes. `MOTES_STALL_S` sets a limit that counts whatever lives.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from .._io.output import tell
from ..errors import MotesError

__all__ = ["Wait", "poll", "warn_s"]

WARN_S = 60.0  # between two warnings of a wait
UNKNOWN = 10.0  # WARN_S, until a wait ends where nobody can tell whether a process lives


class Wait:
    """Seconds of one wait, not counting those in which this process was suspended (Ctrl-Z, a laptop's lid).

    The processes waited for may have been suspended just as long. Which ones they are is not known here.
    """

    def __init__(self, limit_s: float | None, what: str) -> None:
        """`limit_s`: None, or what MOTES_STALL_S says; `what`: "waited for ..." in messages."""
        self.limit_s = limit_s
        self.what = what
        self.waited_s = 0.0
        self._last = time.monotonic()
        self._next_warning_s = WARN_S

    def look(self) -> None:
        """Count the time since the last look; call this every few milliseconds.

        Raises MotesError if the limit has passed.
        """
        now = time.monotonic()
        # A longer gap means that this process did not run; on an overloaded machine such gaps are normal,
        # so each counts a little.
        self.waited_s += min(now - self._last, 1.0, min(self.limit_s or WARN_S, WARN_S) / 4)
        self._last = now
        waited = f"waited {self.waited_s:.0f} s for {self.what}"
        if self.limit_s is not None and self.waited_s > self.limit_s:
            raise MotesError(
                f"{waited} (the limit was set by MOTES_STALL_S={self.limit_s:g}: "
                "set more seconds, or unset it)"
            )
        if self.limit_s is None and self.waited_s > UNKNOWN * WARN_S:
            raise MotesError(f"{waited} (MOTES_STALL_S=seconds sets another limit)")
        if self.waited_s > self._next_warning_s:
            self._next_warning_s += WARN_S
            told = "MOTES_STALL_S=seconds sets another limit"
            if self.limit_s is not None:
                told = f"MOTES_STALL_S={self.limit_s:g} set that limit"
            tell(f"motes: {waited}; it waits for {self.limit_s or UNKNOWN * WARN_S:g} s in all ({told})")


def warn_s(limit_s: float | None) -> float:
    """Return after how many seconds others speak of a rank that does not answer."""
    return min(limit_s or WARN_S, WARN_S)


def poll(done: Callable[[], bool], wait: Wait) -> None:
    """Call `done` until it returns true, first in quick succession, then less and less often."""
    pause = 0.0
    while not done():
        wait.look()
        time.sleep(pause)
        pause = min(pause + 1e-4, 5e-3)
