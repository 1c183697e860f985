"""What the blackboard shows: who has how much to do and who waits for whom, from the run's log."""

from __future__ import annotations

import asyncio
import math
import sys
import time
from collections import deque
from pathlib import Path
from typing import Any

from ..analysis._tables.tables import read_facts
from ..analysis.view import View
from ..errors import LogError

__all__ = ["Board"]

MOST_POINTS = 240
EXPLAIN_S = 20.0  # between two explanations, which take a second of another process
_EXPLAIN = (
    "import sys; from motes.analysis import open_run; print(open_run(sys.argv[1]).explain().sentences[0])"
)


class Board:
    """The log of one take."""

    def __init__(self, path: Path, take: int) -> None:
        """Read the log in this directory."""
        self.path = path
        self.take = take
        self._view: View | None = None
        self._course: deque[tuple[int, float, float, float]] = deque(maxlen=MOST_POINTS)
        self._sentence = ""
        self._due_s = 0.0  # when the next explanation is due; infinite: the last one has been made
        self._explaining: asyncio.Task[None] | None = None

    async def look(self, *, last: bool) -> dict[str, Any]:
        """Read what is new, in a thread, and return all figures; `last`: the run has ended."""
        try:
            told = await asyncio.to_thread(self._look)
        except (OSError, LogError):
            return {"missing": True}
        now = time.monotonic()
        idle = self._explaining is None or self._explaining.done()
        due = now >= self._due_s or (last and self._due_s < math.inf)
        if idle and told["frame"] is not None and due:
            self._due_s = math.inf if last else now + EXPLAIN_S
            self._explaining = asyncio.create_task(self._explain())
        return {**told, "sentence": self._sentence}

    def _look(self) -> dict[str, Any]:
        if self._view is None:
            self._view = View(self.path, read_facts(self.path))
        view = self._view
        view.read()
        figures, frame = view.figures(), view.frame or {}
        moved = sum(int(frame.get(name) or 0) for name in ("exchanged_bytes", "render_bytes"))
        if frame and (not self._course or self._course[-1][0] != frame["frame"]):
            parallel = figures["efficiency"].get("parallel", float("nan"))
            self._course.append((frame["frame"], float(frame.get("imbalance") or 1), parallel, moved))
        return {
            "frame": frame.get("frame"),
            "ranks": figures["ranks"],
            "imbalance": frame.get("imbalance"),
            "efficiency": _plain(figures["efficiency"]),
            "bytes": moved,
            "waits": [[*pair, seconds] for pair, seconds in sorted(view.waited.items())],
            "course": [[_number(one) for one in point] for point in self._course],
            "domains": [_domain(row) for row in view.load.values()],
            "slowest": frame.get("slowest_rank"),
        }

    async def _explain(self) -> None:
        """Let another process explain the run so far, at the lowest priority."""
        nice = ["nice", "-n", "19"] if sys.platform != "win32" else []
        process = await asyncio.create_subprocess_exec(
            *nice,
            *(sys.executable, "-c", _EXPLAIN, str(self.path)),
            stdin=asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.DEVNULL,
        )
        try:
            out, _ = await process.communicate()
        except asyncio.CancelledError:
            process.kill()
            raise
        if process.returncode == 0:
            self._sentence = out.decode(errors="replace").strip()


def _domain(row: dict[str, Any]) -> list[Any]:
    ends = [row.get(f"domain_{axis}{end}") for axis in ("", "y_", "z_") for end in ("lo", "hi")]
    return [row["system"], row["rank"], *ends]


def _number(value: float) -> float | None:
    return value if value == value and abs(value) < 1e300 else None


def _plain(values: dict[str, float]) -> dict[str, float | None]:
    return {name: _number(value) for name, value in values.items()}
