"""What another balancer would save of a run's time, or lose: `Run.explain().saving`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .._values.space import in_a_row
from ..errors import MotesError

if TYPE_CHECKING:
    from ..balance import Balancer
    from .run import Run

__all__ = ["Saving", "saving", "sentence_of"]

FRAMES = 100
"""Only the last frames of a longer run are replayed, under each balancer."""
LEARNING = 5
"""The first of this many equal parts of the frames is left out: in it balancers learn, and move most."""
SHORT = 5
"""Percent by which the saving in this run must be smaller than that of a long one to be told."""
NOTHING = 0.005
"""Savings within this part of the run's time count as none."""


@dataclass(frozen=True)
class Saving:
    """What the best other balancer would save, as parts of the run's time; below 0: it would lose.

    Attributes:
        part: the estimate, without the first frames, in which balancers learn; NaN if the log lacks the data.
        low: lower bound, of this run and of a longer one, in which the first frames do not count.
        high: upper bound.
        balancer: its name, such as "PrefixCuts"; "" if the log tells too little for a replay. Then the
            estimate is what perfect balance would save if it cost nothing.
        in_the_end: bounds of `part` alone.
        so_far: the estimate for this run, with its first frames.
    """

    part: float
    low: float
    high: float
    balancer: str = ""
    in_the_end: tuple[float, float] = (0.0, 0.0)
    so_far: float = 0.0


def saving(run: Run, most: float) -> Saving:
    """Replay a run under every other balancer that needs no options; return what the best one would save.

    Args:
        run: the run.
        most: part of the run's time that perfect balance would save if it cost nothing; the answer if the log
            tells too little for a replay.
    """
    known = run.__dict__.setdefault("_savings", {})
    rows = len(run.frames)
    if rows not in known:
        known.clear()
        known[rows] = _replayed(run, most)
    estimate: Saving = known[rows]
    return estimate


def sentence_of(saving: Saving) -> str:
    """Return the estimate as a sentence: "PrefixCuts() would save 12 % (9 to 15)"."""
    if np.isnan(saving.part):
        return "the log does not tell what balancing would save"
    if not saving.balancer:
        return f"perfect balance would save at most {round(100 * saving.high)} %"
    part, low, high, so_far = (round(100 * one) for one in (saving.part, *saving.in_the_end, saving.so_far))
    if saving.part < NOTHING:
        what = "another balancer" if saving.balancer == "Static" else "balancing"
        longer = f"{-part} % longer ({-high} to {-low})"
        return f"{what} would lose here: with {saving.balancer} the run would take {longer}"
    text = f"{saving.balancer} {'would' if low > 0 else 'might'} save {part} % ({low} to {high})"
    if so_far < part - SHORT:
        gain = f"{so_far} %" if so_far > 0 else "nothing"
        text += f", of a run as short as this one {gain}, since particles have to move first"
    return text


def _replayed(run: Run, most: float) -> Saving:
    if run.load.empty or run.frames.empty or run.load["rank"].nunique() < 2:
        return Saving(most, most, most)
    try:
        return _best(_recent(run))
    except (ImportError, MotesError):  # no densities; no core, which has the policies
        return Saving(most, min(most, 0.0), most)


def _best(run: Run) -> Saving:
    from ..replay.costs import Costs  # needs the compiled core, unlike the rest
    from ..replay.estimate import estimated
    from ..replay.history import Recorded

    history = Recorded(run)
    costs = Costs(run, history)
    settled = max(len(history.frames) // LEARNING, 1)  # the very first frame opens files
    candidates: list[
        tuple[float, Saving]
    ] = []  # of savings that are equal in the end, the one that learns faster
    for balancer in _others(run):
        frames = estimated(history, costs, balancer)
        parts = []
        for first in (settled, min(1, settled)):
            then = float(costs.actual_s[first:].sum())
            if then > 0:
                parts.append([1 - float(seconds[first:].sum()) / then for seconds in frames])
        if parts:
            best, highs, lows = zip(*parts, strict=True)
            name, ends = type(balancer).__name__, (lows[0], highs[0])
            one = Saving(best[0], min(lows), max(highs), name, ends, best[-1])
            candidates.append((round(best[0] / NOTHING) * NOTHING + 0.1 * NOTHING * best[-1], one))
    return max(candidates, key=lambda pair: pair[0])[1] if candidates else Saving(0.0, 0.0, 0.0)


def _others(run: Run) -> list[Balancer]:
    """Return the balancers that the run could have used instead of its own."""
    from ..balance import without_options

    rows = all(in_a_row(run.axis(system)) for system in run.systems)
    own = run.balancer.partition("(")[0]
    return [
        balancer
        for balancer in without_options()
        if type(balancer).__name__ != own and (rows or not balancer.slabs_only)
    ]


def _recent(run: Run) -> Run:
    """Return the last frames of the run."""
    frames = np.sort(run.frames["frame"].unique())
    if len(frames) <= FRAMES:
        return run
    first = frames[-FRAMES]
    tables = {name: getattr(run, name) for name in ("frames", "load", "density", "balance", "times")}
    cut = {name: table[table["frame"] >= first] for name, table in tables.items() if not table.empty}
    return type(run)({**run.facts, "name": run.name}, {**cut, "links": run.links})
