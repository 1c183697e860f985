"""Migrants between domains: particles that move across cuts, and cuts that move across particles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from .density import Density

if TYPE_CHECKING:
    from .history import Cuts, Floats, Moment

__all__ = ["matched", "migrants", "spread"]


def migrants(moment: Moment, before: Cuts, after: Cuts) -> Floats:
    """Return how many particles migrate from each domain to each other one, (domains, domains).

    Particles of a domain of the recorded run move by that domain's ways, all of which are equally likely
    everywhere in it. Those between two cuts of `before` then belong to the domain of `after` that they reach;
    births belong to domains of `after` from the start.

    Args:
        moment: the frame; its `ways` must be known and its particles lie along an axis.
        before: cuts in the previous frame.
        after: cuts in this frame.
    """
    assert moment.ways is not None and isinstance(moment.births, Density)
    ways = _filled(moment.ways)
    flows = _carried(moment.births, np.asarray(moment.cuts), ways, after, after)
    if isinstance(moment.earlier, Density):
        flows += _carried(moment.earlier, np.asarray(moment.before), ways, before, after)
    alive = moment.density.total / max(moment.density.total + moment.killed, 1e-300)
    np.fill_diagonal(flows, 0.0)
    return flows * alive


def _carried(density: Density, theirs: Floats, ways: Floats, before: Cuts, after: Cuts) -> Floats:
    """Return the particles that move from each domain of `before` to each of `after`.

    `ways` are those of the domains between `theirs`.
    """
    flows = np.zeros((len(after) + 1, len(after) + 1))
    if density.total <= 0:
        return flows
    low, high = density.x[0] - 1, density.x[-1] + 1
    ends = np.clip(np.concatenate([[low], theirs, [high]]), low, high)
    shifts = ways[:, :, None]  # (their domains, ways, pieces) for all that follows
    pieces = np.concatenate([np.broadcast_to(before, (*ways.shape, len(before))), after - shifts], axis=2)
    first, last = ends[:-1, None, None], ends[1:, None, None]
    pieces = np.concatenate(
        [np.broadcast_to(first, shifts.shape), pieces, np.broadcast_to(last, shifts.shape)], axis=2
    )
    pieces = np.sort(np.clip(pieces, first, last), axis=2)
    below = density.count_below(pieces.ravel()).reshape(pieces.shape)
    middle = (pieces[:, :, 1:] + pieces[:, :, :-1]) / 2
    source = np.searchsorted(before, middle, side="right")
    to = np.searchsorted(after, middle + shifts, side="right")
    np.add.at(flows, (source, to), np.diff(below, axis=2) / ways.shape[1])
    return flows


def matched(flows: Floats, sent: Floats, received: Floats) -> Floats:
    """Scale flows so that their sums agree with these migrants of each calculator, as far as possible."""
    result = flows.copy()
    for _ in range(8):  # alternately by rows and by columns; converges quickly
        for axis, wanted in ((1, sent), (0, received)):
            sums = result.sum(axis=axis)
            empty = (sums <= 0) & (wanted > 0)
            if empty.any():
                result = np.where(_beside(empty, axis) & ~np.eye(len(result), dtype=bool), 1e-9, result)
                sums = result.sum(axis=axis)
            result = result * np.expand_dims(
                np.where(sums > 0, wanted / np.where(sums > 0, sums, 1), 0), axis
            )
    return result


def spread(sent: npt.ArrayLike, received: npt.ArrayLike, swapped: float = 0.0) -> Floats:
    """Return flows with these sums, mostly between neighbours, and `swapped` more evenly over all cuts."""
    sent, received = np.asarray(sent, np.float64), np.asarray(received, np.float64)
    count = len(sent)
    near = np.exp(-2.0 * np.abs(np.subtract.outer(np.arange(count), np.arange(count))))
    np.fill_diagonal(near, 0.0)
    flows = matched(near, sent, received) if sent.sum() > 0 else np.zeros((count, count))
    if count > 1:
        both = np.eye(count, k=1) + np.eye(count, k=-1)
        flows = np.maximum(flows + both * (swapped / both.sum()), 0.0)
    return flows


def _filled(ways: Floats) -> Floats:
    """Replace the unknown ways of domains without particles by those of the nearest domain that has some."""
    known = np.flatnonzero(~np.isnan(ways).any(axis=1))
    nearest = np.abs(np.subtract.outer(np.arange(len(ways)), known)).argmin(axis=1)
    filled: Floats = ways[known[nearest]]
    return filled


def _beside(empty: npt.NDArray[np.bool_], axis: int) -> npt.NDArray[np.bool_]:
    return np.broadcast_to(np.expand_dims(empty, axis), (len(empty), len(empty)))
