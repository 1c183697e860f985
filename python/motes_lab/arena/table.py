"""Scores as text, as a plot, and as a league stored in a file."""

from __future__ import annotations

import importlib.util
import itertools
import json
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from motes.errors import MotesError

from .._engine import extras, files
from .score import Score

__all__ = ["keep", "league", "league_text", "plot", "require_parquet", "rows", "stored", "text"]

GAME = ("machine", "ranks", "workload", "frames", "particles")
"""What makes two results comparable."""
KEY = (*GAME, "balancer")
"""Results with the same key replace each other; the latest is kept."""

Row = dict[str, Any]


def rows(scores: Iterable[Score]) -> list[Row]:
    """Return one row of figures per score."""
    return [score.figures for score in scores]


def league(results: Iterable[Row]) -> list[Row]:
    """Return one row per balancer and size over all of its games of this size, nearest to the optimum first.

    Games are of one size if they have equally many frames and particles per rank. Only those are compared.

    Args:
        results: rows of figures.
    """
    found, every = [], list(results)
    for size, name in dict.fromkeys((_size(row), row["balancer"]) for row in every):
        own = [row for row in every if row["balancer"] == name and _size(row) == size]
        won = sum(row["distance"] <= _least(row, every) for row in own)
        mean = {key: sum(row[key] for row in own) / len(own) for key in ("efficiency", "distance")}
        moved = sum(row["moved"] for row in own)
        sized = {"frames": size[0], "particles_per_rank": size[1]}
        found.append({"balancer": name, **sized, "played": len(own), "won": won, **mean, "moved": moved})
    sizes = list(dict.fromkeys(map(_size, every)))
    return sorted(found, key=lambda row: (sizes.index(_sized(row)), row["distance"]))


def _size(row: Row) -> tuple[int, int]:
    return row["frames"], row["particles"] // row["ranks"]


def _sized(row: Row) -> tuple[int, int]:
    return row["frames"], row["particles_per_rank"]


def _least(row: Row, results: Iterable[Row]) -> float:
    game = [row[name] for name in GAME]
    return float(min(one["distance"] for one in results if [one[name] for name in GAME] == game))


def league_text(results: Iterable[Row]) -> str:
    """Return the text of a league, with a table for each size of games."""
    ranked = league(results)
    width = max(len(row["balancer"]) for row in ranked)
    lines = []
    for size in dict.fromkeys(map(_sized, ranked)):
        own = [row for row in ranked if _sized(row) == size]
        what = f"{size[0]} frames, {size[1]:,} particles per rank" if size[1] else f"{size[0]} frames"
        lines += [f"league: {what}", f"{'':{width}}  efficiency  from optimum  won"]
        for row in own:
            figures = f"{row['efficiency']:10.3f}  {100 * row['distance']:11.2f}%"
            lines.append(f"{row['balancer']:{width}}  {figures}  {row['won']} of {row['played']}")
        lines.append("")
    return "\n".join(lines[:-1])


def text(scores: Sequence[Score]) -> str:
    """Return the text of one table per machine and workload, and of the league."""
    width = max(len(score.balancer) for score in scores)
    lines: list[str] = []
    for machine, workload in dict.fromkeys((score.machine, score.workload) for score in scores):
        own = _played(machine, workload, scores)
        lines += [
            f"{workload} on {machine}: {own[0].ranks} calculators, {own[0].frames} frames, "
            f"{own[0].optimum_s:.4g} s with the best cuts",
            f"{'':{width}}  efficiency  from optimum  moved         seconds",
        ]
        for score in sorted(own, key=lambda one: one.distance):
            figures = f"{score.efficiency:10.3f}  {100 * score.distance:11.2f}%  {score.moved:<12,}"
            wrong = "" if score.verified else "  WRONG: particles are in the wrong place"
            lines.append(f"{score.balancer:{width}}  {figures}  {score.seconds:.4g}{wrong}")
        lines += [
            f"{score.balancer}: decisions take {1e3 * score.decided_s / score.frames:.3g} ms per frame here, "
            f"{score.decided_s / score.seconds:.0%} of the time shown; all ranks would wait for them"
            for score in own
            if score.is_slow_to_decide
        ]
        digests = {score.digest for score in own if score.digest}
        if digests:
            lines.append("one digest: " + digests.pop() if len(digests) == 1 else "DIGESTS DIFFER")
        lines.append("")
    return "\n".join([*lines, league_text(rows(scores))])


