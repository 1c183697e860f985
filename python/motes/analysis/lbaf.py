"""Export of a run as load data for LBAF, the Load Balancing Analysis Framework of the DARMA project.

Writes one JSON file per rank, NAME.RANK.json, in vt's format "LBDatafile" (docs/md/node-lb-data.md in vt). A
frame is a phase. A calculator's particles of each system form 16 migratable tasks along the axis, as in
density.jsonl, with equal shares of its seconds. All other work of a rank is one task that cannot migrate.
Migrants are messages between the tasks on both sides of a cut.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._io import files
from ..errors import LogError
from .efficiencies import work_by_rank

if TYPE_CHECKING:
    from .run import Run

__all__ = ["PARTS", "write_lbaf"]

Task = dict[str, Any]
_BYTES = {"task_footprint_bytes": 0.0, "task_working_bytes": 0.0}
"""LBAF 1.0 cannot read a task with other facts of its user unless it has these."""
PARTS = 16
"""Migratable tasks per system and calculator."""


def write_lbaf(run: Run, directory: str | os.PathLike[str], name: str = "motes") -> list[Path]:
    """Write the files; return their paths in the order of ranks."""
    if run.frames.empty or run.load.empty:
        raise run.lacks_rows()
    folder = Path(directory)
    load = _by_frame_and_rank(run)
    work = {} if run.times.empty else work_by_rank(run.times).fillna(0.0).to_dict("index")
    paths = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for rank in range(run.ranks):
            phases = []
            for frame in map(int, run.frames["frame"]):
                rows = load.get((frame, rank), [])
                phases.append(_phase(run, frame, rank, rows, float(work.get(frame, {}).get(rank, 0.0))))
            about: dict[str, Any] = {"type": "LBDatafile"}
            data = {**about, "metadata": {**about, "rank": rank}, "phases": phases}
            paths.append(folder / f"{name}.{rank}.json")
            files.write_whole(paths[-1], json.dumps(data).encode())
    except OSError as error:
        raise LogError(f"{folder}: cannot write load data: {error.strerror or error}") from error
    return paths


def _by_frame_and_rank(run: Run) -> dict[tuple[int, int], list[Task]]:
    tasks: dict[tuple[int, int], list[Task]] = {}
    columns = ["frame", "rank", "system", "t_compute_s", "bytes_sent"]
    row: Any
    for row in run.load[columns].fillna(0.0).to_dict("records"):
        tasks.setdefault((int(row["frame"]), int(row["rank"])), []).append({**row})
    return tasks


def _phase(run: Run, frame: int, rank: int, rows: list[Task], work_s: float) -> dict[str, Any]:
    acted = sum(float(row["t_compute_s"]) for row in rows)
    tasks = [_task(_rest(run, rank), rank, max(work_s - acted, 0.0), "all other work")]
    tasks[0]["entity"]["migratable"] = False
    sent = []
    for row in rows:
        system = run.systems.index(row["system"])
        first = _id(run, system, rank)
        each = float(row["t_compute_s"]) / PARTS
        tasks += [_task(first + part, rank, each, str(row["system"])) for part in range(PARTS)]
        sent += list(_messages(run, system, rank, float(row["bytes_sent"])))
    return {"id": frame, "tasks": tasks, "communications": sent}


def _id(run: Run, system: int, rank: int) -> int:
    return (system * run.ranks + rank) * PARTS


def _rest(run: Run, rank: int) -> int:
    return _id(run, len(run.systems), 0) + rank


def _entity(number: int, rank: int) -> Task:
    return {"home": rank, "id": number, "migratable": True, "type": "object"}


def _task(number: int, rank: int, seconds: float, name: str) -> Task:
    task = {"entity": _entity(number, rank), "node": rank, "resource": "cpu", "time": seconds}
    return {**task, "user_defined": {"name": name, **_BYTES}}


def _messages(run: Run, system: int, rank: int, sent: float) -> Iterator[Task]:
    """Yield messages from a calculator to its neighbours along the axis, which get equal shares of bytes."""
    order = run.calculators
    if sent <= 0 or run.axis(run.systems[system]) not in ("x", "y", "z"):
        return
    at = order.index(rank)
    sides = [(at - 1, 0, PARTS - 1), (at + 1, PARTS - 1, 0)]
    there = [(order[to], own, other) for to, own, other in sides if 0 <= to < len(order)]
    for to, own, other in there:
        yield {
            "type": "SendRecv",
            "from": _entity(_id(run, system, rank) + own, rank),
            "to": _entity(_id(run, system, to) + other, to),
            "messages": 1,
            "bytes": sent / len(there),
        }
