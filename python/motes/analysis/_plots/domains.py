"""Draws domains over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from pandas import DataFrame

__all__ = ["draw_domains"]

Array = npt.NDArray[np.float64]


def draw_domains(
    ax: Axes, load: DataFrame, calculators: Sequence[int], density: DataFrame | None, space: Any
) -> None:
    """Draw one system's domains as bands, its cuts, and the distribution of its particles."""
    left = load.pivot_table(index="frame", columns="rank", values="domain_lo", dropna=False)
    frames = left.index.to_numpy(dtype=float)
    ranks = [rank for rank in calculators if rank in set(load["rank"])]
    right = load.pivot_table(index="frame", columns="rank", values="domain_hi", dropna=False)
    low = left.reindex(columns=ranks).to_numpy(dtype=float, copy=True)
    high = right.reindex(columns=ranks).to_numpy(dtype=float, copy=True)
    bottom, top = _limits(high[:, :-1], density, space)
    outside = int(((high[-1, :-1] < bottom) | (high[-1, :-1] > top)).sum())
    # A run continued on other ranks has no rows for ranks that left; in existing rows, a missing end is
    # infinite.
    rows = load.pivot_table(index="frame", columns="rank", values="n_end", aggfunc="size", dropna=False)
    there = (rows.reindex(columns=ranks).fillna(0) > 0).to_numpy()
    low[there & np.isnan(low)], high[there & np.isnan(high)] = -np.inf, np.inf
    # Draw bands far beyond the visible range, because users may set wider limits afterwards.
    reach = 20 * (top - bottom)
    # Repeat the last frame at its end: otherwise its band would have no width.
    at = np.append(frames, frames[-1] + 1)
    low, high = (np.clip(np.vstack([ends, ends[-1:]]), bottom - reach, top + reach) for ends in (low, high))
    for i, rank in enumerate(ranks):
        color = drawing.of_rank(i)
        ax.fill_between(at, low[:, i], high[:, i], step="post", color=color, alpha=0.22, linewidth=0)
        if i > 0:
            ax.step(at, low[:, i], where="post", color="#333333", linewidth=1.0)
        if density is not None:
            _particles(ax, density[density["rank"] == rank], color)
        if len(ranks) <= 16 and there[-1, i]:
            _name(ax, rank, at[-1], np.clip([low[-1, i], high[-1, i]], bottom, top), top - bottom)
    if outside:
        drawing.note(ax, f"{outside} cut{'s' if outside > 1 else ''} outside the plot")
    ax.set_xlim(at[0], at[-1])
    ax.set_ylim(bottom, top)
    drawing.integer_frames(ax)


def _name(ax: Axes, rank: int, x: float, ends: Array, height: float) -> None:
    """Label a calculator to the right of its domain, if there is room."""
    if ends[1] - ends[0] > 0.025 * height:
        offset: dict[str, Any] = {"xytext": (4, 0), "textcoords": "offset points", "va": "center"}
        text = ax.annotate(f"rank {rank}", (x, float(ends.mean())), annotation_clip=False, **offset)
        text.set(fontsize="small", color="#333333")


def _particles(ax: Axes, density: DataFrame, color: str) -> None:
    density = density.sort_values("frame")
    at = density["frame"].to_numpy(dtype=float) + 0.5
    quartiles = [density[name].to_numpy(dtype=float) for name in ("x_q04", "x_q08", "x_q12")]
    ax.fill_between(at, quartiles[0], quartiles[2], color=color, alpha=0.45, linewidth=0)
    ax.plot(at, quartiles[1], color=color, linewidth=1.4)


def _limits(cuts: Array, density: DataFrame | None, space: Any) -> tuple[float, float]:
    """Return the range to show: particles and cuts near them, because infinite space is mostly empty."""
    seen: list[float] = []
    if density is not None and density["x_q00"].notna().any():
        # Exclude the outermost particles: one outlier would squeeze all others into a line.
        seen = [float(density["x_q01"].min()), float(density["x_q15"].max())]
        reach = seen[1] - seen[0] or 1.0
        seen = [seen[0] - 0.1 * reach, seen[1] + 0.1 * reach]
        near = cuts[(cuts > seen[0] - 0.5 * reach) & (cuts < seen[1] + 0.5 * reach)]
        seen += [float(near.min()), float(near.max())] if near.size else []
    elif isinstance(space, tuple):
        seen = [*space, float(np.nanmin(cuts, initial=space[0])), float(np.nanmax(cuts, initial=space[1]))]
    elif cuts.size:
        moved = cuts[(cuts != cuts[0]) & np.isfinite(cuts)]
        values = moved if moved.size else cuts[np.isfinite(cuts)]
        seen = [float(values.min()), float(values.max())] if values.size else []
    low, high = (min(seen), max(seen)) if seen else (-1.0, 1.0)
    margin = 0.06 * (high - low) or 1.0
    return low - margin, high + margin
