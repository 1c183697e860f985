"""Report of a run as one self-contained HTML file: `python -m motes report RUN`."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

from .._io import files
from ..errors import LogError
from . import summary
from ._plots import drawing
from .run import Run

__all__ = ["write_report"]

_PAGE_STYLE = """
body { max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: #222; background: white; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.1rem; margin: 1.8rem 0 0.3rem; }
p { max-width: 44rem; color: #555; margin: 0.2rem 0 0.4rem; }
pre { overflow-x: auto; background: #f6f6f6; padding: 0.8rem; font-size: 12px; }
summary { cursor: pointer; margin: 0.6rem 0; }
"""
MOST_SYSTEMS = 4


def write_report(run: Run, path: str | os.PathLike[str]) -> Path:
    """Write a run's summary and plots as one HTML file, atomically; return its path.

    Raises LogError if the run has no frame yet or the file cannot be written, MissingExtraError without
    pandas or matplotlib.
    """
    if run.frames.empty or run.load.empty:
        raise run.lacks_rows()
    target = Path(path)
    try:
        files.write_whole(target, lambda file: file.write(_page(run).encode(errors="backslashreplace")))
    except OSError as error:
        raise LogError(f"{target}: cannot write the report: {error.strerror or error}") from error
    return target


def _page(run: Run) -> str:
    name = html.escape(run.name)
    parts = [
        "<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'>",
        "<meta name='viewport' content='width=device-width, initial-scale=1'>",
        f"<title>{name}</title><style>{_PAGE_STYLE}{summary.STYLE}</style></head><body class='motes'>",
        f"<h1>{name}</h1>",
        summary.summary_table(run),
        *(f"<div class='warning'>{html.escape(text)}</div>" for text in run.warnings()),
        f"<h2>Why it takes so long</h2>{run.explain().html()}",
    ]
    for title, text, figure in _figures(run):
        parts += [f"<h2>{html.escape(title)}</h2>", f"<p>{text}</p>" if text else "", summary.image(figure)]
    parts += _details(run)
    return "\n".join(parts) + "\n</body></html>\n"


def _figures(run: Run) -> Iterator[tuple[str, str, Any]]:
    plot = run.plot
    yield (
        "Balance",
        "Imbalance is the slowest calculator's compute time divided by the mean; its inverse is the "
        "fraction of the time in which calculators do not wait for the slowest one.",
        _side_by_side(plot.imbalance, plot.efficiency),
    )
    for system in run.systems[:MOST_SYSTEMS]:
        more = len(run.systems) - MOST_SYSTEMS
        text = f"The first {MOST_SYSTEMS} of {len(run.systems)} systems." if more > 0 else ""
        shown = text if system == run.systems[0] else ""
        yield f"Domains of {system}", shown, _one(partial(plot.domains, system), (9.2, 3.6))
    yield "Shares of the particles", "", _one(plot.shares, (9.2, 3.0))
    tall = min(1.4 + 0.2 * len(run.calculators), 6.0)
    yield "Work by rank", "", _side_by_side(
        partial(plot.heatmap, "t_compute_s"), partial(plot.heatmap, "n_end"), height=tall
    )  # fmt: skip
    text = "Grey is waiting for other ranks." if len(run.times) else ""
    yield "Where the time goes", text, _one(plot.phases, (9.2, 3.2))
    if len(run.waits()) and run.ranks > 1:
        side = min(3.0 + 0.25 * run.ranks, 8.0)
        yield "Who waits for whom", "", _one(plot.waits, (min(side + 1.4, 9.2), side))
    yield "The last frames", "", _one(plot.gantt, (9.2, min(1.6 + 0.3 * run.ranks, 7.0)))
    yield "Exchange between calculators", "", _one(plot.exchange, (9.2, 2.8))
    if len(run.balance):
        yield "Moved by balancing", "", _one(plot.given, (9.2, tall))
    yield "Speed and time", "", _side_by_side(plot.speeds, plot.frame_time)


def _one(draw: Callable[..., Any], size: tuple[float, float]) -> Any:
    figure, (ax,) = drawing.new_axes(1, 1, size)
    draw(ax=ax)
    return figure


def _side_by_side(*draws: Callable[..., Any], height: float = 2.9) -> Any:
    figure, axes = drawing.new_axes(1, len(draws), (9.2, height))
    for draw, ax in zip(draws, axes, strict=True):
        draw(ax=ax)
    return figure


def _details(run: Run) -> Iterator[str]:
    facts = dict(run.facts)
    script = facts.pop("script", "")
    if len(run.events):
        table = run.events.tail(200).to_html(index=False, border=0)
        yield f"<details><summary>Events</summary>{table}</details>"
    text = html.escape(json.dumps(facts, indent=1))
    yield f"<details><summary>Facts (run.json)</summary><pre>{text}</pre></details>"
    if script:
        yield f"<details><summary>Script</summary><pre>{html.escape(script)}</pre></details>"
