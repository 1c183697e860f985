"""Scores as text, as a plot, and as a league stored in a file."""

from __future__ import annotations

import importlib.util
import json
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from .. import _extras
from .._io import files
from .score import Score

__all__ = ["keep", "kept", "league", "plot", "rows", "text"]

KEY = ("machine", "ranks", "workload", "balancer")
"""Results with the same key replace each other; the latest is kept."""


def rows(scores: Iterable[Score]) -> list[dict[str, Any]]:
    """Return one row of figures per score."""
    return [score.figures for score in scores]


def league(scores: Sequence[Score]) -> list[dict[str, Any]]:
    """Return one row per balancer, over all of its games, nearest to the optimum first."""
    found = []
    for name in dict.fromkeys(score.balancer for score in scores):
        own = [score for score in scores if score.balancer == name]
        won = sum(score.distance <= _least(score, scores) for score in own)
        found.append(
            {
                "balancer": name,
                "played": len(own),
                "won": won,
                "efficiency": sum(score.efficiency for score in own) / len(own),
                "distance": sum(score.distance for score in own) / len(own),
                "moved": sum(score.moved for score in own),
            }
        )
    return sorted(found, key=lambda row: row["distance"])


def _least(score: Score, scores: Iterable[Score]) -> float:
    return min(one.distance for one in _played(score.machine, score.workload, scores))


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
    lines.append(f"{'league':{width}}  efficiency  from optimum  won")
    for row in league(scores):
        figures = (
            f"{row['efficiency']:10.3f}  {100 * row['distance']:11.2f}%  {row['won']} of {row['played']}"
        )
        lines.append(f"{row['balancer']:{width}}  {figures}")
    return "\n".join(lines)


def plot(scores: Sequence[Score], path: str | os.PathLike[str]) -> None:
    """Plot each frame's time above the optimum in percent, one panel per machine and workload."""
    Figure = _extras.matplotlib("matplotlib.figure").Figure

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


def keep(scores: Iterable[Score], path: Path) -> Path:
    """Add results to a league's file, replacing earlier ones with the same key.

    Returns the file: Parquet if `path` ends in .parquet and pyarrow is installed, else JSON lines.
    """
    if path.suffix == ".parquet" and importlib.util.find_spec("pyarrow") is None:
        path = path.with_suffix(".jsonl")
    found = {tuple(row[name] for name in KEY): row for row in [*kept(path), *rows(scores)]}
    with files.whole_path(path) as draft:
        if path.suffix == ".parquet":
            _extras.pandas("a league of results").DataFrame(list(found.values())).to_parquet(draft)
        else:
            draft.write_text("".join(json.dumps(row) + "\n" for row in found.values()))
    return path


def kept(path: Path) -> list[dict[str, Any]]:
    """Read a league's file; empty if there is none."""
    if not path.is_file():
        return []
    if path.suffix == ".parquet":
        table: list[dict[str, Any]] = (
            _extras.pandas("a league of results").read_parquet(path).to_dict("records")
        )
        return table
    return [json.loads(line) for line in path.read_text().splitlines()]
