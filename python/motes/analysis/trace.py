"""Export of a run as a trace for ui.perfetto.dev and chrome://tracing.

The format is Chrome's "Trace Event Format" in JSON: complete events ("X") whose slices nest within a thread,
counters ("C"), names ("M"); times in microseconds.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._io import files
from ._plots import timeline
from ._plots.drawing import UNDER_WAY
from ._tables.stretches import latest

if TYPE_CHECKING:
    from .run import Run

__all__ = ["write_trace"]

Event = dict[str, Any]
Slice = tuple[int, int, str, dict[str, Any]]
_MESSAGES = 100
"""First thread for messages in flight; the rank's work meanwhile is in lower-numbered threads."""
_RUN = 1_000_000
"""Process number for the whole run; each rank is shown as a process."""
_FIRST = 1
"""Process number of rank 0. Number 0 is the idle process to Perfetto."""


def write_trace(run: Run, path: str | os.PathLike[str]) -> Path:
    """Write the trace atomically; return its path."""
    if run.frames.empty:
        raise run.lacks_rows()
    target = Path(path)
    with files.whole_file(target, "w", encoding="utf-8") as file:
        file.write('{"displayTimeUnit": "ms", "otherData": ')
        json.dump({"run": run.name, "balancer": run.balancer}, file)
        file.write(', "traceEvents": [\n')
        for number, event in enumerate(_events(run)):
            file.write((",\n" if number else "") + json.dumps(event))
        file.write("\n]}\n")
    return target


def _events(run: Run) -> Iterator[Event]:
    starts = timeline.frame_starts(run)
    slices, measured = timeline.slices(run)
    origin = min(start for start, _ in starts.values())
    phases: dict[int, list[Slice]] = {}
    messages: dict[int, list[Slice]] = {}
    waited = slices["phase"] == "wait" if measured else slices["phase"].isna()
    for row in slices[~waited].to_dict("records"):
        details = {"frame": int(row["frame"]), **({"system": row["system"]} if row["system"] else {})}
        name = f"{row['phase']} {row['system'] or ''}".rstrip()
        slice_ = (_ns(row["start_s"] - origin), _ns(row["end_s"] - origin), name, details)
        chosen = messages if row["phase"] == UNDER_WAY else phases
        chosen.setdefault(int(row["rank"]), []).append(slice_)
    arrows = list(_waits(run, origin, phases)) if measured else []
    yield from _process(_RUN, f"run {run.name}", -1)
    whole = [(_ns(a - origin), _ns(b - origin), f"frame {f}", {"frame": f}) for f, (a, b) in starts.items()]
    yield from _thread(_RUN, whole, "frames")
    for rank in sorted(set(phases) | set(run.hosts)):
        yield from _process(_FIRST + rank, _who(run, rank), rank)
        yield from _thread(
            _FIRST + rank, phases.get(rank, []), "phases" if measured else "phases, reconstructed"
        )
        yield from _thread(_FIRST + rank, messages.get(rank, []), "messages in flight", first=_MESSAGES)
    yield from arrows
    yield from _counters(run, {frame: _ns(end - origin) for frame, (_, end) in starts.items()})
    for row in run.events.to_dict("records"):
        if row["kind"] not in ("start", "end") and int(row["frame"]) in starts:
            at = _ns(starts[int(row["frame"])][0] - origin)
            yield _event("i", _RUN, str(row["kind"]), at, s="p", args={"text": str(row["text"])})


