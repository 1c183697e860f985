"""Evening 2: cuts from prefix sums."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from motes.replay.history import Floats

from ._secret import Secret
from .asking import Asked
from .grades import Part

__all__ = ["Case", "cases", "graded"]

ENOUGH = 1e-6
"""Largest fraction of all particles on the wrong side of a cut that counts as correct."""


@dataclass(frozen=True)
class Case:
    """A histogram, and the share of it that each calculator must get."""

    name: str
    edges: Floats
    counts: Floats
    shares: Floats

    def wrong(self, cuts: Floats) -> float:
        """Return the most particles on the wrong side of a cut, as a fraction of all."""
        below = np.concatenate([[0.0], np.cumsum(self.counts)])
        total = below[-1]
        wanted = np.cumsum(self.shares)[:-1] / self.shares.sum()
        held = np.interp(cuts, self.edges, below) / total
        return float(np.abs(held - wanted).max())


def cases(key: str) -> list[Case]:
    """Make histograms from a key."""
    names = ("equal shares", "a crowd", "unequal shares", "a gap", "one full bin", "a share of nothing")
    return [_case(key, name) for name in (*names, "more calculators than bins")]


def _case(key: str, name: str) -> Case:
    secret = Secret(key, f"2 {name}")
    bins, calculators = secret.whole(40, 60), secret.whole(4, 7)
    if name == "more calculators than bins":
        bins, calculators = secret.whole(3, 5), secret.whole(8, 12)
    counts = np.array([float(secret.whole(50, 150)) for _ in range(bins)])
    shares = np.ones(calculators)
    if name == "a crowd":
        at = secret.whole(5, bins - 6)
        counts[at : at + 3] *= 40
    elif name == "unequal shares":
        shares = np.array([float(secret.whole(1, 8)) for _ in range(calculators)])
    elif name == "a gap":
        counts[bins // 4 : 3 * bins // 4] = 0
    elif name == "one full bin":
        at = secret.whole(0, bins - 1)
        counts[:at] = counts[at + 1 :] = 0
    elif name == "a share of nothing":
        shares[secret.whole(0, calculators - 1)] = 0
    start = secret.uniform(-20, 5)
    widths = np.array([secret.uniform(0.1, 0.5) for _ in range(bins)])
    return Case(name, start + np.concatenate([[0.0], np.cumsum(widths)]), counts, shares)


def graded(asked: Asked, histograms: list[Case]) -> list[Part]:
    """Let a submission cut each histogram, and grade its cuts."""
    return [_part(case, _cut(asked, case)) for case in histograms]


def _cut(asked: Asked, case: Case) -> Any:
    given = {"edges": case.edges, "counts": case.counts, "shares": case.shares}
    return asked.call("cuts", **{name: array.tolist() for name, array in given.items()})


def _part(case: Case, answer: Any) -> Part:
    count = len(case.shares) - 1
    try:
        cuts = np.array(answer, np.float64)
    except (TypeError, ValueError):
        return Part(case.name, 0.0, f"cuts must return {count} numbers here")
    if cuts.shape != (count,):
        return Part(
            case.name,
            0.0,
            f"{count + 1} calculators have {count} cuts, you return an array of shape {cuts.shape}",
        )
    if not np.isfinite(cuts).all() or (np.diff(cuts) < 0).any():
        return Part(
            case.name, 0.0, "cuts must be finite and ascending: is 0 divided by 0, or is something unsorted?"
        )
    if (wrong := case.wrong(cuts)) <= ENOUGH:
        return Part(case.name, 100.0)
    even = np.linspace(case.edges[0], case.edges[-1], count + 2)[1:-1]
    worth = max(1 - wrong / max(case.wrong(even), 10 * ENOUGH), 0.0)
    hint = f"{100 * wrong:.2g} % of the particles are on the wrong side of a cut"
    if worth > 0.8:
        hint += ": cut inside the bin, as if its particles were evenly spread"
    return Part(case.name, min(round(100 * worth, 1), 99.0), hint)
