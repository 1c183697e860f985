"""Plots of one run: `run.plot.imbalance()` and so on."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._values.space import BY_ID, CURVES, are_bricks
from ...errors import ArgumentError, LogError
from .._tables import measures
from .._tables.stretches import latest
from . import drawing, timeline
from .bricks import draw_bricks
from .domains import draw_domains
from .drawing import finish
from .waiting import draw_waits, wait_matrix

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from pandas import DataFrame, Series

    from ..run import Run

__all__ = ["Plots"]

_LABELS = {
    "t_compute_s": "compute (ms)",
    "t_rescaled_s": "compute, rescaled (ms)",
    "t_exchange_s": "exchange (ms)",
    "t_wait_s": "waiting (ms)",
    "t_image_s": "image (ms)",
    "n_start": "particles at the start",
    "n_end": "particles",
    "created": "particles born",
    "killed": "particles removed",
    "sent": "particles sent",
    "received": "particles received",
    "bytes_sent": "sent (B)",
    "speed": "speed (particles/s)",
}


class Plots:
    """Plots of a run.

    Each draws on `ax`, or on new axes, and returns the matplotlib Axes without showing it.
    """

    def __init__(self, run: Run) -> None:
        """Set the run to plot."""
        self._run = run

    def _title(self, text: str) -> str:
        balancer = self._run.balancer
        return f"{text} · {balancer if len(balancer) <= 40 else balancer.partition('(')[0]}"

    def _load(self) -> DataFrame:
        if self._run.load.empty:
            raise self._run.lacks_rows()
        return self._run.load

    # --- a line over frames

    def efficiency(
        self,
        *,
        column: str = "t_compute_s",
        system: str | None = None,
        smooth: int = 1,
        label: str | None = None,
        ax: Axes | None = None,
    ) -> Axes:
        """Load-balance efficiency, mean / largest over the calculators: with 1, no calculator waits.

        `column`: the quantity to compare, compute seconds or particles ("n_end"). `smooth`: average over this
        many frames. The dashed line at 0.8 is the limit that the POP centre calls acceptable
        (co-design.pop-coe.eu/metrics).
        """
        values = measures.efficiency(self._load(), column, system)
        ax = drawing.axes(ax)
        first = not ax.get_lines()
        self._line(ax, values, smooth, label)
        if first:
            ax.axhline(0.8, color="#888888", linewidth=0.8, linestyle="--", label="_acceptable")
        ax.set_ylim(0, 1.02)
        title = self._title("Load-balance efficiency") if label is None else "Load-balance efficiency"
        return finish(ax, title=title, y="mean / largest", legend=label is not None)

    def imbalance(
        self,
        *,
        column: str = "t_compute_s",
        system: str | None = None,
        smooth: int = 1,
        label: str | None = None,
        ax: Axes | None = None,
    ) -> Axes:
        """Imbalance, largest / mean over the calculators, per frame: from 1 (perfect) to their number.

        `label`: name of the line, for several runs on the same `ax`.
        """
        values = measures.imbalance(self._load(), column, system)
        ax = drawing.axes(ax)
        first = not ax.get_lines()
        self._line(ax, values, smooth, label)
        if first:
            ax.axhline(1.0, color="#888888", linewidth=0.8, linestyle="--", label="_perfect")
        top = max(float(np.nanmax(line.get_ydata())) for line in ax.get_lines())
        ax.set_ylim(1 - 0.05 * max(top - 1, 0.1), 1 + 1.08 * max(top - 1, 0.1))
        title = self._title("Imbalance") if label is None else "Imbalance"
        return finish(ax, title=title, y="largest / mean", legend=label is not None)

    def _line(self, ax: Axes, values: Series, smooth: int, label: str | None) -> None:
        if not isinstance(smooth, int) or smooth < 1:
            raise ArgumentError("smooth", smooth, "a number of frames >= 1")
        color = drawing.PALETTE[sum(not str(x.get_label()).startswith("_") for x in ax.get_lines()) % 7]
        if label is None:
            label = f"_{self._run.name}"
        if smooth > 1:
            ax.plot(values.index, values, color=color, alpha=0.25, linewidth=0.8, label="_raw")
            values = values.rolling(smooth, min_periods=1, center=True).mean()
        ax.plot(values.index, values, color=color, linewidth=1.8, label=label)
        drawing.integer_frames(ax)

    def frame_time(self, *, ax: Axes | None = None) -> Axes:
        """Wall-clock seconds of each frame, with their median and the 95th percentile."""
        frames = self._run.frames
        if frames.empty:
            raise self._run.lacks_rows()
        ax = drawing.axes(ax)
        ax.plot(frames["frame"], frames["t_frame_s"], color=drawing.PALETTE[0], linewidth=1.2)
        for part, style in ((0.5, "--"), (0.95, ":")):
            value = float(frames["t_frame_s"].quantile(part))
            name = "median" if part == 0.5 else "95th percentile"
            ax.axhline(
                value, color=drawing.PALETTE[5], linestyle=style, linewidth=1, label=f"{name}: {value:.3g} s"
            )
        ax.set_ylim(bottom=0)
        drawing.integer_frames(ax)
        return finish(ax, title=self._title("Time per frame"), y="wall clock (s)", legend=True)

    # --- ranks and frames

    def heatmap(
        self, column: str = "t_compute_s", *, system: str | None = None, ax: Axes | None = None
    ) -> Axes:
        """Calculators x frames, coloured by a column of `load`: "t_compute_s", "n_end", "t_wait_s", ..."""
        table = measures.by_rank(self._load(), column, system)
        ranks = [int(rank) for rank in table.columns]
        ax = drawing.axes(ax, (7.0, min(1.6 + 0.28 * len(ranks), 6.0)))
        label = _LABELS.get(column, column)
        table = table * 1e3 if label.endswith("(ms)") else table
        drawing.cells(ax, table, label=label, names=[str(rank) for rank in ranks])
        drawing.integer_frames(ax)
        what = label.partition(" (")[0].capitalize()
        return finish(ax, title=self._title(f"{what} by rank"), y="rank", grid="")

    def domains(
        self,
        system: str | None = None,
        *,
        particles: bool = True,
        frame: int | None = None,
        ax: Axes | None = None,
    ) -> Axes:
        """Domains over time: one band per calculator, with the cuts between them as lines.

        Bricks are shown in one frame (None: the last), in the plane of the first two cut axes.

        With `particles`, if the log has density.jsonl, the middle half of each calculator's particles is
        shaded darker, and their median is a line. `system`: None is the first one.
        """
        load = self._load()
        name = system if system is not None else self._run.systems[0]
        density = (
            measures.of_system(self._run.density, name) if len(self._run.density) and particles else None
        )
        title = "Domains" if len(self._run.systems) == 1 else f"Domains of {name}"
        axes = self._run.axis(name)
        if are_bricks(axes):
            rows = measures.of_system(load, name)
            at = int(rows["frame"].max()) if frame is None else frame
            rows = rows[rows["frame"] == at]
            if not len(rows):
                raise ArgumentError("frame", frame, "a frame of the log")
            ax = drawing.axes(ax, (5.0, 4.4))
            draw_bricks(ax, rows, axes, self._run.calculators, self._run.space)
            title = self._title(f"{title} in frame {at}")
            return finish(ax, title=title, x=f"{axes[0]} (m)", y=f"{axes[1]} (m)", grid="")
        ax = drawing.axes(ax, (7.0, 3.8))
        space = (0.0, 1.0) if axes in CURVES else self._run.space
        draw_domains(ax, measures.of_system(load, name), self._run.calculators, density, space)
        label = _unit(axes, f"{axes} (m)", "position along")
        return finish(ax, title=self._title(title), y=label, grid="")

    def shares(self, column: str = "n_end", *, system: str | None = None, ax: Axes | None = None) -> Axes:
        """Each calculator's share of all particles, or of another column, stacked to 1.

        If ranks were slowed down on purpose (MOTES_SPEEDS), dashed lines show the fair shares.
        """
        ranks = self._run.calculators
        table = measures.shares(self._load(), column, system).reindex(columns=ranks)
        what = "particles" if column == "n_end" else _LABELS.get(column, column).partition(" (")[0]
        title = self._title(f"Shares of {what}")
        ax = drawing.axes(ax)
        colors = [drawing.of_rank(i) for i in range(len(table.columns))]
        values = table.fillna(0.0).to_numpy().T
        values = np.column_stack([values, values[:, -1]])  # gives the last frame its width
        at = np.append(table.index, table.index[-1] + 1)
        ax.stackplot(at, values, step="post", colors=colors, alpha=0.75, edgecolor="white", linewidth=0.8)
        middles = np.cumsum(values[:, -1]) - values[:, -1] / 2
        for rank, middle, width in zip(ranks, middles, values[:, -1], strict=True):
            if width > 0.03:
                ax.annotate(
                    f"rank {rank}",
                    (at[-1], middle),
                    xytext=(4, 0),
                    textcoords="offset points",
                    va="center",
                    fontsize="small",
                )
        if self._run.speeds:
            factors = np.array([self._run.speeds.get(rank, 1.0) for rank in ranks])
            for fair in np.cumsum(factors / factors.sum())[:-1]:
                ax.axhline(fair, color="black", linestyle="--", linewidth=1)
            title += ", dashed: by speed"
        ax.set_ylim(0, 1)
        ax.set_xlim(at[0], at[-1])
        drawing.integer_frames(ax)
        return finish(ax, title=title, y=f"fraction of all {what}", grid="")

    def speeds(self, *, system: str | None = None, ax: Axes | None = None) -> Axes:
        """Particles per second of compute time, one line per calculator.

        If ranks were slowed down on purpose (MOTES_SPEEDS), dashed lines show the speeds expected from their
        factors.
        """
        ranks = self._run.calculators
        table = measures.speeds(self._load(), system).reindex(columns=ranks)
        title = self._title("Speed")
        ax = drawing.axes(ax)
        for i, rank in enumerate(ranks):
            ax.plot(
                table.index, table[rank] / 1e6, color=drawing.of_rank(i), linewidth=1.4, label=f"rank {rank}"
            )
        if self._run.speeds:
            factors = np.array([self._run.speeds.get(rank, 1.0) for rank in ranks])
            full = float(np.nanmedian(table.to_numpy(dtype=float) / factors))
            for i, factor in enumerate(factors):
                ax.axhline(factor * full / 1e6, color=drawing.of_rank(i), linestyle="--", linewidth=0.9)
            title += ", dashed: expected from MOTES_SPEEDS"
        ax.set_ylim(bottom=0)
        drawing.integer_frames(ax)
        legend = {"ncols": 4, "loc": "lower left"} if len(table.columns) <= 12 else None
        return finish(ax, title=title, y="million particles/s", legend=legend)

    # --- messages between ranks

    def exchange(self, *, ax: Axes | None = None) -> Axes:
        """Particles that migrated between calculators (bars) and their bytes (line), per frame."""
        frames = self._run.frames
        if frames.empty:
            raise self._run.lacks_rows()
        ax = drawing.axes(ax)
        edges = np.append(frames["frame"] - 0.5, frames["frame"].iloc[-1] + 0.5)
        ax.stairs(frames["exchanged"], edges, fill=True, color=drawing.PALETTE[4])
        right = ax.twinx()
        right.plot(frames["frame"], frames["exchanged_bytes"] / 1024, color=drawing.PALETTE[5], linewidth=1.4)
        right.set_ylabel("sent (KiB)", color=drawing.PALETTE[5])
        right.spines["top"].set_visible(False)
        # Scales that keep the line above the bars.
        ax.set_ylim(0, 1.35 * max(float(frames["exchanged"].max()), 1.0))
        right.set_ylim(0, 1.1 * max(float(frames["exchanged_bytes"].max()) / 1024, 1e-3))
        drawing.integer_frames(ax)
        return finish(ax, title=self._title("Exchange"), y="particles per frame")

    def given(self, system: str | None = None, *, ax: Axes | None = None) -> Axes:
        """Particles moved by balancing across each cut: + from left to right, - from right to left.

        If the balancer replaces all cuts, there are no donations to count: the plot then shows how far each
        cut moved, in m, or as a fraction of a curve or of the ids. Raises LogError if the balancer evaluated
        no cut.
        """
        balance = self._run.balance
        if balance.empty:
            raise LogError(f"{self._run.name}: no cut was evaluated by {self._run.balancer} (balance.jsonl)")
        balance = measures.of_system(balance, system)
        anew = bool(balance["given"].isna().all())
        balance = balance.assign(went=balance["cut_after"] - balance["cut_before"])
        over = balance.groupby(["frame", "left_rank", "right_rank"])["went" if anew else "given"].sum()
        table: DataFrame = over.unstack(["left_rank", "right_rank"]).sort_index(axis=1)
        frames = range(int(balance["frame"].min()), int(balance["frame"].max()) + 1)
        table = table.reindex(index=frames)
        pairs: list[Any] = list(table.columns)
        names = [f"{int(left)}|{int(right)}" for left, right in pairs]
        ax = drawing.axes(ax, (7.0, min(1.6 + 0.28 * len(names), 6.0)))
        axes = self._run.axis(system or self._run.systems[0])
        label = (
            f"moved to the right ({_unit(axes, 'm', 'fraction of')})" if anew else "particles, left → right"
        )
        drawing.cells(ax, table, label=label, names=names, signed=True)
        drawing.integer_frames(ax)
        title = self._title("Cuts moved" if anew else "Particles moved by balancing")
        return finish(ax, title=title, y="cut", grid="")

    # --- phases

    def phases(self, *, frames: Iterable[int] | None = None, ax: Axes | None = None) -> Axes:
        """Mean seconds per frame of each rank, stacked by activity: script, births, act, ..., wait.

        For logs of earlier versions: phases of all ranks with `World(spans=True)`, else only of calculators.
        """
        self._load()
        table, _ = timeline.phase_seconds(self._run, frames)
        ax = drawing.axes(ax)
        order = [name for name in drawing.PHASES if name in table.columns]
        order += [name for name in table.columns if name not in order]
        order = [name for name in order if table[name].sum() > 0]
        bottom = np.zeros(len(table))
        for phase in order:
            ax.bar(
                range(len(table)),
                table[phase] * 1e3,
                bottom=bottom * 1e3,
                width=0.75,
                color=drawing.of_phase(phase),
                edgecolor="white",
                linewidth=0.6,
                label=phase,
            )
            bottom += table[phase].to_numpy()
        few = max(1, len(table) // 24)
        ax.set_xticks(range(0, len(table), few), [str(rank) for rank in table.index[::few]])
        ax.set_xlim(-0.6, len(table) - 0.4)
        legend = drawing.beside(ax, len(order), reverse=True)
        return finish(ax, title=self._title("Where the time goes"), x="rank", y="ms per frame", legend=legend)

    def waits(self, *, frames: Iterable[int] | None = None, ax: Axes | None = None) -> Axes:
        """Matrix of waits: mean ms per frame that each rank (row) waits because of each other (column).

        As in `Run.waits`, the other is the rank that was late, not the one whose message was awaited. Raises
        LogError for logs of earlier versions.
        """
        waits, times = self._run.waits(), self._run.times
        if frames is not None:
            chosen = list(frames)
            waits, times = (table[table["frame"].isin(chosen)] for table in (waits, times))
        if times.empty:
            raise LogError(f"{self._run.name}: no waits of these frames in the log (waits.jsonl)")
        ranks = sorted(int(rank) for rank in times["rank"].unique())
        side = min(2.6 + 0.3 * len(ranks), 8.0)
        ax = drawing.axes(ax, (side + 1.2, side))
        draw_waits(ax, wait_matrix(waits, ranks, times["frame"].nunique()))
        return finish(
            ax, title=self._title("Who waits for whom"), x="rank waited for", y="waiting rank", grid=""
        )

    def gantt(self, frames: Iterable[int] | None = None, *, ax: Axes | None = None) -> Axes:
        """Timeline of all ranks for some frames; None: the last three.

        Uses spans if the run has them (`World(spans=True)`). Otherwise the durations of phases are laid end
        to end from each frame's start, as the title states.
        """
        starts = timeline.frame_starts(self._run)
        chosen = sorted(starts)[-3:] if frames is None else [f for f in frames if f in starts]
        if not chosen:
            raise (ArgumentError("frames", frames, "frames of the run") if starts else self._run.lacks_rows())
        slices, measured = timeline.slices(self._run, chosen)
        begin = min(starts[frame][0] for frame in chosen)
        ranks = sorted({int(rank) for rank in slices["rank"]})
        ax = drawing.axes(ax, (8.0, min(1.6 + 0.36 * len(ranks), 7.0)))
        self._bars(ax, slices, ranks, begin)
        for frame in chosen:
            at = (starts[frame][0] - begin) * 1e3
            ax.axvline(at, color="#888888", linewidth=0.8, linestyle=":")
            ax.annotate(
                f"{frame}",
                (at, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(0, 3),
                textcoords="offset points",
                fontsize="x-small",
                color="#555555",
            )
        ax.set_yticks(range(len(ranks)), [self._who(rank) for rank in ranks])
        ax.set_ylim(len(ranks) - 0.5, -0.5)
        ax.set_xlim(0, (max(starts[frame][1] for frame in chosen) - begin) * 1e3)
        span = f"frame {chosen[0]}" if len(chosen) == 1 else f"frames {chosen[0]} to {chosen[-1]}"
        title = self._title(span.capitalize() + ("" if measured else ", reconstructed from durations"))
        legend = drawing.beside(ax, slices["phase"].nunique())
        finish(ax, x="time (ms)", grid="x", legend=legend)
        ax.set_title(title, loc="left", fontsize="medium", pad=16)
        return ax

    def _bars(self, ax: Axes, slices: DataFrame, ranks: list[int], begin: float) -> None:
        lanes = {rank: i for i, rank in enumerate(ranks)}
        # Draw short slices last, because they can lie inside others.
        slices = slices.assign(length=slices["end_s"] - slices["start_s"]).sort_values(
            "length", ascending=False
        )
        order = [name for name in drawing.PHASES if (slices["phase"] == name).any()]
        order += [name for name in slices["phase"].unique() if name not in order]
        for depth, phase in enumerate(order):
            mine = slices[slices["phase"] == phase]
            under_way = phase == drawing.UNDER_WAY
            ax.barh(
                [lanes[int(rank)] + (0.43 if under_way else 0) for rank in mine["rank"]],
                mine["length"] * 1e3,
                left=(mine["start_s"] - begin) * 1e3,
                height=0.07 if under_way else 0.72,
                color="#333333" if under_way else drawing.of_phase(phase),
                edgecolor="white",
                linewidth=0.4,
                label=f"{phase} in flight" if under_way else phase,
                zorder=2 + 0.01 * depth,
            )

    def _who(self, rank: int) -> str:
        facts = latest(self._run.facts)
        roles = [
            short
            for short, name in (("manager", "manager"), ("image", "image_generator"))
            if facts.get(name) == rank
        ]
        return f"{rank} {' + '.join(roles)}" if roles else str(rank)


def _unit(axes: str, metres: str, of_a_curve: str) -> str:
    """Return the unit of cuts: `metres` along a spatial axis, else a fraction of the ids or of a curve."""
    if axes == BY_ID:
        return "fraction of the ids"
    return f"{of_a_curve} the {axes.title()} curve" if axes in CURVES else metres
