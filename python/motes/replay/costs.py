"""What a frame costs besides the actions, from a run's log: births, migrants, cuts, pictures, the rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .clocks import Cast, Clocks, Work
from .wires import Wires

if TYPE_CHECKING:
    from pandas import DataFrame

    from .frames import Step
    from .history import Recorded
    from .tables import Tables

__all__ = ["Costs"]

Floats = npt.NDArray[np.float64]
BIN_BYTES, CELL_BYTES, PROPOSAL_BYTES = 12.0, 32.0, 90.0
"""Bytes of a histogram's bin, of a cell, and of an answer without them."""
NUMBER_BYTES = 4.0
"""Bytes of a birth's number, which calculators exchange if they create the births."""
ENOUGH = 1000
"""From this many migrants on, bytes of messages tell a migrant's bytes."""
MIGRANT_BYTES = 36.0
"""Bytes of a migrant if a log does not tell: position, velocity, age and id."""


class Costs:
    """Costs per frame; arrays are (frames, ranks) or (frames, calculators)."""

    def __init__(self, run: Tables, history: Recorded, migrant_s: float | None = None) -> None:
        """Read the costs of a run.

        Args:
            run: the recorded run.
            history: its loads.
            migrant_s: seconds per migrant for each of the two calculators, its bytes included, if known;
                None: as logged.
        """
        self.cast = _cast(run.facts, history.ranks)
        self.wires = Wires(run.links, run.hosts)
        self._own = list(history.ranks)
        self._history = history
        self.scale = scale = float(run.facts.get("scale") or 1.0)
        self._handling(run, scale, migrant_s)
        self._activities(run)
        frames = run.frames.set_index("frame").reindex(history.frames)
        self._paths = _texts(frames, "render_path")
        self.shared_pictures = np.isin(self._paths, ("tiles", "composite"))
        self._sent_bytes = np.nan_to_num(_column(frames, "render_bytes")) * scale
        record_bytes = np.nan_to_num(_column(frames, "record_bytes")) * scale
        self._sizes = np.where(record_bytes > 0, record_bytes, self._sent_bytes)
        self._strewn_at: dict[int, float] = {}
        self._slow = np.ones(self.cast.size)
        self._slow[self._own] = history.slowness() / history.slowness().min()
        self._created_by_manager = np.array([by != "calculators" for by in _texts(frames, "births_by")])
        self.actual_s = self._durations(run, frames)

    def clocks(self) -> Clocks:
        """Return new clocks, at 0."""
        return Clocks(self.cast, self.wires.idle())

    def of_step(
        self, step: Step, decentralised: bool, *, moving: float = 1.0, as_drawn: bool = False
    ) -> Work:
        """Return the work of a replayed frame.

        Args:
            step: the frame.
            decentralised: whether neighbours compare their loads before they answer the manager's plan.
            moving: factor for migrants, unless they are as recorded.
            as_drawn: whether the picture costs what it cost in the recorded run.
        """
        then = self._history.flows(step.k)
        flows = [
            one.flows if one.flows is known else one.flows * moving
            for one, known in zip(step.systems, then, strict=True)
        ]
        work = self._work(step.k, step.seconds, step.particles, flows)
        if as_drawn:
            self._draw(work, step.k, self._history.held[step.k], self._history.acted[step.k])
        created = sum(one.created for one in step.systems)
        self._add_births(work, step.k, np.asarray(created, np.float64))
        work.plans = any(one.plan is not None for one in step.systems)
        for one in step.systems:
            if one.plan is None:
                continue
            if len(one.plan.shares):
                self._ask(
                    work, one.n_end, range(len(self._own)), len(one.plan.shares), hasattr(one.cuts, "axes")
                )
            donors = [source for source, _, count in one.plan.orders if count > 0]
            if donors:
                self._ask(work, one.n_end, donors)
            if decentralised:
                pairs = {(min(a, b), max(a, b)) for a, b, _ in one.plan.orders}
                work.pairs = [*work.pairs, *((self._own[a], self._own[b]) for a, b in sorted(pairs))]
        return work

    def recorded(self, k: int) -> Work:
        """Return the work of a recorded frame, as if it were a replayed one."""
        history = self._history
        work = self._work(k, history.acted[k], history.held[k], history.flows(k))
        self._add_births(work, k, history.created[k])
        work.plans = history.plans
        for n_end, donors, shares, bricks in history.cut_requests(k):
            self._ask(work, n_end, donors, len(self._own) if shares else 0, bricks)
            if history.decentralised:
                pairs = {(c, c + 1) for c in donors if c + 1 < len(self._own)}
                work.pairs = [*work.pairs, *((self._own[a], self._own[b]) for a, b in sorted(pairs))]
        return work

    @cached_property
    def then_s(self) -> Floats:
        """Seconds of the recorded frames by the clocks, (frames,)."""
        clocks = self.clocks()
        return np.array([clocks.frame(self.recorded(k)) for k in range(len(self._history.frames))])

    # --- the parts of a frame

    def _work(self, k: int, act_s: Floats, particles: npt.ArrayLike, flows: Sequence[Floats]) -> Work:
        size, own = self.cast.size, self._own
        work = Work.none(size)
        work.births_s = self.births_s[k].copy()
        work.own_s = self.own_s[k]
        work.act_s[own] = act_s + self.rest_s[k]
        moved = np.sum(flows, axis=0)
        work.act_s[own] += self.pack_s * moved.sum(axis=1)
        work.migrants = [
            (own[a], own[b], float(moved[a, b]) * self.migrant_bytes, float(moved[a, b] * self.unpack_s[b]))
            for b in range(len(own))
            for a in range(len(own))
            if moved[a, b] > 0
        ]
        n = np.asarray(particles, np.float64)
        self._draw(work, k, n, act_s)
        return work

    def _draw(self, work: Work, k: int, n: Floats, act_s: Floats) -> None:
        """Add the picture: who draws, and the messages with records of particles."""
        work.project_s[self._own] = self.project_each_s[k] * n
        work.draw_s = self.draw_s[k]
        if not work.draw_s.any():
            return
        sizes = np.zeros((len(n), self.cast.size))
        if self._paths[k] == "tiles":
            work.draw_s = self._dealt(k, act_s)
            sizes = self._sizes[k] * _spread(n, work.draw_s / self._slow, self.cast, self._strewn(k))
        elif self._paths[k] == "gather":
            sizes[:, self.cast.image_generator] = self._sent_bytes[k] * n / max(n.sum(), 1.0)
        sizes[np.arange(len(n)), self._own] = 0.0
        work.records = [
            (self._own[c], int(rank), float(sizes[c, rank]))
            for c, rank in zip(*np.nonzero(sizes), strict=True)
        ]

    def _strewn(self, k: int) -> float:
        """Return the part of all records that are drawn anywhere, and not near their calculator, in tiles."""
        if k not in self._strewn_at:
            n, drawn = self._history.held[k], self.draw_s[k] / self._slow
            own = np.arange(len(n)), self._own
            near, anywhere = (1 - _spread(n, drawn, self.cast, part)[own].sum() for part in (0.0, 1.0))
            sent = self._sent_bytes[k] / max(self._sizes[k], 1e-300)
            part = (sent - near) / (anywhere - near) if anywhere > near else 0.0
            self._strewn_at[k] = min(max(float(part), 0.0), 1.0)
        return self._strewn_at[k]

    def _dealt(self, k: int, act_s: Floats) -> Floats:
        """Return the seconds of each rank's tiles, dealt so that all finish together with their actions.

        That is how the manager deals them (cpp/engine/render/render_plan.cpp). Recorded seconds tell how far
        it was from that.
        """
        then, now = np.zeros((2, self.cast.size))
        if self.cast.manager != self.cast.image_generator:
            then[self._own], now[self._own] = self._history.acted[k], act_s
            then[self.cast.manager], now[self.cast.manager] = then.max(), now.max()
        work = self.draw_s[k] / self._slow
        dealt = work + _deal(now, work.sum(), self._slow) - _deal(then, work.sum(), self._slow)
        dealt = np.maximum(dealt, 0.0)
        shares: Floats = dealt * (work.sum() / max(dealt.sum(), 1e-300)) * self._slow
        return shares

    def _add_births(self, work: Work, k: int, created: Floats) -> None:
        """Add the births' messages: newborn particles from the manager, or numbers between calculators."""
        if self._created_by_manager[k]:
            work.newborn_bytes[self._own] = created * self.migrant_bytes
        else:
            work.shared_bytes = created * (NUMBER_BYTES * self.scale / len(self._own))

    def _ask(
        self, work: Work, n: npt.ArrayLike, donors: Sequence[int], shares: int = 0, bricks: bool = False
    ) -> None:
        """Let calculators look for cuts: `shares` calculators by histograms; 0: donors by their particles."""
        counts = np.asarray(n, np.float64)
        if work.proposal_bytes is None:
            work.proposal_bytes = np.full(self.cast.size, PROPOSAL_BYTES)
        bins = np.maximum((512.0 + 128.0 * shares) * counts / max(counts.sum(), 1.0), 8.0)  # balance.cpp
        for c in donors:
            work.search_s[self._own[c]] += self.search_s[c] * counts[c]
            if shares:
                work.proposal_bytes[self._own[c]] += bins[c] * (CELL_BYTES if bricks else BIN_BYTES)

    # --- reading

    def _handling(self, run: Tables, scale: float, migrant_s: float | None) -> None:
        """Read seconds and bytes per migrant, and seconds per particle to look for a cut."""
        load = run.load

        def of_each(name: str, default: float = 0.0) -> Floats:
            if name not in load.columns:
                return np.full(len(self._own), default)
            # One value per system; a calculator that has none is as fast as the others, by their speeds.
            table = load.groupby(["rank", "frame"])[name].mean().unstack(0).reindex(columns=self._own)
            last = table.ffill().iloc[-1].to_numpy(np.float64)
            return _guessed(last, self._history.slowness(), default)

        self.pack_s, self.unpack_s = of_each("pack_each_s"), of_each("unpack_each_s")
        self.search_s = of_each("search_each_s")
        sent = float(load["sent"].sum())
        tried = load["migrant_bytes"].mean() if "migrant_bytes" in load.columns else np.nan
        each = float(load["bytes_sent"].sum()) / sent if sent else MIGRANT_BYTES
        if sent < ENOUGH and not np.isnan(tried):
            each = float(tried)
        self.migrant_bytes = each * scale
        self.known = "pack_each_s" in load.columns and bool(load["pack_each_s"].notna().any())
        if migrant_s is not None:
            self.pack_s = self.unpack_s = np.full(len(self._own), migrant_s)
            self.migrant_bytes = 0.0

    def _activities(self, run: Tables) -> None:
        """Read what each rank spends its time on besides actions and migrants."""
        history, size = self._history, self.cast.size
        frames = history.frames
        times = run.times
        acted = history.acted[: len(frames)]
        held = history.held[: len(frames)]
        self.births_s, self.own_s, self.draw_s = np.zeros((3, len(frames), size))
        self.rest_s, self.project_each_s = np.zeros((2, len(frames), len(self._own)))
        self.measured = len(times) > 0
        if not self.measured:
            return

        def of(name: str) -> Floats:
            grid = times.pivot(index="frame", columns="rank", values=name)
            filled: Floats = grid.reindex(index=frames, columns=range(size)).fillna(0.0).to_numpy(np.float64)
            return filled

        self.births_s = of("births_s")
        self.own_s = of("script_s") + of("log_s") + of("other_s")
        pictures = of("picture_s")
        sent = np.array([np.sum(history.flows(k), axis=0).sum(axis=1) for k in range(len(frames))])
        self.rest_s = np.maximum(of("act_s")[:, self._own] - acted - self.pack_s * sent, 0.0)
        projected = self._projected(run, pictures[:, self._own])
        self.project_each_s = projected / np.maximum(held, 1.0)
        self.draw_s = pictures.copy()
        self.draw_s[:, self._own] = np.maximum(pictures[:, self._own] - projected, 0.0)
        self.draw_s[self.draw_s < 1e-3 * np.maximum(pictures.max(axis=1, keepdims=True), 1e-12)] = 0.0

    def _projected(self, run: Tables, pictures: Floats) -> Floats:
        """Return the seconds in which calculators made records of their particles."""
        load = run.load
        if "t_project_s" not in load.columns or not load["t_project_s"].notna().any():
            return pictures
        grid = load.pivot_table(index="frame", columns="rank", values="t_project_s", aggfunc="max")
        grid = grid.reindex(index=self._history.frames, columns=self._own)
        seconds: Floats = np.minimum(np.nan_to_num(grid.to_numpy(np.float64)), pictures)
        return seconds

    def _durations(self, run: Tables, frames: DataFrame) -> Floats:
        """Return the recorded seconds of each frame, which add up to the run's."""
        seconds = frames["t_frame_s"].to_numpy(np.float64)
        if not self.measured:
            return seconds
        walls = run.times.pivot(index="frame", columns="rank", values="wall_s").sort_index()
        ends = walls.fillna(0.0).cumsum().max(axis=1)
        spent = ends.diff().fillna(ends).reindex(self._history.frames).to_numpy(np.float64)
        return np.where(np.isnan(spent), seconds, spent)


