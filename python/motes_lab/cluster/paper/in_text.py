"""Figures given only in the paper's text: speed-ups, the time saved, when eight slow nodes are worth it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from .experiment import Row, measure
from .tables import IN_TEXT, Cell, cells

__all__ = ["Found", "facts", "reproduce", "text"]

FAST_NODES = (4, 5, 6, 7, 8)
PAYS_BELOW = 7
"""Eight A (16 processes) were "only justified when the amount of E800 nodes was lower than seven" (5.1)."""
SAVED = (("snow", "myrinet", 84), ("snow", "fast-ethernet", 68), ("fountain", "myrinet", 66))
"""By how many percent the time was reduced (5.3)."""


@dataclass(frozen=True)
class Adding:
    """The effect of adding eight A nodes, with two processes each, to some B nodes."""

    each: int
    """Processes on each B node."""
    fast: int
    """Number of B nodes."""
    alone: float
    """Speed-up of only the B nodes."""
    added: float
    """Speed-up with eight A nodes added."""


@dataclass(frozen=True)
class Found:
    """All figures of the text, reproduced."""

    speedups: list[Row]
    saved: list[tuple[int, Row]]
    """The text's percentage, and the cell of the tables with the highest speed-up of that kind."""
    adding: list[Adding]
    """Results with one process on each B node, then with two."""

    def pays_below(self, each: int) -> int | None:
        """Return the least number of B nodes to which eight A nodes add no speed; None: they always do."""
        chosen = [one for one in self.adding if one.each == each]
        return min((one.fast for one in chosen if one.added <= one.alone), default=None)


def reproduce(jobs: int = 2) -> Found:
    """Run all experiments; `jobs` simulations at a time."""
    written, highest = cells(IN_TEXT), [_highest(*kind) for *kind, _ in SAVED]
    layouts = [(each, count) for each in (1, 2) for count in FAST_NODES]
    pairs = [cell for each, count in layouts for cell in (_alone(count, each), _with_slow_ones(count, each))]
    rows = measure([*written, *highest, *pairs], jobs)
    tail = rows[len(written) + len(highest) :]
    return Found(
        speedups=rows[: len(written)],
        saved=[(percent, row) for (*_, percent), row in zip(SAVED, rows[len(written) :], strict=False)],
        adding=[
            Adding(each, count, alone.ours, added.ours)
            for (each, count), alone, added in zip(layouts, tail[::2], tail[1::2], strict=True)
        ],
    )


def facts(found: Found) -> dict[str, Any]:
    """Return every figure."""
    return {
        "speedups": [
            {
                **{"experiment": row.cell.experiment, "network": row.cell.network, "nodes": row.cell.nodes},
                **{
                    "variant": row.cell.variant,
                    "paper": row.cell.speedup,
                    "ours": row.ours,
                    "best": row.best,
                },
            }
            for row in found.speedups
        ],
        "saved_percent": [
            {
                **{"experiment": row.cell.experiment, "network": row.cell.network, "paper": percent},
                **{"of_the_table": saved(row.cell.speedup), "ours": saved(row.ours), "best": saved(row.best)},
            }
            for percent, row in found.saved
        ],
        "eight_slow_nodes": {
            **{"pay_below": PAYS_BELOW, "ours": found.pays_below(1), "ours_two_each": found.pays_below(2)},
            "rows": [
                {"fast": one.fast, "processes_each": one.each, "alone": one.alone, "with": one.added}
                for one in found.adding
            ],
        },
    }


def text(found: Found) -> str:
    """Return the figures as three small tables."""
    lines = [f"{'speed-up':76}{'paper':>8}{'ours':>8}{'best':>8}"]
    for row in found.speedups:
        cell = row.cell
        name = f"{cell.experiment}, {cell.network}, {cell.compiler}: {cell.nodes} {cell.variant}"
        lines.append(f"{name:76}{cell.speedup:8.2f}{row.ours:8.2f}{row.best:8.2f}")
    lines += ["", f"{'time saved, %':68}{'its table':>8}{'paper':>7}{'ours':>8}{'best':>8}"]
    for percent, row in found.saved:
        name = f"{row.cell.experiment}, {row.cell.network}: {row.cell.nodes} {row.cell.variant}"
        figures = f"{saved(row.cell.speedup):9.0f}{percent:7}{saved(row.ours):8.0f}{saved(row.best):8.0f}"
        lines.append(f"{name:68}{figures}")
    lines += ["", f"{'snow, myrinet, gcc: speed-up':44}{'alone':>8}{'with 8*A (16 P.)':>20}"]
    for one in found.adding:
        lines.append(f"{f'{one.fast}*B ({one.fast * one.each} P.)':44}{one.alone:8.2f}{one.added:20.2f}")
    lines.append(
        f"in the paper, eight A pay off next to fewer than {PAYS_BELOW} B; here, with one process on"
    )
    lines.append(
        f"each B, next to {_fewer(found.pays_below(1))}; with two, next to {_fewer(found.pays_below(2))}"
    )
    return "\n".join(lines)


def _fewer(count: int | None) -> str:
    if count is None:
        return "all of these"
    return "none of these" if count == FAST_NODES[0] else f"fewer than {count}"


def saved(speedup: float) -> float:
    """Return how much of the time a speed-up saves, in percent."""
    return 100 * (1 - 1 / speedup)


def _highest(experiment: str, network: str) -> Cell:
    """Return the cell of the tables with the highest speed-up."""
    every = [cell for table in (1, 2, 3) for cell in cells(table)]
    chosen = [cell for cell in every if (cell.experiment, cell.network) == (experiment, network)]
    return max(chosen, key=lambda cell: cell.speedup)


def _alone(count: int, each: int) -> Cell:
    return _snow(f"{count}*B", count * each)


def _with_slow_ones(count: int, each: int) -> Cell:
    return _snow(f"{count}*B({count * each})+8*A(16)", count * each + 16)


def _snow(hosts: str, processes: int) -> Cell:
    """Return an experiment for which the paper gives no figure."""
    return replace(cells(1)[-1], table=IN_TEXT, hosts=hosts, processes=processes, speedup=float("nan"))
