"""`python -m motes watch RUN`: a run in another terminal, from its log as it grows. Needs no pandas."""

from __future__ import annotations

import json
import os
import shutil
import socket
import sys
import time
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TextIO

from .._run import progress
from ..errors import LogError
from .tables import Follower, read_facts

__all__ = ["View", "main"]

EVERY_S = 0.5
LINE_EVERY_S = 1.0
SILENT_S = 120.0
"""A log in which nothing was written for so long belongs to a run that is dead: ranks give up after 60 s."""

_SPARKS = "▁▂▃▄▅▆▇█"


def main(
    path: str, *, once: bool = False, as_json: bool = False, wait_s: float = 10.0, out: TextIO | None = None
) -> int:
    """Show the run until it ends; 0, or 1 where it was killed. Ctrl-C ends this, not the run.

    `once`: what there is now, and end; `as_json`: the same as one JSON object.
    """
    out = sys.stdout if out is None else out
    try:
        if as_json:
            view = View(Path(path), read_facts(Path(path)))
            view.read()
            print(json.dumps(view.figures()), file=out, flush=True)
            return 0
        return _watch(Path(path), once=once, wait_s=wait_s, out=out)
    except KeyboardInterrupt:
        return 0
    except BrokenPipeError:
        # Whoever read this (a pager, head) has gone; nothing more is to be said, at exit neither.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _watch(path: Path, *, once: bool, wait_s: float, out: TextIO) -> int:
    view = View(path, _facts_when_there(path, 0.0 if once else wait_s))
    screen = _Screen(out)
    if once:
        view.read()
        screen.print_whole(view)
        return 0
    while True:
        dead = view.process_is_gone()  # asked before reading: what it wrote last is read below
        view.read()
        over = view.ended or dead or view.silent_s > SILENT_S
        screen.show(view, last=over)
        if view.ended:
            return 0
        if dead or view.silent_s > SILENT_S:
            why = "its process is gone" if dead else f"nothing was written for {view.silent_s:.0f} s"
            print(f"motes: {path}: the run did not come to its end: {why}", file=sys.stderr)
            return 1
        time.sleep(EVERY_S)


def _facts_when_there(path: Path, wait_s: float) -> dict[str, Any]:
    limit = time.monotonic() + wait_s
    while True:
        try:
            return read_facts(path)
        except LogError:
            if time.monotonic() >= limit:
                raise
            time.sleep(EVERY_S / 2)


class View:
    """What is known of a run while it goes on."""

    def __init__(self, path: Path, facts: Mapping[str, Any]) -> None:
        """Take the log's directory and the run's facts."""
        self.path = path
        self.facts = facts
        self._frames = Follower(path / "frames.jsonl")
        self._load = Follower(path / "load.jsonl")
        self._events = Follower(path / "events.jsonl")
        self._forget()

    def _forget(self) -> None:
        self.ended = False
        self.frame: dict[str, Any] | None = None
        self.load: dict[tuple[str, int], dict[str, Any]] = {}
        self.imbalances: deque[float] = deque(maxlen=240)
        self._seconds: deque[float] = deque(maxlen=1000)
        self._last_news = time.monotonic()
        self.events: deque[str] = deque(maxlen=3)

    def read(self) -> bool:
        """Read what the run wrote since the last call; whether there is a new frame."""
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
        if frames or load or events:
            self._last_news = time.monotonic()
        return bool(frames)

    @property
    def silent_s(self) -> float:
        """Seconds since something was written, as far as this view has seen."""
        return time.monotonic() - self._last_news

    @property
    def fps(self) -> float:
        """Frames a second over the last second or two."""
        total, n = 0.0, 0
        for seconds in reversed(self._seconds):
            total, n = total + seconds, n + 1
            if total >= 2.0:
                break
        return n / total if total > 0 else 0.0

    def process_is_gone(self) -> bool:
        """Whether the manager ran on this host and its process is no more."""
        pid = self.facts.get("pid")
        if not isinstance(pid, int) or self.facts.get("host") != socket.gethostname():
            return False
        return not Path(f"/proc/{pid}").exists() and Path("/proc/self").exists()

    def line(self) -> str:
        """Tell of the last frame in one line."""
        row = {"slowest_rank": "?", "dropped": 0, "exchanged": 0, "particles": 0, "imbalance": 1, "frame": 0}
        row |= {name: value for name, value in (self.frame or {}).items() if value is not None}
        return progress.line(row, total=0, fps=self.fps)

    def figures(self) -> dict[str, Any]:
        """Return what is seen, as plain values: of the last frame, and by rank."""
        ranks = {rank: {"t_compute_s": 0.0, "particles": 0} for rank in self._ranks()}
        for (_, rank), row in self.load.items():
            ranks[rank]["t_compute_s"] += float(row.get("t_compute_s") or 0.0)
            ranks[rank]["particles"] += int(row.get("n_end") or 0)
        told = {
            name: (self.frame or {}).get(name) for name in ("frame", "particles", "imbalance", "exchanged")
        }
        by_rank = [{"rank": rank, **values} for rank, values in ranks.items()]
        return {
            "run": str(self.path),
            "ended": self.ended,
            **told,
            "frames_per_s": self.fps,
            "ranks": by_rank,
        }

    def lines(self, width: int, *, plain: bool = False) -> list[str]:
        """Draw the run in a terminal of this width; `plain`: ASCII only."""
        told = self.facts
        space = told.get("space")
        where = "infinite space" if space is None else f"space {space}"
        head = f"{self.path}  {told.get('balancer') or 'Static()'}  {where}"
        if self.frame is None:
            return [head[:width], "no frame yet"]
        made = [head[:width], self.line()[:width]]
        made += ["imbalance " + _sparks(self.imbalances, width - 22, plain), ""]
        made += self._bars(width, plain)
        for system in dict.fromkeys(name for name, _ in self.load):
            made += self._domains(system, width, plain)
        made += [text[:width] for text in self.events]
        return made

    def _bars(self, width: int, plain: bool) -> list[str]:
        rows = self.figures()["ranks"]
        longest = max((row["t_compute_s"] for row in rows), default=0.0) or 1.0
        room = max(width - 40, 8)
        full, rest = ("#", ".") if plain else ("█", "░")
        made = []
        for row in rows:
            part = round(room * row["t_compute_s"] / longest)
            bar = full * part + rest * (room - part)
            figures = f"{row['t_compute_s'] * 1e3:8.2f} ms {row['particles']:11,d}"
            made.append(f"rank {row['rank']:<4} {bar} {figures}")
        return [text.replace(",", " ")[:width] for text in made]

    def _ranks(self) -> list[int]:
        there = {rank for _, rank in self.load}
        told = [rank for rank in self.facts.get("calculators") or [] if rank in there]
        return told or sorted(there)

    def _domains(self, system: str, width: int, plain: bool) -> list[str]:
        rows = [self.load[system, rank] for rank in self._ranks() if (system, rank) in self.load]
        cuts = [float(row["domain_hi"]) for row in rows[:-1] if row.get("domain_hi") is not None]
        if not cuts or len(cuts) < len(rows) - 1:
            return []
        low, high = _extent(cuts, self.facts.get("space"))
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
        ends = f"{low:.4g}", f"{high:.4g} m"
        words = f"{ends[0]}  domains of {system}"
        return ["", "".join(strip).rstrip(), (words + ends[1].rjust(max(room - len(words), 1)))[:width]]