def _cast(facts: Mapping[str, Any], calculators: Sequence[int]) -> Cast:
    ranks = facts.get("ranks")
    size = len(ranks) if isinstance(ranks, list) else int(ranks or 0)
    manager = int(facts.get("manager") or 0)
    generator = int(facts.get("image_generator") or 0)
    size = max(size, manager + 1, generator + 1, *(rank + 1 for rank in calculators))
    return Cast(manager, generator, list(calculators), size, int(facts.get("fan_out") or 8))


def _deal(busy: Floats, work: float, slow: Floats) -> Floats:
    """Deal out work so that ranks that are `busy` for some seconds finish together (render_plan.cpp).

    `work`: seconds of the fastest rank; `slow`: how many times as long each rank takes.
    """
    busy = np.minimum(busy - busy.min(), work / (1 / slow).sum())
    order = np.argsort(busy, kind="stable")
    speed = np.cumsum(1 / slow[order])
    levels = (work + np.cumsum(busy[order] / slow[order])) / speed
    level = levels[np.flatnonzero(levels >= busy[order])[-1]] if work > 0 else 0.0
    dealt: Floats = np.maximum(level - busy, 0.0) / slow
    return dealt


def _spread(n: Floats, drawn: Floats, cast: Cast, strewn: float) -> Floats:
    """Return the part of all records that goes from each calculator to each rank, (calculators, ranks).

    Ranks draw stretches of the picture in the order of their domains, with ranks between them that have none
    (render_order.cpp), so most records go to near ranks.

    Args:
        n: particles of each calculator.
        drawn: work of each rank on its stretch.
        cast: who plays which role.
        strewn: the part of records that are drawn anywhere.
    """
    others = [rank for rank in range(cast.size) if rank not in cast.calculators]
    places = [
        ((i + 0.5) / len(some), rank) for some in (cast.calculators, others) for i, rank in enumerate(some)
    ]
    order = [rank for _, rank in sorted(places, key=lambda place: place[0])]
    shares = drawn / max(drawn.sum(), 1e-300)
    parts = n / max(n.sum(), 1.0)
    ends = np.concatenate([[0.0], np.cumsum(shares[order])])
    own = np.concatenate([[0.0], np.cumsum(parts)])
    near = np.zeros((len(n), cast.size))
    overlap = np.minimum(own[1:, None], ends[1:]) - np.maximum(own[:-1, None], ends[:-1])
    near[:, order] = np.maximum(overlap, 0.0)
    return (1 - strewn) * near + strewn * np.outer(parts, shares)


def _guessed(values: Floats, slowness: Floats, default: float) -> Floats:
    """Fill gaps by the other calculators' values, in proportion to the machines' seconds per particle."""
    known = ~np.isnan(values)
    if not known.any():
        return np.full(len(values), default)
    each = float(np.median(values[known] / slowness[known]))
    filled: Floats = np.where(known, values, each * slowness)
    return filled


def _column(frames: DataFrame, name: str) -> Floats:
    if name not in frames.columns:
        return np.zeros(len(frames))
    column: Floats = frames[name].to_numpy(np.float64)
    return column


def _texts(frames: DataFrame, name: str) -> list[Any]:
    return list(frames[name]) if name in frames.columns else [None] * len(frames)
