"""A reproduced table as text, as plain values and as a plot."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

from ..._engine import extras
from .experiment import Row
from .model import WITHIN

__all__ = ["facts", "plot", "text"]


def facts(rows: Sequence[Row]) -> dict[str, Any]:
    """Return every cell, and the number of cells whose error is within the limit."""
    cells = [
        {
            "nodes": row.cell.nodes,
            "variant": row.cell.variant,
            "paper": row.cell.speedup,
            "ours": row.ours,
            "best": row.best,
            "error": row.error,
            "fitted": row.fitted,
        }
        for row in rows
    ]
    return {"rows": cells, "within": WITHIN[rows[0].cell.table], "near": _near(rows)}


def text(rows: Sequence[Row]) -> str:
    """Return the table, one line per cell; fitted cells have a star, the others are predictions."""
    first = rows[0].cell
    lines = [
        f"Table {first.table}: {first.experiment}, {first.network}, {first.compiler}; speed-up",
        f"{'':38}{'':8}{'paper':>8}{'ours':>8}{'error':>8}{'best':>8}",
    ]
    for row in rows:
        cell = row.cell
        figures = f"{cell.speedup:8.2f}{row.ours:8.2f}{100 * row.error:+7.0f}%{row.best:8.2f}"
        lines.append(f"{cell.nodes:38}{cell.variant:8}{figures}{' *' if row.fitted else ''}")
    share = f"{_near(rows)} of {len(rows)} cells are within {100 * WITHIN[first.table]:.0f} % of the paper"
    return "\n".join([*lines, f"{share}; * the model was fitted to this cell"])


def plot(rows: Sequence[Row], path: str | os.PathLike[str]) -> None:
    """Draw paper, ours and best, one panel per variant."""
    Figure = extras.matplotlib("matplotlib.figure").Figure

    variants = list(dict.fromkeys(row.cell.variant for row in rows))
    figure = Figure(figsize=(3.2 * len(variants) + 1, 4.2), layout="constrained")
    panels = figure.subplots(1, len(variants), sharey=True, squeeze=False)[0]
    for panel, variant in zip(panels, variants, strict=True):
        chosen = [row for row in rows if row.cell.variant == variant]
        names = [row.cell.nodes for row in chosen]
        for label, style, values in (
            ("paper", "ko", [row.cell.speedup for row in chosen]),
            ("ours, the paper's policy", "C0o-", [row.ours for row in chosen]),
            ("ours, best", "C1^-", [row.best for row in chosen]),
        ):
            panel.plot(names, values, style, label=label, fillstyle="none" if style == "ko" else "full")
        panel.set_title(variant)
        panel.tick_params("x", rotation=90)
        panel.set_ylim(bottom=0)
        panel.grid(alpha=0.3)
    panels[0].set_ylabel("speed-up")
    panels[0].legend()
    figure.suptitle(f"Table {rows[0].cell.table}: {rows[0].cell.experiment}")
    figure.savefig(os.fspath(path), dpi=120)


def _near(rows: Sequence[Row]) -> int:
    return sum(abs(row.error) <= WITHIN[row.cell.table] for row in rows)
