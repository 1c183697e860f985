"""The clocks of all ranks through a frame's conversations: who waits for whose message.

The order of a frame, as in cpp/engine/frame.cpp: the manager collects proposals for new cuts, creates births
and deals them out; calculators act, pack migrants and report; the verdict comes down; migrants travel; the
manager's plan goes out; records of particles travel to the ranks that draw; calculators look for new cuts and
propose them. Nobody waits for the end of a frame: the next one begins as soon as a rank has its message.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .wires import Wires

__all__ = ["Cast", "Clocks", "Work"]

Floats = npt.NDArray[np.float64]
BEGIN, REPORT, VERDICT, PLAN, LOADS = 200.0, 480.0, 260.0, 140.0, 110.0
"""Bytes of messages of which a frame's work hardly changes the size, headers included."""


@dataclass(frozen=True)
class Cast:
    """Who plays which role, and the tree that the manager's messages take (cpp/roles/tree.h)."""

    manager: int
    image_generator: int
    calculators: list[int]
    size: int
    fan_out: int = 8

    def tree(self) -> tuple[list[int], dict[int, int]]:
        """Return all ranks, parents before children, and the parent of each but the manager."""
        order = list(dict.fromkeys([self.manager, *self.calculators, *range(self.size)]))
        parents: dict[int, int] = {}
        todo = [(0, len(order))]
        while todo:
            first, end = todo.pop()
            rest, parts, at = end - first - 1, min(end - first - 1, self.fan_out), first + 1
            for i in range(parts):
                to = at + rest // parts + (1 if i < rest % parts else 0)
                parents[order[at]] = order[first]
                todo.append((at, to))
                at = to
        return order, parents

    @property
    def draws_apart(self) -> bool:
        """Whether the image generator can answer the manager's plan before it draws."""
        return self.image_generator not in (self.manager, *self.calculators) and self.size <= self.fan_out + 1


@dataclass
class Work:
    """What a frame asks of ranks and network; arrays are (ranks,).

    Attributes:
        births_s: seconds to create particles.
        newborn_bytes: bytes of the newborn particles that the manager sends to each rank.
        shared_bytes: bytes that each calculator gets from each other one about births, (calculators,);
            None: the manager deals them out.
        act_s: seconds of actions and of packing migrants.
        migrants: sender, receiver, bytes and the receiver's seconds to unpack, per message.
        plans: whether the manager sends a plan.
        pairs: ranks that compare their loads before they answer the plan.
        search_s: seconds to look for new cuts.
        proposal_bytes: bytes of the answers to the plan; None: there are no answers.
        project_s: seconds to make records of particles.
        records: sender, receiver and bytes, per message with records.
        draw_s: seconds to draw, after all records have arrived.
        own_s: seconds of everything else.
    """

    births_s: Floats
    newborn_bytes: Floats
    act_s: Floats
    project_s: Floats
    draw_s: Floats
    own_s: Floats
    search_s: Floats
    migrants: Sequence[tuple[int, int, float, float]] = ()
    shared_bytes: Floats | None = None
    plans: bool = False
    pairs: Sequence[tuple[int, int]] = ()
    proposal_bytes: Floats | None = None
    records: Sequence[tuple[int, int, float]] = ()

    @staticmethod
    def none(ranks: int) -> Work:
        """Return the work of a frame without particles."""
        return Work(*(np.zeros((7, ranks))))


