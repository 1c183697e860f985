"""Wait for other ranks, with warnings and a limit; the core's own waits follow the same rules.

While the other process lives, a wait warns once per minute and continues. It ends if that process is gone, or
after ten minutes if this host cannot tell. `MOTES_STALL_S` sets a limit that applies even to live processes.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from .._io.output import tell
from ..errors import MotesError

__all__ = ["Wait", "poll", "warn_s"]

WARN_S = 60.0  # between two warnings of a wait
UNKNOWN = 10.0  # limit of a wait, in units of WARN_S, if it is unknown whether the process lives


class Wait:
    """The seconds of one wait, except time in which this process was suspended (Ctrl-Z, a laptop's lid).

    The other processes may have been suspended, too. Which ones they are is not known here.
    """

    def __init__(self, limit_s: float | None, what: str) -> None:
        """Start a wait; `limit_s`: MOTES_STALL_S or None; `what` completes "waited ... s for" in messages."""
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
        # A longer gap means that this process did not run. On an overloaded machine that is normal, so a gap
        # counts, but only a little.
        self.waited_s += min(now - self._last, 1.0, min(self.limit_s or WARN_S, WARN_S) / 4)
        self._last = now
        waited = f"waited {self.waited_s:.0f} s for {self.what}"
        if self.limit_s is not None and self.waited_s > self.limit_s:
            raise MotesError(
                f"{waited} (the limit was set by MOTES_STALL_S={self.limit_s:g}: increase it, or unset it)"
            )
        if self.limit_s is None and self.waited_s > UNKNOWN * WARN_S:
            raise MotesError(f"{waited} (MOTES_STALL_S=seconds changes the limit)")
        if self.waited_s > self._next_warning_s:
            self._next_warning_s += WARN_S
            origin = "MOTES_STALL_S=seconds changes the limit"
            if self.limit_s is not None:
                origin = f"set by MOTES_STALL_S={self.limit_s:g}"
            tell(f"motes: {waited}; it waits for {self.limit_s or UNKNOWN * WARN_S:g} s in total ({origin})")


def warn_s(limit_s: float | None) -> float:
    """Return the seconds after which other ranks warn about a rank that does not answer."""
    return min(limit_s or WARN_S, WARN_S)


def poll(done: Callable[[], bool], wait: Wait) -> None:
    """Call `done` until it returns true, with growing pauses."""
    pause = 0.0
    while not done():
        wait.look()
        time.sleep(pause)
        pause = min(pause + 1e-4, 5e-3)
