"""Draws domains cut along several axes, in one frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from pandas import DataFrame

__all__ = ["draw_bricks"]

Array = npt.NDArray[np.float64]


def draw_bricks(ax: Axes, load: DataFrame, axes: str, calculators: Sequence[int], space: Any) -> None:
    """Draw one frame's bricks, projected to the plane of the first two `axes`."""
    rows = load.set_index("rank").reindex([rank for rank in calculators if rank in set(load["rank"])])
    across = _ends(rows, "domain_lo", "domain_hi")
    along = _ends(rows, f"domain_{axes[1]}_lo", f"domain_{axes[1]}_hi")
    ax.set_xlim(*_limits(across, space))
    ax.set_ylim(*_limits(along, space))
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    for i, rank in enumerate(rows.index):
        x, y = np.clip(across[i], left, right), np.clip(along[i], bottom, top)
        corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
        color = drawing.of_rank(i)
        ax.add_patch(_polygon(corners, facecolor=color, alpha=0.3, edgecolor="none"))
        ax.add_patch(_polygon(corners, facecolor="none", edgecolor="#333333", linewidth=1.0))
        if len(rows) <= 64:
            ax.text(x.mean(), y.mean(), f"rank {rank}", ha="center", va="center", fontsize="small")


def _polygon(corners: list[tuple[float, float]], **style: Any) -> Any:
    from matplotlib.patches import Polygon

    return Polygon(corners, closed=True, **style)


def _ends(rows: DataFrame, low: str, high: str) -> Array:
    """Return both ends of each brick; infinite where the log has none."""
    ends = rows.reindex(columns=[low, high]).to_numpy(dtype=float, copy=True)
    ends[:, 0] = np.where(np.isnan(ends[:, 0]), -np.inf, ends[:, 0])
    ends[:, 1] = np.where(np.isnan(ends[:, 1]), np.inf, ends[:, 1])
    return ends


def _limits(ends: Array, space: Any) -> tuple[float, float]:
    """Return the range to show: all cuts and, if known, the space that was divided."""
    seen = [*ends[np.isfinite(ends)], *(space if isinstance(space, tuple) else ())]
    low, high = (min(seen), max(seen)) if seen else (-1.0, 1.0)
    margin = 0.0 if isinstance(space, tuple) else 0.25 * (high - low) or 1.0
    return low - margin, high + margin