def _extent(cuts: list[float], space: Any) -> tuple[float, float]:
    low, high = min(cuts), max(cuts)
    if isinstance(space, (list, tuple)):
        return min(low, float(space[0])), max(high, float(space[1]))
    margin = (high - low) / max(len(cuts) - 1, 1) or 1.0
    return low - margin, high + margin


def _sparks(values: deque[float], width: int, plain: bool) -> str:
    shown = list(values)[-max(width, 10) :]
    most = max(shown)
    text = f"{shown[-1]:.2f}"
    if plain:
        return text
    reach = max(most - 1, 0.05)
    marks = (_SPARKS[min(int(8 * max(value - 1, 0) / reach), 7)] for value in shown)
    return f"{text} {''.join(marks)} {most:.2f}"


class _Screen:
    """Redraws in place on a terminal; elsewhere a line now and then."""

    def __init__(self, out: TextIO) -> None:
        self._out = out
        self._live = out.isatty() and os.environ.get("TERM", "") not in ("", "dumb")
        self._drawn = 0
        self._said = -LINE_EVERY_S
        self._frame: int | None = None
        try:
            _SPARKS.encode(out.encoding or "ascii")
            self._plain = False
        except (UnicodeEncodeError, LookupError):
            self._plain = True

    def show(self, view: View, *, last: bool) -> None:
        if self._live:
            self._redraw(view)
        else:
            self._tell(view, last=last)

    def print_whole(self, view: View) -> None:
        """Print the view once, without moving the cursor: for a file, a notebook, a mail."""
        width = shutil.get_terminal_size().columns - 1
        print("\n".join(view.lines(width, plain=self._plain)), file=self._out, flush=True)

    def _redraw(self, view: View) -> None:
        size = shutil.get_terminal_size()
        lines = view.lines(size.columns - 1, plain=self._plain)[: max(size.lines - 1, 3)]
        up = f"\x1b[{self._drawn}F" if self._drawn else ""
        self._out.write(up + "".join(f"{line}\x1b[K\n" for line in lines) + "\x1b[J")
        self._out.flush()
        self._drawn = len(lines)

    def _tell(self, view: View, *, last: bool) -> None:
        now = time.monotonic()
        number = None if view.frame is None else view.frame.get("frame")
        if number is None or number == self._frame or (not last and now - self._said < LINE_EVERY_S):
            return
        self._said, self._frame = now, number
        print(view.line(), file=self._out, flush=True)
