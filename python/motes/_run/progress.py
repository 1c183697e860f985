"""The progress of a run: whole lines on the manager's standard error, at most one per second.

Launchers forward whole lines and misreport terminals, so whole lines work everywhere.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from .._io.output import tell
from .._values import environment
from ..errors import ArgumentError

__all__ = ["LINES", "Progress", "line", "reached"]

EVERY_S = 1.0
CHOICES = environment.PROGRESS
LINES = "lines"


def line(row: Mapping[str, Any], *, total: int, fps: float, host: str = "") -> str:
    """Describe a frame in one line.

    `frame 120/300  40%  2.1 fps  eta 1:25  1.93 M particles  LB 0.93  slowest r5  moved 4 012`
    """
    done = row["frame"] + 1
    parts = [reached(done, total=total, fps=fps, particles=row["particles"])]
    parts.append(f"LB {1 / row['imbalance']:.2f}")
    parts.append(f"slowest r{row['slowest_rank']}" + (f"({host})" if host else ""))
    parts.append("moved " + f"{row['exchanged']:,}".replace(",", " "))
    if row["dropped"]:
        parts.append(f"dropped {row['dropped']}")
    return "  ".join(parts)


def reached(done: int, *, total: int, fps: float, particles: int) -> str:
    """Describe how far a run is and how many particles it has: the part of `line` that every run has."""
    parts = [f"frame {done}/{total}" if total else f"frame {done}"]
    if total:
        parts.append(f"{100 * done // total}%")
    parts.append(f"{fps:.1f} fps")
    if total and fps > 0:
        left = round((total - done) / fps)
        parts.append(f"eta {left // 60}:{left % 60:02d}")
    count = f"{particles / 1e6:.2f} M" if particles >= 1_000_000 else str(particles)
    return "  ".join([*parts, f"{count} particles"])


class Progress:
    """Shows the manager's rows as "lines", as a "bar", by a user's function, or not at all ("off")."""

    def __init__(self, way: str | Callable[[dict[str, Any]], None], hosts: Sequence[str] = ()) -> None:
        """Store how to show progress, unless MOTES_PROGRESS says otherwise, and the ranks' hosts."""
        self.way = check(way)
        self.hosts = hosts if len(set(hosts)) > 1 else ()
        self._shown = -EVERY_S
        self._clock = time.monotonic()
        self._frames = 0
        self._last = -1
        self._open_bar = False

    def update(self, row: dict[str, Any] | None, *, total: int, last: bool = False) -> None:
        """Show a row if it is new and a second has passed since the last one, or if it is the last."""
        if row is None or self.way == "off" or row["frame"] == self._last:
            return
        self._last = row["frame"]
        self._frames += 1
        if callable(self.way):
            self.way(row)
            return
        now = time.monotonic()
        if not last and now - self._shown < EVERY_S:
            return
        self._shown = now
        host = self.hosts[row["slowest_rank"]] if self.hosts else ""
        fps = self._frames / max(now - self._clock, 1e-9)
        text = line(row, total=total, fps=fps, host=host)
        if self.way == "bar":
            self._open_bar = not last
            tell("\r\x1b[K" + text, end="\n" if last else "")
        else:
            tell(text)


def check(way: Any) -> str | Callable[[dict[str, Any]], None]:
    """Return how to show progress, checked; MOTES_PROGRESS takes precedence."""
    wish: str | None = environment.read("MOTES_PROGRESS")
    if wish is not None:
        return wish
    if isinstance(way, str) and way in CHOICES:
        return way
    if callable(way):
        show: Callable[[dict[str, Any]], None] = way
        return show
    raise ArgumentError("progress", way, "'lines', 'bar', 'off' or a function of a row", known=CHOICES)
