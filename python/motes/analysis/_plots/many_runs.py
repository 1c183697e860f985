"""Plots of many runs: `runs.plot.speedup()` and so on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import drawing
from .drawing import finish

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..runs import Runs

__all__ = ["RunsPlots"]

_MARKERS = "osD^vP*"


class RunsPlots:
    """Plots of several runs; each draws on `ax`, or on new axes, and returns the matplotlib Axes."""

    def __init__(self, runs: Runs) -> None:
        """Set the runs to plot."""
        self._runs = runs

    def speedup(self, baseline: Any = None, *, ax: Axes | None = None) -> Axes:
        """Speed-up against the number of calculators, one line per configuration; the dashed line is ideal.

        `baseline`: as in `runs.speedup`.
        """
        table = self._runs.speedup(baseline, layout="long")
        ax = drawing.axes(ax, (5.4, 3.8))
        several = table["scene"].nunique() > 1
        keys = ["scene", "configuration"] if several else ["configuration"]
        for i, (key, rows) in enumerate(table.groupby(keys, sort=True)):
            points = rows.groupby("calculators")["speedup"].median()
            ax.plot(
                points.index,
                points,
                color=drawing.of_rank(i),
                marker=_MARKERS[i % len(_MARKERS)],
                linewidth=1.6,
                label=" ".join(map(str, key)),
            )
        most = int(table["calculators"].max())
        ax.plot([1, most], [1, most], color="#888888", linestyle="--", linewidth=0.9, label="ideal")
        ax.set_ylim(bottom=0)
        drawing.integer_frames(ax)
        over = f"times as fast as {table.attrs['baseline']}"
        return finish(ax, title="Speed-up", x="calculators", y=over, legend=True)

    def imbalance(
        self,
        *,
        column: str = "t_compute_s",
        system: str | None = None,
        smooth: int = 1,
        ax: Axes | None = None,
    ) -> Axes:
        """Imbalance of all runs over frames, each labelled by what distinguishes it from the others."""
        ax = drawing.axes(ax)
        for run, label in zip(self._runs, self.labels(), strict=True):
            run.plot.imbalance(column=column, system=system, smooth=smooth, label=label, ax=ax)
        return ax

    def efficiency(
        self,
        *,
        column: str = "t_compute_s",
        system: str | None = None,
        smooth: int = 1,
        ax: Axes | None = None,
    ) -> Axes:
        """Load-balance efficiency of all runs over frames."""
        ax = drawing.axes(ax)
        for run, label in zip(self._runs, self.labels(), strict=True):
            run.plot.efficiency(column=column, system=system, smooth=smooth, label=label, ax=ax)
        return ax

    def labels(self) -> list[str]:
        """Return a short label per run: what distinguishes it from the others, else its directory."""
        parts = [
            [run.balancer for run in self._runs],
            ["infinite" if run.space is None else str(run.space) for run in self._runs],
            [f"{len(run.calculators)} calculators" for run in self._runs],
        ]
        telling = [part for part in parts if len(set(part)) > 1]
        names = [", ".join(parts) for parts in zip(*telling, strict=True)] if telling else []
        return names if len(set(names)) == len(self._runs) else [run.name for run in self._runs]
