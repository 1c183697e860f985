"""Matrix of how long ranks wait for each other."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from pandas import DataFrame

__all__ = ["draw_waits", "wait_matrix"]


def wait_matrix(waits: DataFrame, ranks: list[int], frames: int) -> DataFrame:
    """Return mean seconds per frame that each rank (row) waits for each other (column; -1: several ranks)."""
    table = waits.pivot_table(index="rank", columns="waited_for", values="seconds", aggfunc="sum") / frames
    several = [-1] if -1 in table.columns and table[-1].sum() > 0 else []
    return table.reindex(index=ranks, columns=[*several, *ranks]).fillna(0.0)


def draw_waits(ax: Axes, table: DataFrame) -> None:
    """Draw the matrix, with numbers if there is room for them."""
    values = table.to_numpy() * 1e3
    most = max(float(values.max(initial=0.0)), 1e-9)
    image = ax.imshow(values, cmap="Greys", vmin=0, vmax=most, aspect="equal")
    names = ["several" if str(rank) == "-1" else str(rank) for rank in table.columns]
    few = max(1, len(names) // 24)
    ax.set_xticks(range(0, len(names), few), names[::few])
    ax.set_yticks(range(0, len(table), few), [str(rank) for rank in table.index[::few]])
    if values.size <= 150:
        for (row, column), value in np.ndenumerate(values):
            if value >= 0.005 * most:
                ink = "white" if value > 0.55 * most else "#333333"
                ax.text(column, row, f"{value:.2g}", ha="center", va="center", fontsize="small", color=ink)
    ax.figure.colorbar(image, ax=ax, label="ms per frame", shrink=0.85)
