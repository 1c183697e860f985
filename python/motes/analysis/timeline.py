"""When each rank did what: slices of time, as measured or put together from durations of phases."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from . import extras, measures
from .drawing import UNDER_WAY

if TYPE_CHECKING:
    from pandas import DataFrame

    from .run import Run

__all__ = ["COLUMNS", "frame_starts", "phase_seconds", "slices"]

COLUMNS = ("frame", "rank", "phase", "system", "start_s", "end_s")


def slices(run: Run, frames: Iterable[int] | None = None) -> tuple[DataFrame, bool]:
    """Return a row a slice (frame, rank, phase, system, start_s, end_s), and whether they were measured.

    Measured: the run's spans. Otherwise durations of phases are laid one after the other from each frame's
    start: true in length, a guess in place.
    """
    chosen = None if frames is None else set(frames)
    spans = run.spans
    if not spans.empty:
        mine = spans if chosen is None else spans[spans["frame"].isin(chosen)]
        return mine[list(COLUMNS)].sort_values(["start_s", "end_s"], ignore_index=True), True
    rows = [row for row in _laid_out(run) if chosen is None or row["frame"] in chosen]
    return extras.pandas().DataFrame(rows, columns=list(COLUMNS)), False


def frame_starts(run: Run) -> dict[int, tuple[float, float]]:
    """Return each frame's start and end in seconds since the run's start."""
    spans = run.spans
    if not spans.empty:
        ends = spans.groupby("frame").agg({"start_s": "min", "end_s": "max"}).reset_index()
    else:
        seconds = run.frames["t_frame_s"].fillna(0.0)
        ends = extras.pandas().DataFrame({"frame": run.frames["frame"], "end_s": seconds.cumsum()})
        ends["start_s"] = ends["end_s"] - seconds
    rows = ends.to_dict("records")
    return {int(row["frame"]): (float(row["start_s"]), float(row["end_s"])) for row in rows}


def _laid_out(run: Run) -> Iterator[dict[str, Any]]:
    starts = frame_starts(run)
    manager, image_generator = run.facts.get("manager"), run.facts.get("image_generator")
    by_frame = dict(tuple(run.load.groupby("frame")))
    for row in run.frames.fillna(0.0).to_dict("records"):
        frame = int(row["frame"])
        start, end = starts[frame]
        load = by_frame.get(frame, run.load.iloc[:0])
        acting = start + row["t_create_s"]
        slowest = float(load.groupby("rank")["t_compute_s"].sum().max()) if len(load) else 0.0
        together = acting + slowest
        lanes: dict[int, list[tuple[str, str, float, float]]] = {}
        if manager is not None:
            lanes[int(manager)] = [("create", "", start, acting)]
        if image_generator is not None:
            drawn = together + row["t_exchange_s"]
            lanes.setdefault(int(image_generator), []).append(
                ("render", "", drawn, drawn + row["t_render_s"])
            )
        for rank in load["rank"].unique():
            lanes[int(rank)] = _calculator(load[load["rank"] == rank].fillna(0.0), acting, together)
        for rank, lane in lanes.items():
            for phase, system, low, high in lane:
                low, high = min(low, end), min(high, end)
                if high > low:
                    values = (frame, rank, phase, system, low, high)
                    yield dict(zip(COLUMNS, values, strict=True))


def _calculator(load: DataFrame, acting: float, together: float) -> list[tuple[str, str, float, float]]:
    lane = []
    at = acting
    for system, seconds in zip(load["system"], load["t_compute_s"], strict=True):
        lane.append(("act", str(system), at, at + seconds))
        at += seconds
    lane.append(("wait", "", at, together))
    exchanged = together + float(load["t_exchange_s"].max())
    lane.append(("exchange", "", together, exchanged))
    lane.append(("render", "", exchanged, exchanged + float(load["t_image_s"].max())))
    return lane


def phase_seconds(run: Run, frames: Iterable[int] | None = None) -> tuple[DataFrame, bool]:
    """Return mean seconds a frame, rank x phase, and whether they come from spans.

    Without spans a calculator's frame is parted into compute, exchange and image (their waits included),
    other waiting, and the rest.
    """
    pd = extras.pandas()
    if not run.spans.empty:
        found, _ = slices(run, frames)
        found = found[found["phase"] != UNDER_WAY]
        n = max(found["frame"].nunique(), 1)
        seconds = (found["end_s"] - found["start_s"]).groupby([found["rank"], found["phase"]]).sum() / n
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
