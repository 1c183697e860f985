"""Simulate a history's frames under another balancer: owners of particles, times, and new cuts."""

from __future__ import annotations

import copy
import time
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from .. import _core
from .._values.space import in_a_row
from ..balance import Balancer, for_any_domains, policy_of
from ..errors import ArgumentError
from .bricks import Tree
from .density import Density
from .flows import migrants, spread
from .history import Cuts, Floats, History, Moment, Particles

__all__ = ["Step", "SystemStep", "simulate"]

Counts = npt.NDArray[np.int64]


@dataclass
class SystemStep:
    """One system in one frame under the other balancer; arrays are (calculators,).

    Attributes:
        cuts: cuts between domains in this frame.
        n_start: particles at the frame's start.
        created: newborn particles.
        n_end: particles after the exchange.
        seconds: time of the actions.
        rescaled: `seconds` rescaled to `n_end` particles.
        smoothed: smoothed particles per second, the balancer's input.
        error: relative standard error of `smoothed`.
        moved: particles that the new cuts gave to another calculator in this frame.
        sent: particles sent to other calculators.
        received: particles received from other calculators.
        flows: migrants from each calculator to each other one, (calculators, calculators).
        density: distribution of the particles.
        killed: number of particles removed.
        plan: the balancer's decision; None: it was not called.
        next_cuts: cuts from the next frame on.
    """

    cuts: Cuts | Tree
    n_start: Counts
    created: Counts
    n_end: Counts
    seconds: Floats
    rescaled: Floats
    smoothed: Floats
    error: Floats
    moved: int
    sent: Floats
    received: Floats
    flows: Floats
    density: Particles
    killed: int
    plan: _core.BalancePlan | None = None
    next_cuts: Cuts | Tree = field(default_factory=lambda: np.zeros(0, np.float32))


@dataclass
class Step:
    """One simulated frame.

    Attributes:
        k: index of the frame in the history.
        frame: frame number.
        systems: results per system.
        decided_s: real seconds of the balancer's decisions.
    """

    k: int
    frame: int
    systems: list[SystemStep]
    decided_s: float = 0.0

    @property
    def seconds(self) -> Floats:
        """Each calculator's seconds for all systems."""
        total: Floats = np.sum([system.seconds for system in self.systems], axis=0)
        return total

    @property
    def particles(self) -> Counts:
        """Each calculator's particles at the frame's end."""
        total: Counts = np.sum([system.n_end for system in self.systems], axis=0)
        return total


class _System:
    """State of a system that is carried from frame to frame."""

    def __init__(self, policy: _core.Policy, calculators: int) -> None:
        self.cuts: Cuts | Tree = np.zeros(0, np.float32)
        self.cuts_before: Cuts | Tree = self.cuts
        self.began = False
        self.density: Particles | None = None
        self.n_end = np.zeros(calculators, np.int64)
        self.speeds = policy.speeds(calculators)
        self.evaluations = 0

    def act(self, moment: Moment, powers: Floats | None) -> SystemStep:
        """Run one frame up to the report: births follow the new cuts, older particles act, then migrate."""
        if not self.began:
            self.cuts = self.cuts_before = moment.cuts  # no balancing before there are particles
            self.began = moment.density.total > 0
        old = moment.density.none() if self.density is None else self.density
        n_start, acting_at = self.n_end, self.cuts_before
        if moment.renewed:
            old, acting_at = moment.density, self.cuts
            n_start = old.domains(acting_at)
        created = moment.births.domains(self.cuts)
        seconds = _seconds(old, acting_at, moment, powers)
        seconds = seconds + _seconds(moment.births, self.cuts, moment, powers)
        n_end = moment.density.domains(self.cuts)
        processed = n_start + created
        seconds = seconds + np.where(processed > 0, moment.overhead_s, 0.0) + moment.fixed_s
        rescaled = np.where(processed > 0, seconds * n_end / np.maximum(processed, 1), seconds)
        for c, (n, s, newborn) in enumerate(zip(processed, seconds, created, strict=True)):
            self.speeds.add(c, int(n), float(s), int(newborn))
        smoothed = np.array([self.speeds.of(c) for c in range(len(n_end))])
        error = np.array([self.speeds.error(c) for c in range(len(n_end))])
        source, to, n = moment.density.overlaps(self.cuts_before, self.cuts)
        moved = round(float(n[source != to].sum()))
        flows = self._flows(moment, moved, processed, n_end)
        self.density, self.n_end, self.cuts_before = moment.density, n_end, self.cuts
        return SystemStep(
            self.cuts,
            n_start,
            created,
            n_end,
            seconds,
            rescaled,
            smoothed,
            error,
            moved,
            flows.sum(axis=1),
            flows.sum(axis=0),
            flows,
            moment.density,
            moment.killed,
            next_cuts=self.cuts,
        )

    def _flows(self, moment: Moment, moved: int, processed: Counts, n_end: Counts) -> Floats:
        """Return the migrants; as recorded where the cuts are those of the recorded run."""
        if moment.renewed:  # none moves by itself
            flows = np.zeros((len(n_end), len(n_end)))
            source, to, n = moment.density.overlaps(self.cuts_before, self.cuts)
            np.add.at(flows, (source, to), n)
            np.fill_diagonal(flows, 0.0)
            return flows
        if (
            moment.flows is not None
            and _same(self.cuts_before, moment.before)
            and _same(self.cuts, moment.cuts)
        ):
            return moment.flows
        if moment.ways is not None and not isinstance(self.cuts, Tree):
            assert not isinstance(self.cuts_before, Tree)
            return migrants(moment, self.cuts_before, self.cuts) * moment.agreement
        sent, received = moment.density.exchange(processed, n_end)
        return spread(sent, received, self._changing(moment, moved, float(sent.sum())))

    def _changing(self, moment: Moment, moved: int, least: float) -> float:
        """Return the migrants beyond the minimum: swaps across a cut, crossings offset by deaths."""
        near, around = moment.density.around(self.cuts), moment.density.around(moment.cuts)
        share = near / around if around > 0 else 0.0
        if moment.crossing is None:
            return moment.changing * share
        crossing = moment.crossing * near + moment.changing * min(share, 1.0)
        return max(crossing + moved, 0.0) - least