def plot(scores: Sequence[Score], path: str | os.PathLike[str]) -> None:
    """Plot each frame's time above the optimum in percent, one panel per machine and workload."""
    Figure = extras.matplotlib("matplotlib.figure").Figure

    games = list(dict.fromkeys((score.machine, score.workload) for score in scores))
    columns = min(3, len(games))
    count = -(-len(games) // columns)
    figure = Figure(figsize=(5.2 * columns, 3.2 * count + 0.8), layout="constrained")
    panels = figure.subplots(count, columns, squeeze=False).ravel()
    names = list(dict.fromkeys(score.balancer for score in scores))
    for panel, (machine, workload) in zip(panels, games, strict=False):
        for score in _played(machine, workload, scores):
            over = [100 * (s / best - 1) for s, best in zip(score.frame_s, score.best_s, strict=True)]
            number = names.index(score.balancer)
            style = ("-", "--", ":")[number // 10 % 3]
            panel.plot(over, style, color=f"C{number % 10}", linewidth=1.3, label=score.balancer)
        panel.set_title(f"{workload} on {machine}", fontsize="medium")
        panel.set_yscale("symlog", linthresh=10)
        panel.grid(alpha=0.3)
        panel.set_xlabel("frame")
        panel.set_ylabel("% above the best cuts")
    for panel in panels[len(games) :]:
        panel.remove()
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize="small")
    figure.savefig(os.fspath(path), dpi=110)


def _played(machine: str, workload: str, scores: Iterable[Score]) -> list[Score]:
    return [score for score in scores if (score.machine, score.workload) == (machine, workload)]


def require_parquet(path: Path) -> None:
    """Raise MotesError if the file of a league needs pyarrow, which is not installed."""
    if path.suffix == ".parquet" and importlib.util.find_spec("pyarrow") is None:
        raise MotesError(f"a league in {path} needs pyarrow: pip install pyarrow, or name a .jsonl file")


def keep(scores: Iterable[Score], path: Path) -> None:
    """Add results to a league's file, replacing earlier ones with the same key.

    Args:
        scores: the results.
        path: of a .parquet file, or of a file of JSON lines.

    Raises:
        MotesError: if the file is something else, or needs pyarrow, which is not installed.
    """
    require_parquet(path)
    found = {tuple(row[name] for name in KEY): row for row in [*stored(path), *rows(scores)]}
    with files.whole_path(path) as draft:
        if path.suffix == ".parquet":
            extras.pandas("a league of results").DataFrame(list(found.values())).to_parquet(draft)
        else:
            draft.write_text("".join(json.dumps(row) + "\n" for row in found.values()))


def stored(path: Path) -> list[Row]:
    """Read a league's file; empty if there is none. Rows of older files, without particles, have 0."""
    if not path.is_file():
        return []
    require_parquet(path)
    try:
        if path.suffix == ".parquet":
            found = extras.pandas("a league of results").read_parquet(path).to_dict("records")
        else:
            found = [json.loads(line) for line in path.read_text().splitlines()]
        every = [{"particles": 0, **row} for row in found]
        for row, name in itertools.product(every, (*KEY, "distance", "efficiency", "moved", "verified")):
            row[name]
    except (ValueError, KeyError, TypeError, OSError) as error:
        reason = f"{type(error).__name__}: {error}"
        raise MotesError(f"{path} is not a league of `motes arena` ({reason})") from None
    return every
