"""Compare balancers on the same load: `python -m motes bench balance`."""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import Any

import numpy as np

from .. import _core
from ..balance import Balancer, Pairwise, one_of_each, policy_of
from .frames import simulate
from .history import History

__all__ = ["compare", "candidates", "planning_ms"]

GOAL = 1.05
"""Imbalance up to which a frame counts as balanced."""


def candidates(speeds: Iterable[float]) -> list[Balancer]:
    """Return the balancers to compare.

    Args:
        speeds: the machines' speeds, for `Proportional`.
    """
    static, pairwise, *others = one_of_each(list(speeds))
    return [static, pairwise, Pairwise(0.05), *others]


def compare(history: History, balancers: Iterable[Balancer]) -> list[dict[str, Any]]:
    """Run each balancer on a history.

    Args:
        history: recorded or synthetic loads.
        balancers: the balancers to run.

    Returns:
        One row of figures per balancer. `mean_imbalance` and `last_imbalance` are the slowest calculator's
        seconds divided by the mean; `evaluations_to_goal` counts frames from the worst to the first at 1.05
        or below (None: never); `moved` counts the particles that new cuts gave to other calculators, over all
        frames.
    """
    rows = []
    for balancer in balancers:
        imbalances, moved = [], 0
        for step in simulate(history, balancer):
            seconds = step.seconds
            mean = float(seconds.mean())
            imbalances.append(float(seconds.max()) / mean if mean > 0 else 1.0)
            moved += sum(system.moved for system in step.systems)
        rows.append(
            {
                "balancer": _short(balancer),
                "mean_imbalance": float(np.mean(imbalances)),
                "last_imbalance": imbalances[-1],
                "evaluations_to_goal": _reached(imbalances),
                "moved": moved,
            }
        )
    return rows


def planning_ms(balancer: Balancer, calculators: int) -> float:
    """Measure the time of one plan, including the check that makes it legal.

    Args:
        balancer: the balancer that plans.
        calculators: number of calculators.

    Returns:
        Processor time in milliseconds, the shortest of several.
    """
    random = np.random.default_rng(1)
    particles = random.integers(0, 1_000_000, calculators)
    speed = 1e6 * random.integers(1, 9, calculators)
    cuts = np.arange(calculators - 1, dtype=np.float32)
    table = _core.BalanceTable(0, 0, "s", particles, particles / speed, speed, cuts)
    policy = policy_of(balancer)
    name = policy.name
    shortest = np.inf
    for _ in range(10):
        begin = time.thread_time()
        _core.legal_plan(policy.plan(table), table, name)
        shortest = min(shortest, time.thread_time() - begin)
    return 1e3 * float(shortest)


def _reached(imbalances: list[float]) -> int | None:
    worst = int(np.argmax(imbalances))
    good = [k for k in range(worst, len(imbalances)) if imbalances[k] <= GOAL]
    return good[0] - worst if good else None


def _short(balancer: Balancer) -> str:
    if isinstance(balancer, Pairwise):
        return f"Pairwise(threshold={balancer.threshold:g})"
    return f"{type(balancer).__name__}"