def _same(ours: Cuts | Tree, theirs: Cuts | Tree | None) -> bool:
    if theirs is None or isinstance(ours, Tree) != isinstance(theirs, Tree):
        return False
    a, b = (one.at if isinstance(one, Tree) else one for one in (ours, theirs))
    return np.array_equal(a, b)


def simulate(history: History, balancer: Balancer, powers: Floats | None = None) -> Iterator[Step]:
    """Run a history's frames under a balancer, like the engine.

    The balancer plans at the end of a frame. In the next frame, births follow the new cuts, and particles
    outside their domain migrate to their owner in the exchange.

    Args:
        history: recorded or synthetic loads.
        balancer: the balancer to run.
        powers: the machines' powers, one per calculator, if known; other differences in measured time are
            attributed to places. None: all differences are attributed to the machines.

    Yields:
        The result of each frame.

    Raises:
        ArgumentError: if the balancer does not support the history's domains.
    """
    for name, axes in zip(history.systems, history.axes, strict=True):
        if balancer.slabs_only and not in_a_row(axes):
            allowed = for_any_domains()
            raise ArgumentError(
                "balancer", balancer, f"{allowed}: domains of {name!r} are not slabs ({axes})"
            )
    policy = policy_of(copy.deepcopy(balancer))  # a balancer with state starts fresh in each replay
    policy.check(len(history.ranks))
    systems = [_System(policy, len(history.ranks)) for _ in history.systems]
    for k, frame in enumerate(history.frames):
        moments = [history.moment(k, s) for s in range(len(systems))]
        steps = [system.act(moment, powers) for system, moment in zip(systems, moments, strict=True)]
        decided_s = 0.0
        if policy.moves and len(history.ranks) > 1:
            decided_s = _balance(history, frame, policy, systems, steps)
        yield Step(k, frame, steps, decided_s)


def _seconds(density: Particles, cuts: Cuts | Tree, moment: Moment, powers: Floats | None) -> Floats:
    """Return each calculator's seconds for these particles, divided by `cuts`."""
    if powers is None:
        return density.domains(cuts) / moment.speeds
    mine, theirs, n = density.overlaps(cuts, moment.cuts)
    cost = (powers / moment.speeds)[theirs]
    return np.bincount(mine, n * cost, len(cuts) + 1) / powers


def _balance(
    history: History, frame: int, policy: _core.Policy, systems: list[_System], steps: list[SystemStep]
) -> float:
    """Set the cuts of the next frame; return the seconds that the policy took to decide."""
    tables = [
        _core.BalanceTable(
            frame,
            system.evaluations,
            name,
            step.n_end,
            step.rescaled,
            step.smoothed,
            step.cuts.at if isinstance(step.cuts, Tree) else step.cuts,
            step.error,
            axes,
        )
        for name, axes, system, step in zip(history.systems, history.axes, systems, steps, strict=True)
    ]
    start = time.perf_counter()
    if policy.over_all:
        whole = _core.sum_of_tables(tables)
        plan = _core.legal_plan(policy.plan(whole), whole, policy.name)
        plans = [_core.plan_part(plan, table, whole) for table in tables]
    else:
        plans = [_core.legal_plan(policy.plan(table), table, policy.name) for table in tables]
    decided_s = time.perf_counter() - start
    for system, step, plan in zip(systems, steps, plans, strict=True):
        system.evaluations += 1
        step.plan = plan
        step.next_cuts = system.cuts = _cuts_after(plan, step.density, step.cuts)
    return decided_s


def _cuts_after(plan: _core.BalancePlan, density: Particles, cuts: Cuts | Tree) -> Cuts | Tree:
    if len(plan.shares):
        divided: Cuts | Tree = density.divided(plan.costs, plan.shares, cuts)
        return divided
    if not plan.orders or not isinstance(density, Density) or isinstance(cuts, Tree):
        return cuts
    after = cuts.copy()
    below = density.count_below(cuts)
    ends = np.concatenate([[-np.inf], cuts, [np.inf]])
    for source, to, count in plan.orders:
        cut = min(source, to)
        wanted = below[cut] + (count if source > to else -count)
        # Where a gap leaves a choice, the cut stays inside the donor's domain.
        after[cut] = np.clip(density.place(wanted), ends[source], ends[source + 1])
    return after
