"""Style of plots: colours that colour-blind readers can distinguish, and axes with units."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

from ... import _extras

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = [
    "HEAT",
    "PALETTE",
    "PHASES",
    "SIGNED",
    "UNDER_WAY",
    "WAIT",
    "axes",
    "cells",
    "beside",
    "finish",
    "integer_frames",
    "new_axes",
    "note",
    "of_phase",
    "of_rank",
]

# Okabe and Ito, "Color Universal Design" (2008), without black, and ordered to make neighbours distinct.
PALETTE = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442")
HEAT = "cividis"
SIGNED = "PuOr"

WAIT = "#CFCFCF"
PHASES = {
    "script": "#E69F00",
    "births": "#56B4E9",
    "create": "#56B4E9",
    "act": "#0072B2",
    "compute": "#0072B2",
    "compare loads": "#DCBFD0",
    "report": "#F0E442",
    "judge": "#A9B4C2",
    "exchange": "#E69F00",
    "send migrants": "#E69F00",
    "receive": "#F6D08B",
    "plan": "#E3B3CF",
    "balance": "#CC79A7",
    "render": "#009E73",
    "image": "#009E73",
    "project": "#009E73",
    "draw": "#8FD3BC",
    "talk": "#CC79A7",
    "picture": "#009E73",
    "log": "#D55E00",
    "other": "#F7F3E3",
    "rest": "#F7F3E3",
    "wait": WAIT,
}
"""Colours of a frame's phases, in order. Names that begin with "wait" are grey, as is the manager's "judge",
which mostly waits for reports."""

UNDER_WAY = "messages"
"""Phase without work, from a report to the last message of its round, while other systems compute."""

_INK = "#333333"


def of_phase(phase: str) -> str:
    """Return a phase's colour; an unknown phase gets one derived from its name."""
    if phase.startswith("wait"):
        return WAIT
    if phase in PHASES:
        return PHASES[phase]
    return PALETTE[sum(phase.encode()) % len(PALETTE)]


def of_rank(position: int) -> str:
    """Return the colour of the calculator at this position."""
    return PALETTE[position % len(PALETTE)]


def axes(ax: Axes | None, size: tuple[float, float] = (7.0, 3.2)) -> Axes:
    """Return `ax`, or new axes if it is None."""
    if ax is not None:
        return ax
    pyplot = _extras.matplotlib("matplotlib.pyplot")
    new: Axes = pyplot.subplots(figsize=size, layout="constrained")[1]
    return new


def new_axes(rows: int, columns: int, size: tuple[float, float], **options: Any) -> tuple[Any, list[Axes]]:
    """Make a figure outside pyplot, for embedding in a page; return it and its axes."""
    figure = _extras.matplotlib("matplotlib.figure").Figure(figsize=size, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    return figure, list(axes.ravel())


def beside(ax: Axes, entries: int, **options: Any) -> dict[str, Any]:
    """Return options for a legend to the right of the axes, in as many columns as its entries need."""
    height = ax.figure.get_window_extent().height / ax.figure.dpi
    rows = max(int(height / 0.24) - 1, 1)
    return {"loc": "center left", "bbox_to_anchor": (1, 0.5), "ncols": -(-entries // rows), **options}


def finish(
    ax: Axes,
    *,
    title: str = "",
    x: str = "frame",
    y: str = "",
    grid: Literal["x", "y", ""] = "y",
    legend: Any = None,
) -> Axes:
    """Label the axes and remove decoration."""
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    if title:
        ax.set_title(title, loc="left", fontsize="medium", color=_INK)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    if grid:
        ax.grid(True, axis=grid, alpha=0.3, linewidth=0.6)
        ax.set_axisbelow(True)
    if legend:
        options = legend if isinstance(legend, dict) else {}
        ax.legend(**{"frameon": False, "fontsize": "small", **options})
    return ax


def integer_frames(ax: Axes) -> None:
    """Put ticks only at integer frames."""
    ax.xaxis.set_major_locator(_extras.matplotlib("matplotlib.ticker").MaxNLocator(integer=True))


def note(ax: Axes, text: str) -> None:
    """Write a note at the top of the axes."""
    box = {"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 2}
    place: dict[str, Any] = {"transform": ax.transAxes, "ha": "right", "va": "top"}
    ax.text(0.99, 0.97, text, fontsize="x-small", color=_INK, bbox=box, **place)


def cells(ax: Axes, table: Any, *, label: str, names: Sequence[str], signed: bool = False) -> None:
    """Draw a table, frames x items, as coloured cells with a colour bar; each item is a row of cells.

    The scale ends at the 99.5th percentile if the largest values are far above it, because one interrupted
    frame would otherwise darken all others.
    """
    import numpy as np

    colors = _extras.matplotlib("matplotlib.colors")
    values = np.ma.masked_invalid(table.to_numpy(dtype=float).T)
    low, high = (float(values.min()), float(values.max())) if values.count() else (0.0, 1.0)
    usual = float(np.percentile(np.abs(values.compressed()), 99.5)) if values.count() else 1.0
    reach = max(abs(low), abs(high)) or 1.0
    far_out = 0 < 1.5 * usual < reach
    reach = usual if far_out else reach
    norm = colors.Normalize(-reach if signed else min(low, 0.0), reach)
    frames = table.index.to_numpy(dtype=float)
    edges = np.concatenate([frames - 0.5, frames[-1:] + 0.5])
    mesh = ax.pcolormesh(
        edges,
        np.arange(len(names) + 1) - 0.5,
        values,
        cmap=SIGNED if signed else HEAT,
        norm=norm,
        rasterized=True,
    )
    few = max(1, -(-len(names) // 16))
    ax.set_yticks(range(0, len(names), few), list(names)[::few])
    extend = ("both" if signed else "max") if far_out else "neither"
    bar = ax.figure.colorbar(mesh, ax=ax, pad=0.01, extend=extend)
    bar.set_label(label)
    bar.outline.set_visible(False)