def _waits(run: Run, origin: float, phases: dict[int, list[Slice]]) -> Iterator[Event]:
    """Add each wait to `phases` as a nested slice; yield arrows from the rank waited for to its end."""
    waits = run.spans[run.spans["phase"] == "wait"]
    numbered = enumerate(waits.dropna(subset=["waited_for"]).to_dict("records"))
    for number, row in numbered:
        rank, other = int(row["rank"]), int(row["waited_for"])
        start, end = _ns(row["start_s"] - origin), _ns(row["end_s"] - origin)
        whom = "several ranks" if other < 0 else f"rank {other}"
        details = {"frame": int(row["frame"]), "waited for": whom, "message": str(row["message"])}
        phases.setdefault(rank, []).append((start, end, f"wait for {whom}", details))
        if other < 0:
            continue
        arrow = {"id": number, "cat": "wait", "args": details}
        yield _event("s", _FIRST + other, str(row["message"]), end, **arrow)
        yield _event("f", _FIRST + rank, str(row["message"]), end, bp="e", **arrow)


def _who(run: Run, rank: int) -> str:
    facts = latest(run.facts)
    roles = [name.replace("_", " ") for name in ("manager", "image_generator") if facts.get(name) == rank]
    if rank in run.calculators:
        roles.append(f"calculator {run.calculators.index(rank)}")
    host = run.hosts.get(rank, "")
    return f"rank {rank} ({', '.join(roles)})" + (f" on {host}" if host else "")


def _ns(seconds: float) -> int:
    return round(float(seconds) * 1e9)


def _event(kind: str, pid: int, name: str, at_ns: int, **more: Any) -> Event:
    return {"ph": kind, "pid": pid, "tid": 0, "name": name, "ts": at_ns / 1e3, **more}


def _process(pid: int, name: str, position: int) -> Iterator[Event]:
    yield {"ph": "M", "pid": pid, "tid": 0, "name": "process_name", "args": {"name": name}}
    yield {
        "ph": "M",
        "pid": pid,
        "tid": 0,
        "name": "process_sort_index",
        "args": {"sort_index": position},
    }


def _thread(pid: int, slices: Iterable[Slice], name: str, *, first: int = 0) -> Iterator[Event]:
    """Yield a process's slices in threads from `first` on; slices that overlap but do not nest get more."""
    lanes: list[list[int]] = []
    for start, end, label, details in sorted(slices, key=lambda one: (one[0], -one[1])):
        lane = _lane_for(lanes, start, end)
        if lane == len(lanes):
            lanes.append([])
            title = name if lane == 0 else f"{name}, overlapping"
            tid = first + lane
            yield {"ph": "M", "pid": pid, "tid": tid, "name": "thread_name", "args": {"name": title}}
        lanes[lane].append(end)
        event = _event("X", pid, label, start, dur=(end - start) / 1e3, cat=label.partition(" ")[0])
        yield {**event, "tid": first + lane, "args": details}


def _lane_for(lanes: list[list[int]], start: int, end: int) -> int:
    """Return the first thread in which [start, end] is disjoint from, or nested in, all open slices."""
    for i, ends in enumerate(lanes):
        while ends and ends[-1] <= start:
            ends.pop()
        if not ends or end <= ends[-1]:
            return i
    return len(lanes)


def _counters(run: Run, at_ns: dict[int, int]) -> Iterator[Event]:
    for row in run.frames[["frame", "imbalance", "exchanged"]].fillna(0.0).to_dict("records"):
        if int(row["frame"]) not in at_ns:
            continue
        at = at_ns[int(row["frame"])]
        yield _event("C", _RUN, "imbalance", at, args={"largest / mean": float(row["imbalance"])})
        yield _event("C", _RUN, "exchanged", at, args={"particles": int(row["exchanged"])})
    held: dict[tuple[int, int], dict[str, int]] = {}
    for row in run.load[["frame", "rank", "system", "n_end"]].fillna(0).to_dict("records"):
        frame, system, n = int(row["frame"]), str(row["system"]), int(row["n_end"])
        if frame not in at_ns:
            continue
        held.setdefault((frame, _FIRST + int(row["rank"])), {})[system] = n
        whole = held.setdefault((frame, _RUN), {})
        whole[system] = whole.get(system, 0) + n
    for (frame, process), particles in held.items():
        yield _event("C", process, "particles", at_ns[frame], args=particles)
