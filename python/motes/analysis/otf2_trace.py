"""Export of a run as an OTF2 archive for Vampir, Scalasca and other tools.

Phases, and waits within them, become regions; each wait becomes a message from the rank waited for. OTF2's
own Python package writes the archive.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import _extras
from ..errors import LogError
from ._plots import timeline
from ._plots.drawing import UNDER_WAY

if TYPE_CHECKING:
    from .run import Run

__all__ = ["write_otf2"]

_ENTER, _LEAVE, _SEND, _RECEIVE = range(4)


def write_otf2(run: Run, directory: str | os.PathLike[str]) -> Path:
    """Write the archive; return the path of its anchor file, traces.otf2."""
    otf2 = _extras.otf2()
    if run.frames.empty:
        raise run.lacks_rows()
    folder = Path(directory)
    if folder.exists() and any(folder.iterdir()):
        raise LogError(f"{folder} exists: an OTF2 archive needs a directory of its own")
    events = _events(run)
    try:
        with otf2.writer.open(str(folder), timer_resolution=1_000_000_000) as trace:
            _write(run, otf2, trace, events)
    except (OSError, otf2.TraceWriterError) as error:
        raise LogError(f"{folder}: cannot write the archive: {error}") from error
    return folder / "traces.otf2"


def _events(run: Run) -> dict[int, list[tuple[int, int, Any]]]:
    """Return each rank's events in order: time in ns, kind, and the region's name or the other rank."""
    table, measured = timeline.slices(run)
    table = table[table["phase"] != UNDER_WAY]
    origin = float(table["start_s"].min())
    slices: dict[int, list[tuple[int, int, str]]] = {rank: [] for rank in range(run.ranks)}
    for row in table.to_dict("records"):
        name = f"{row['phase']} {row['system'] or ''}".rstrip()
        begin, end = (round((float(row[key]) - origin) * 1e9) for key in ("start_s", "end_s"))
        slices.setdefault(int(row["rank"]), []).append((begin, end, name))
    events = {rank: _nested(mine) for rank, mine in slices.items()}
    if measured:
        waits = run.spans.dropna(subset=["waited_for"])
        for row in waits[waits["waited_for"] >= 0].to_dict("records"):
            at, rank, other = (
                round((float(row["end_s"]) - origin) * 1e9),
                int(row["rank"]),
                int(row["waited_for"]),
            )
            events[other].append((at, _SEND, rank))
            events[rank].append((at, _RECEIVE, other))
    # The sort is stable: at equal times, a region is left before the next one is entered.
    return {rank: sorted(mine, key=lambda event: event[0]) for rank, mine in events.items()}


def _nested(slices: list[tuple[int, int, str]]) -> list[tuple[int, int, Any]]:
    """Return enter and leave events; a slice is cut off at the end of the slice in which it begins."""
    events: list[tuple[int, int, Any]] = []
    within: list[tuple[int, str]] = []
    for begin, end, name in sorted(slices, key=lambda one: (one[0], -one[1])):
        while within and within[-1][0] <= begin:
            events.append((within[-1][0], _LEAVE, within.pop()[1]))
        last = min(end, within[-1][0]) if within else end
        events.append((begin, _ENTER, name))
        within.append((last, name))
    while within:
        events.append((within[-1][0], _LEAVE, within.pop()[1]))
    return events


def _write(run: Run, otf2: Any, trace: Any, events: dict[int, list[tuple[int, int, Any]]]) -> None:
    define = trace.definitions
    enums = otf2.enums
    machine = define.system_tree_node("machine", class_name="machine")
    nodes: dict[str, Any] = {}
    places = {}
    for rank in sorted(events):
        host = run.hosts.get(rank, "") or "host"
        if host not in nodes:
            nodes[host] = define.system_tree_node(host, class_name="node", parent=machine)
        process = define.location_group(
            f"rank {rank}",
            location_group_type=enums.LocationGroupType.PROCESS,
            system_tree_parent=nodes[host],
        )
        places[rank] = define.location(f"rank {rank}", type=enums.LocationType.CPU_THREAD, group=process)
    names = sorted({what for mine in events.values() for _, kind, what in mine if kind == _ENTER})
    regions = {name: define.region(name, source_file="motes") for name in names}
    mpi = {"paradigm": enums.Paradigm.MPI, "members": list(places.values())}
    define.group("ranks", group_type=enums.GroupType.COMM_LOCATIONS, **mpi)
    everyone = define.comm("ranks", group=define.group("all", group_type=enums.GroupType.COMM_GROUP, **mpi))
    index = {rank: number for number, rank in enumerate(places)}
    for rank, place in places.items():
        writer = trace.event_writer_from_location(place)
        for at, kind, what in events[rank]:
            if kind == _ENTER:
                writer.enter(at, regions[what])
            elif kind == _LEAVE:
                writer.leave(at, regions[what])
            elif kind == _SEND:
                writer.mpi_send(at, index[what], everyone, 0, 0)
            else:
                writer.mpi_recv(at, index[what], everyone, 0, 0)
