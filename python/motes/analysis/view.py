"""Live view of a run, read from its growing log. Needs no pandas."""

from __future__ import annotations

import math
import socket
import time
from collections import deque
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from .._io.text import printable
from .._run import progress
from .._values.space import CURVES, in_a_row
from ._tables.schema import EVENTS, FRAMES, LOAD, TIMES, WAITS
from ._tables.stretches import latest
from ._tables.tables import Follower
from .factors import COLUMNS, factors

__all__ = ["SPARKS", "View"]

Row = dict[str, Any]
SPARKS = "▁▂▃▄▅▆▇█"


class View:
    """Live state of a run."""

    def __init__(self, path: Path, facts: Mapping[str, Any]) -> None:
        """Set the log's directory and the run's facts."""
        self.path = path
        self.facts = latest(facts)
        self._frames, self._load, self._events, self._times, self._waits = (
            Follower(path / table.file, table.columns) for table in (FRAMES, LOAD, EVENTS, TIMES, WAITS)
        )
        self.waited: dict[tuple[int, int], float] = {}
        """Seconds that a rank has waited for another, since the run began."""
        self._forget()

    def _forget(self) -> None:
        self.ended = False
        self.frame: dict[str, Any] | None = None
        self.load: dict[tuple[str, int], dict[str, Any]] = {}
        self.efficiency: dict[str, float] = {}
        self.wait: dict[str, Any] | None = None
        self._latest = _Latest(), _Latest()
        self.imbalances: deque[float] = deque(maxlen=240)
        self._seconds: deque[float] = deque(maxlen=1000)
        self._last_news = time.monotonic()
        self.events: deque[str] = deque(maxlen=3)

    def read(self) -> bool:
        """Read what the run wrote since the last call; return whether there is a new frame."""
        frames, load, events = (table.new_rows() for table in (self._frames, self._load, self._events))
        if self._frames.restarted or self._events.restarted:
            self._forget()
        for row in events:
            self.ended = self.ended or row.get("kind") == "end"
            if row.get("kind") not in ("start", "end"):
                self.events.append(
                    f"frame {row.get('frame')}: {row.get('kind')} {row.get('text', '')}".rstrip()
                )
        for row in frames:
            self.imbalances.append(float(row.get("imbalance") or 1.0))
            self._seconds.append(float(row.get("t_frame_s") or 0.0))
            self.frame = row
        for row in load:
            self.load[row["system"], row["rank"]] = row
        if load:  # drop ranks of an earlier start; the last frame may be incomplete
            recent = max(row["frame"] for row in load) - 1
            self.load = {key: row for key, row in self.load.items() if row["frame"] >= recent}
        self._note_times()
        if frames or load or events:
            self._last_news = time.monotonic()
        return bool(frames)

    def _note_times(self) -> None:
        """Store POP's factors of the last complete frame, and its longest wait for another rank."""
        times, waits = self._latest
        for before, now in times.ended(self._times.new_rows()):
            seconds = [float(row.get("wall_s") or 0.0) - float(row.get("recovery_s") or 0.0) for row in now]
            idle = [float(row.get("wait_s") or 0.0) + float(row.get("messages_s") or 0.0) for row in now]
            work = [max(one - lost, 0.0) for one, lost in zip(seconds, idle, strict=True)]
            start, end = (
                max((float(row.get("chain_s") or 0.0) for row in rows), default=0.0) for rows in (before, now)
            )
            chain = end - start if end > start else end
            self.efficiency = dict(zip(COLUMNS, factors(work, max(seconds), chain), strict=True))
        new = self._waits.new_rows()
        if self._waits.restarted:  # all rows are new: a continued run has written them again
            self.waited = {}
        for row in new:
            if (row.get("waited_for") or 0) >= 0:
                pair = int(row["rank"]), int(row["waited_for"] or 0)
                self.waited[pair] = self.waited.get(pair, 0.0) + float(row.get("seconds") or 0.0)
        for _, now in waits.ended(new):
            waiting = [row for row in now if (row.get("waited_for") or 0) >= 0]
            self.wait = max(waiting, key=lambda row: float(row.get("seconds") or 0.0), default=None)

    @property
    def silent_s(self) -> float:
        """Seconds since this view last saw the log grow."""
        return time.monotonic() - self._last_news

    @property
    def fps(self) -> float:
        """Frames per second over the last second or two."""
        total, n = 0.0, 0
        for seconds in reversed(self._seconds):
            total, n = total + seconds, n + 1
            if total >= 2.0:
                break
        return n / total if total > 0 else 0.0

    def process_is_gone(self) -> bool:
        """Whether the manager ran on this host and its process is gone."""
        pid = self.facts.get("pid")
        if not isinstance(pid, int) or self.facts.get("host") != socket.gethostname():
            return False
        return not Path(f"/proc/{pid}").exists() and Path("/proc/self").exists()

    def line(self) -> str:
        """Return the last frame in one line."""
        zero = dict.fromkeys(("frame", "particles", "exchanged", "dropped"), 0)
        row: dict[str, Any] = {**zero, "slowest_rank": "?", "imbalance": 1}
        row |= {name: value for name, value in (self.frame or {}).items() if value is not None}
        if not row["imbalance"] > 0:
            row["imbalance"] = 1
        return printable(progress.line(row, total=0, fps=self.fps))

    def figures(self) -> dict[str, Any]:
        """Return the view as plain values, for the last frame and per rank."""
        ranks = {rank: {"t_compute_s": 0.0, "particles": 0} for rank in self._ranks()}
        for (_, rank), row in self.load.items():
            ranks[rank]["t_compute_s"] += float(row.get("t_compute_s") or 0.0)
            ranks[rank]["particles"] += int(row.get("n_end") or 0)
        last = {
            name: (self.frame or {}).get(name) for name in ("frame", "particles", "imbalance", "exchanged")
        }
        by_rank = [{"rank": rank, **values} for rank, values in ranks.items()]
        return {
            "run": str(self.path),
            "ended": self.ended,
            **last,
            "frames_per_s": self.fps,
            "efficiency": self.efficiency,
            "ranks": by_rank,
        }

    def lines(self, width: int, *, plain: bool = False) -> list[str]:
        """Draw the run in a terminal of this width; `plain`: ASCII only.

        Control characters in names from the log are escaped.
        """
        lines = [printable(line) for line in self._drawn(width, plain)]
        if plain:
            lines = [line.encode("ascii", "backslashreplace").decode() for line in lines]
        return [line[:width] for line in lines]

    def _drawn(self, width: int, plain: bool) -> list[str]:
        facts = self.facts
        space = facts.get("space")
        where = "infinite space" if space is None else f"space {space}"
        head = f"{self.path}  {facts.get('balancer') or 'Static()'}  {where}"
        if self.frame is None:
            return [head[:width], "no frames yet"]
        lines = [head[:width], self.line()[:width]]
        lines += ["imbalance " + _sparks(self.imbalances, width - 22, plain), ""]
        lines += self._pop(width)
        lines += self._bars(width, plain)
        for system in dict.fromkeys(name for name, _ in self.load):
            lines += self._domains(system, width, plain)
        lines += [text[:width] for text in self.events]
        return lines

    def _pop(self, width: int) -> list[str]:
        """Return the lines with POP's factors and with the longest wait."""
        lines = []
        if self.efficiency and not math.isnan(self.efficiency["parallel"]):
            shown = {name: f"{value:.0%}" for name, value in self.efficiency.items()}
            lines.append(
                "parallel efficiency {parallel} = load balance {load_balance} x serialisation {serialisation}"
                " x transfer {transfer}".format(**shown)
            )
        if self.wait is not None:
            wait = {**self.wait, "ms": 1e3 * float(self.wait.get("seconds") or 0.0)}
            text = "longest wait: rank {rank} for rank {waited_for}, {phase}, {ms:.3g} ms"
            lines.append(text.format(**wait))
        return [line[:width] for line in lines] + [""] * bool(lines)

    def _bars(self, width: int, plain: bool) -> list[str]:
        rows = self.figures()["ranks"]
        longest = max((row["t_compute_s"] for row in rows), default=0.0) or 1.0
        room = max(width - 40, 8)
        full, rest = ("#", ".") if plain else ("█", "░")
        lines = []
        for row in rows:
            part = round(room * row["t_compute_s"] / longest)
            bar = full * part + rest * (room - part)
            figures = f"{row['t_compute_s'] * 1e3:8.2f} ms {row['particles']:11,d}"
            lines.append(f"rank {row['rank']:<4} {bar} {figures}")
        return [text.replace(",", " ")[:width] for text in lines]

    def _ranks(self) -> list[int]:
        there = {rank for _, rank in self.load}
        known = [rank for rank in self.facts.get("calculators") or [] if rank in there]
        return [*known, *sorted(there.difference(known))]

    def _domains(self, system: str, width: int, plain: bool) -> list[str]:
        axes = dict(zip(self.facts.get("systems") or [], self.facts.get("axes") or [], strict=False))
        if not in_a_row(along := axes.get(system, "x")):
            return []  # a strip can show only domains in a row
        rows = [self.load[system, rank] for rank in self._ranks() if (system, rank) in self.load]
        cuts = [float(row["domain_hi"]) for row in rows[:-1] if row.get("domain_hi") is not None]
        if not cuts or len(cuts) < len(rows) - 1:
            return []
        low, high = _extent(cuts, [0.0, 1.0] if along in CURVES else self.facts.get("space"))
        room = max(width - 2, 10)
        places = [round((room - 1) * (cut - low) / (high - low)) for cut in cuts]
        strip = [" "] * room
        edges = [0, *places, room]
        for rank, left, right in zip(self._ranks(), edges, edges[1:], strict=False):
            name = str(rank)
            middle = (left + right - len(name)) // 2
            if right - left > len(name):
                strip[middle : middle + len(name)] = name
        for place in places:
            strip[min(max(place, 0), room - 1)] = "|" if plain else "│"
        ends = f"{low:.4g}", f"{high:.4g}" + ("" if along in CURVES else " m")
        label = f"{ends[0]}  domains of {system}"
        return ["", "".join(strip).rstrip(), (label + ends[1].rjust(max(room - len(label), 1)))[:width]]


