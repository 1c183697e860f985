"""Timeline of all ranks: slices of time, measured or estimated from the durations of phases."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ... import _extras
from .._tables import measures
from .._tables.schema import ACTIVITIES
from .drawing import UNDER_WAY

if TYPE_CHECKING:
    from pandas import DataFrame

    from ..run import Run

__all__ = ["COLUMNS", "frame_starts", "phase_seconds", "slices"]

Row = dict[str, Any]
Slice = tuple[str, str, float, float]
COLUMNS = ("frame", "rank", "phase", "system", "start_s", "end_s")


def slices(run: Run, frames: Iterable[int] | None = None) -> tuple[DataFrame, bool]:
    """Return one row per slice (frame, rank, phase, system, start_s, end_s), and whether they were measured.

    Measured slices are the run's spans. Otherwise the durations of phases are laid end to end from each
    frame's start: lengths are exact, positions are estimated.
    """
    chosen = None if frames is None else set(frames)
    spans = run.spans
    if not spans.empty:
        mine = spans if chosen is None else spans[spans["frame"].isin(chosen)]
        return mine[list(COLUMNS)].sort_values(["start_s", "end_s"], ignore_index=True), True
    rows = list(_laid_out(run, chosen))
    return _extras.pandas().DataFrame(rows, columns=list(COLUMNS)), False


def frame_starts(run: Run) -> dict[int, tuple[float, float]]:
    """Return each frame's start and end in seconds since the run's start."""
    spans = run.spans
    if not spans.empty:
        ends = spans.groupby("frame").agg({"start_s": "min", "end_s": "max"}).reset_index()
    else:
        seconds = run.frames["t_frame_s"].fillna(0.0)
        ends = _extras.pandas().DataFrame({"frame": run.frames["frame"], "end_s": seconds.cumsum()})
        ends["start_s"] = ends["end_s"] - seconds
    rows = ends.to_dict("records")
    return {int(row["frame"]): (float(row["start_s"]), float(row["end_s"])) for row in rows}


def _laid_out(run: Run, chosen: set[int] | None) -> Iterator[Row]:
    starts = frame_starts(run)
    parts = run.stretches
    by_frame: dict[int, dict[int, list[Row]]] = {}
    load, frames = run.load, run.frames
    if chosen is not None:
        load, frames = load[load["frame"].isin(chosen)], frames[frames["frame"].isin(chosen)]
    row: Any
    for row in load.fillna(0.0).to_dict("records"):
        by_frame.setdefault(int(row["frame"]), {}).setdefault(int(row["rank"]), []).append(row)
    for row in frames.fillna(0.0).to_dict("records"):
        frame = int(row["frame"])
        start, end = starts[frame]
        part = [part for part in parts if part["frame"] <= frame][-1]
        for rank, lane in _lanes({**run.facts, **part}, row, by_frame.get(frame, {}), start).items():
            for phase, system, low, high in lane:
                low, high = min(low, end), min(high, end)
                if high > low:
                    values = (frame, rank, phase, system, low, high)
                    yield dict(zip(COLUMNS, values, strict=True))


def _lanes(facts: Row, frame: Row, load: dict[int, list[Row]], start: float) -> dict[int, list[Slice]]:
    """Return each rank's estimated slices of one frame from `start` on; `facts` are its stretch's."""
    acting = start + frame["t_create_s"]
    slowest = max((sum(row["t_compute_s"] for row in mine) for mine in load.values()), default=0.0)
    together = acting + slowest
    lanes: dict[int, list[Slice]] = {}
    if facts.get("manager") is not None:
        lanes[int(facts["manager"])] = [("create", "", start, acting)]
    for rank, rows in load.items():
        lanes.setdefault(rank, []).extend(_calculator(rows, acting, together))
    draws = facts.get("image_generator")
    if draws is not None and int(draws) not in load:  # calculators' rows include drawing time
        drawn = together + frame["t_exchange_s"]
        lanes.setdefault(int(draws), []).append(("render", "", drawn, drawn + frame["t_render_s"]))
    return lanes


def _calculator(load: list[Row], acting: float, together: float) -> list[Slice]:
    lane: list[Slice] = []
    at = acting
    for row in load:
        lane.append(("act", str(row["system"]), at, at + row["t_compute_s"]))
        at += row["t_compute_s"]
    lane.append(("wait", "", at, together))
    exchanged = together + max(row["t_exchange_s"] for row in load)
    lane.append(("exchange", "", together, exchanged))
    lane.append(("render", "", exchanged, exchanged + max(row["t_image_s"] for row in load)))
    return lane


def phase_seconds(run: Run, frames: Iterable[int] | None = None) -> tuple[DataFrame, bool]:
    """Return mean seconds per frame, rank x phase, and whether they cover each rank's whole time.

    Logs of earlier versions lack `times`: with spans, the phases are returned; without, a calculator's frame
    is divided into compute, exchange and image (including their waits), other waiting, and the rest.
    """
    pd = _extras.pandas()
    if not run.times.empty:
        times = run.times if frames is None else run.times[run.times["frame"].isin(list(frames))]
        spent = times.groupby("rank")[[f"{name}_s" for name in ACTIVITIES]].mean().fillna(0.0)
        return spent.rename(columns=lambda name: name.removesuffix("_s")), True
    if not run.spans.empty:
        spans, _ = slices(run, frames)
        spans = spans[spans["phase"] != UNDER_WAY]
        n = max(spans["frame"].nunique(), 1)
        seconds = (spans["end_s"] - spans["start_s"]).groupby([spans["rank"], spans["phase"]]).sum() / n
        return seconds.unstack("phase").fillna(0.0), True
    load, rows = run.load, run.frames.set_index("frame")
    if frames is not None:
        chosen = list(frames)
        load, rows = load[load["frame"].isin(chosen)], rows[rows.index.isin(chosen)]
    total = float(rows["t_frame_s"].mean())
    parts = {
        phase: measures.by_rank(load, column).fillna(0.0).mean()
        for phase, column in (
            ("compute", "t_compute_s"),
            ("exchange", "t_exchange_s"),
            ("image", "t_image_s"),
            ("wait", "t_wait_s"),
        )
    }
    table = pd.DataFrame(parts)
    left = (total - table[["compute", "exchange", "image"]].sum(axis=1)).clip(lower=0.0)
    table["wait"] = np.minimum(table["wait"], left)
    table["rest"] = left - table["wait"]
    return table, False
