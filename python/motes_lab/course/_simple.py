"""Policies that look at nothing, or at one number: what a submission must beat to get points."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from motes.balance import Balancer, LoadTable, Orders, Targets
from motes.replay.history import Floats

__all__ = ["Simple", "simple"]

Rule = Callable[[LoadTable], bool]
Shares = Callable[[LoadTable], Floats]


class Simple(Balancer):
    """Orders the same kind of shares whenever a rule holds, and otherwise nothing."""

    def __init__(self, shares: Shares, rule: Rule) -> None:
        """`shares` are of a table of loads; `rule` says after which frames they are ordered."""
        self._shares, self._rule = shares, rule

    def decide(self, load: LoadTable) -> Targets | Orders:
        """Return the shares if the rule holds."""
        return Targets(self._shares(load)) if self._rule(load) else Orders([])


def simple(*, equal: bool, smoothed: bool) -> Iterator[Simple]:
    """Make all simple policies: even shares or measured powers, at fixed times or above fixed limits.

    Args:
        equal: whether machines are equal and clocks exact, so that measured powers are even shares, too.
        smoothed: whether powers are the engine's, so good that it matters most when shares are ordered.
    """
    every = (_even,) if equal else (_powers, _even)
    for frames in (13, 5, 2, 17, 8, 11, 3, 21, 7):
        yield from (Simple(shares, _every(frames)) for shares in every)
    # With good powers, some of them win by acting just when a crowd comes to rest.
    for frames in (7, 8, 10, 11, 13, 14, 16) if smoothed else ():
        for first in (frames // 4, frames // 2, 3 * frames // 4):
            yield Simple(every[0], _every(frames, first))
    yield Simple(_even, _never)
    for limit in (1.1, 1.2, 1.5, 2.0, 3.0):
        yield Simple(every[0], _late(limit))
    for shares in every:
        yield Simple(shares, _always)
        for frame in (1, 20):
            yield Simple(shares, _once(frame))
        for limit in (1.2, 2.0):
            yield Simple(shares, _uneven(limit))
    for frame in (5, 40):
        yield Simple(every[0], _until(frame))
    yield Simple(_first_powers(), _always)
    yield Simple(lambda load: np.maximum(load.particles, 1).astype(np.float64), _always)


def _even(load: LoadTable) -> Floats:
    return np.ones(len(load))


def _powers(load: LoadTable) -> Floats:
    return load.powers


def _first_powers() -> Shares:
    kept: list[Floats] = []

    def shares(load: LoadTable) -> Floats:
        kept.append(load.powers)
        return kept[0]

    return shares


def _never(_: LoadTable) -> bool:
    return False


def _always(_: LoadTable) -> bool:
    return True


def _every(frames: int, first: int = 0) -> Rule:
    return lambda load: load.frame % frames == first


def _once(frame: int) -> Rule:
    return lambda load: load.frame == frame


def _until(frame: int) -> Rule:
    return lambda load: load.frame < frame


def _uneven(limit: float) -> Rule:
    return lambda load: bool(load.particles.max() > limit * load.particles.mean())


def _late(limit: float) -> Rule:
    return lambda load: bool(load.seconds.max() > limit * load.seconds.mean())