class _Latest:
    """Rows of the last two frames of a growing table."""

    def __init__(self) -> None:
        self._before: list[Row] = []
        self._now: list[Row] = []

    def ended(self, rows: list[Row]) -> Iterator[tuple[list[Row], list[Row]]]:
        """Add new rows; for each completed frame, yield the previous frame's rows and its own."""
        for row in rows:
            if self._now and row["frame"] != self._now[-1]["frame"]:
                yield self._before, self._now
                self._before, self._now = self._now, []
            self._now.append(row)


def _extent(cuts: list[float], space: Any) -> tuple[float, float]:
    low, high = min(cuts), max(cuts)
    if isinstance(space, (list, tuple)):
        low, high = min(low, float(space[0])), max(high, float(space[1]))
        if high > low:
            return low, high
    margin = (high - low) / max(len(cuts) - 1, 1) or 1.0
    return low - margin, high + margin


def _sparks(values: deque[float], width: int, plain: bool) -> str:
    shown = list(values)[-max(width, 10) :]
    most = max(shown)
    text = f"{shown[-1]:.2f}"
    if plain:
        return text
    reach = max(most - 1, 0.05)
    marks = (SPARKS[min(int(8 * max(value - 1, 0) / reach), 7)] for value in shown)
    return f"{text} {''.join(marks)} {most:.2f}"