class Clocks:
    """The ranks' clocks, from frame to frame."""

    def __init__(self, cast: Cast, wires: Wires) -> None:
        """Set who talks to whom, and how long messages take."""
        self._cast, self._wires = cast, wires
        self._order, self._parents = cast.tree()
        self._at = np.zeros(cast.size)
        self._proposed = 0.0

    def frame(self, work: Work) -> float:
        """Run a frame; return its seconds: from the latest rank's end to the latest rank's end."""
        before = float(self._at.max())
        at, manager = self._at, self._cast.manager
        at[manager] = max(at[manager], self._proposed) + work.births_s[manager]
        at = self._down(at, BEGIN + work.newborn_bytes)
        others = np.arange(len(at)) != manager
        at = at + work.births_s * others
        if work.shared_bytes is not None:
            at = self._share(at, work.shared_bytes)
        at = at + work.act_s
        at[manager] = self._up(at, np.full(len(at), REPORT))
        at = self._down(at, np.full(len(at), VERDICT))
        at = self._deliver(at, work.migrants)
        planned = at.copy()
        at = at + work.project_s
        if work.plans and self._cast.draws_apart and not work.pairs:
            generator = self._cast.image_generator
            at[generator] = self._wires.arrive(planned[manager], manager, generator, PLAN, at[generator])
        at = self._draw(at, work)
        if work.plans:
            ready = at.copy()
            ready[manager] = planned[manager]
            at = np.maximum(self._down(ready, np.full(len(at), PLAN)), at)
            at = self._propose(at, work)
        self._at = at + work.own_s
        return float(self._at.max()) - before

    def _share(self, at: Floats, sizes: Floats) -> Floats:
        """Exchange births between all calculators; with more than 16, further steps are left out."""
        ring = self._cast.calculators
        messages = [
            (source, to, float(sizes[d]), 0.0) for d, to in enumerate(ring) for source in ring if source != to
        ]
        return self._deliver(at, messages)

    def _deliver(self, at: Floats, migrants: Sequence[tuple[int, int, float, float]]) -> Floats:
        """Send migrants; each calculator takes its messages one after another."""
        ends = at.copy()
        turns: dict[int, int] = {}
        queue = []
        for source, to, size, unpack_s in migrants:
            turns[to] = turns.get(to, 0) + 1
            queue.append((turns[to], at[source], source, to, size, unpack_s))
        for _, sent, source, to, size, unpack_s in sorted(queue):
            ends[to] = self._wires.arrive(sent, source, to, size, ends[to]) + unpack_s
        return ends

    def _draw(self, at: Floats, work: Work) -> Floats:
        if not work.records and not work.draw_s.any():
            return at
        ends = self._deliver(at, [(source, to, size, 0.0) for source, to, size in work.records]) + work.draw_s
        generator = self._cast.image_generator
        for rank in np.flatnonzero(work.draw_s):
            if rank != generator and any(to == rank for _, to, _ in work.records):
                ends[generator] = self._wires.arrive(ends[rank], int(rank), generator, 0.0, ends[generator])
        return ends

    def _propose(self, at: Floats, work: Work) -> Floats:
        """Compare loads, look for cuts, and send them on their way; the manager waits in the next frame."""
        met = at.copy()
        for one, other in work.pairs:
            for source, to in ((one, other), (other, one)):
                met[to] = self._wires.arrive(at[source], source, to, LOADS, met[to])
        met = met + work.search_s
        if work.proposal_bytes is not None:
            self._proposed = self._up(met, work.proposal_bytes)
        return met

    def _down(self, at: Floats, sizes: Floats) -> Floats:
        """Send the manager's message along the tree; `at`: when each rank starts to wait for it."""
        at = at.copy()
        sizes = self._below(sizes)
        for rank in self._order[1:]:
            parent = self._parents[rank]
            at[rank] = self._wires.arrive(at[parent], parent, rank, sizes[rank], at[rank])
        return at

    def _up(self, at: Floats, sizes: Floats) -> float:
        """Send answers along the tree; return when the manager has all of them."""
        at = at.copy()
        sizes = self._below(sizes)
        for rank in reversed(self._order[1:]):
            parent = self._parents[rank]
            at[parent] = self._wires.arrive(at[rank], rank, parent, sizes[rank], at[parent])
        return float(at[self._cast.manager])

    def _below(self, sizes: Floats) -> Floats:
        """Return the bytes of each rank's message, with those of the ranks below it."""
        sums = sizes.copy()
        for rank in reversed(self._order[1:]):
            if self._parents[rank] != self._cast.manager:
                sums[self._parents[rank]] += sums[rank]
        return sums
