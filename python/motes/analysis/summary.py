"""Summary of a run: warnings as sentences, and HTML for notebooks and reports."""

from __future__ import annotations

import base64
import html as _html
import io
import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from . import explaining
from ._plots import drawing
from ._tables import measures

if TYPE_CHECKING:
    from .run import Run
    from .runs import Runs

__all__ = ["STYLE", "html", "image", "runs_html", "summary_table", "warnings"]

STYLE = """
.motes { font: 14px/1.45 system-ui, sans-serif; }
.motes table { border-collapse: collapse; margin: 0.4em 0; }
.motes td, .motes th { padding: 2px 14px 2px 0; text-align: left; vertical-align: top; }
.motes th { font-weight: normal; opacity: 0.65; white-space: nowrap; }
.motes .warning { border-left: 3px solid #E69F00; padding: 1px 0 1px 9px; margin: 4px 0; }
.motes img { max-width: 100%; background: white; }
"""
SENTENCES = ("crowded", "overlap", "softened", "unseen", "slow_balancer")  # events whose text is a sentence
_TOLD = ("start", "continued", "recovered", "end", "births_dropped")  # kinds reported in other ways


def warnings(run: Run) -> list[str]:
    """Return the sentences that a reader of this run should know first."""
    return [text for rule in _RULES for text in rule(run)]


def _ending(run: Run) -> Iterable[str]:
    if not run.finished:
        n = len(run.frames)
        yield f"The run did not finish: it was killed, or is still running. {n} frames are complete."
    for path in run.torn:
        yield f"The last line of {path.name} was incomplete and is ignored."


def _events(run: Run) -> Iterable[str]:
    dropped = run.frames["dropped"].max() if len(run.frames) else 0
    if dropped > 0:
        yield f"{int(dropped)} births were dropped: capacities were reached."
    explained = run.events["kind"].isin(SENTENCES)
    yield from run.events["text"][explained]
    for text in run.events["text"][run.events["kind"] == "continued"]:
        yield f"The run was continued {text}."
    recovered = run.events[run.events["kind"] == "recovered"]
    for frame, text in zip(recovered["frame"], recovered["text"], strict=True):
        yield f"Before the end, {text}, from frame {frame}."
    others = run.events[~explained & ~run.events["kind"].isin(_TOLD)]
    for kind, n in others["kind"].value_counts().items():
        yield f"{n} event{'s' if n > 1 else ''} of kind {kind}: see run.events."


def _machine(run: Run) -> Iterable[str]:
    if run.speeds:
        factors = ", ".join(f"rank {rank}: {factor:g}" for rank, factor in run.speeds.items())
        yield f"Ranks were slowed down on purpose (MOTES_SPEEDS): {factors}."
    cores = run.facts.get("cores")
    if cores and len(set(run.hosts.values())) == 1 and run.ranks > int(cores):
        yield f"{run.ranks} ranks shared {cores} cores: wall-clock times include waits for a core."


def _balance(run: Run) -> Iterable[str]:
    load = run.load
    if load.empty:
        return
    held = measures.by_rank(load, "n_end").sum()
    idle = [str(rank) for rank in held.index if held[rank] == 0]
    if idle and len(idle) < len(held):
        yield f"No particles in any frame: rank{'s' if len(idle) > 1 else ''} {', '.join(idle)}."
    late = measures.imbalance(load).tail(max(len(run.frames) // 2, 1)).mean()
    if run.balancer.startswith("Static") and late > 1.25:
        saving = explaining.most_saved_by(run)
        seconds = explaining.frame_s_of(run)
        yield (
            f"Cuts were static, and the slowest calculator took {late:.2f} times the mean: perfect balance "
            f"would save at most {explaining.told_s(saving * seconds)} of a frame's "
            f"{explaining.told_s(seconds)} ({saving:.0%})."
        )


def _stopped(run: Run) -> Iterable[str]:
    """Warn about ranks that the operating system kept from working, which processor times do not show."""
    if run.times.empty:
        return
    spent = run.times.groupby("rank")[["wall_s", "other_s", "act_s", "births_s", "picture_s"]].mean()
    worked = spent[["act_s", "births_s", "picture_s"]].sum(axis=1)
    late = spent[(spent["other_s"] > worked) & (spent["other_s"] > 0.2 * spent["wall_s"])]
    for rank, lost_s, wall_s in zip(late.index, late["other_s"], late["wall_s"], strict=True):
        yield (
            f"Rank {rank} was kept from working for {explaining.told_s(float(lost_s))} of a "
            f"frame's {explaining.told_s(float(wall_s))}: it slept, waited for files, or other "
            "processes had its core. Compute times, measured as processor time, do not show this."
        )


_RULES = (_ending, _events, _machine, _balance, _stopped)


# --- HTML


def html(run: Run) -> str:
    """Return a summary for notebooks: figures as text, warnings, and a plot of imbalance and domains."""
    parts = [f"<style>{STYLE}</style><div class='motes'>", f"<b>Run {_escape(run.name)}</b>"]
    parts.append(summary_table(run))
    parts += [f"<div class='warning'>{_escape(text)}</div>" for text in warnings(run)]
    if len(run.times):
        parts.append(explaining.explain(run).html())
    if len(run.load):
        parts.append(_inline_figure(run))
    return "".join(parts) + "</div>"


def summary_table(run: Run) -> str:
    """Return the run's figures as an HTML table."""
    row = run.summary()
    space = row["space"] if isinstance(row["space"], str) else "[{:g}, {:g}] m".format(*row["space"])
    rows = [
        ("ranks", f"{row['ranks']} ({row['calculators']} calculators)"),
        ("balancer", row["balancer"]),
        ("space", space),
        ("systems", ", ".join(run.systems)),
        ("frames", f"{row['frames']} in {row['wall_s']:.3g} s, {_number(row['frames_per_s'])} per second"),
        ("particles", f"{row['particles']:,} at most".replace(",", " ")),
        ("imbalance", f"{_number(row['mean_imbalance'])} (mean of largest / mean; efficiency "
         f"{_number(row['mean_efficiency'])})"),
        ("exchanged", f"{_number(row['exchanged_per_frame'])} particles per frame, "
         f"{_number(row['exchanged_bytes_per_frame'] / 1024)} KiB"),
    ]  # fmt: skip
    if row["moved_to_balance"]:
        rows.append(
            ("moved by balancing", f"{row['moved_to_balance']:,} particles in total".replace(",", " "))
        )
    if not math.isnan(row["parallel_efficiency"]):
        rows.append(("parallel efficiency", _factors(row)))
    cells = (f"<tr><th>{name}</th><td>{_escape(str(text))}</td></tr>" for name, text in rows)
    return f"<table>{''.join(cells)}</table>"


def _factors(row: dict[str, Any]) -> str:
    parts = ("parallel", "load_balance", "serialisation", "transfer")
    value = {name: f"{row[f'{name}_efficiency']:.0%}" for name in parts}
    return (
        f"{value['parallel']} = load balance {value['load_balance']} x serialisation "
        f"{value['serialisation']} x transfer {value['transfer']} (POP)"
    )


def _number(value: float) -> str:
    return "unknown" if math.isnan(value) else f"{value:.3g}" if abs(value) < 1000 else f"{value:,.0f}"


def _escape(text: str) -> str:
    return _html.escape(text)


def _inline_figure(run: Run) -> str:
    try:
        figure, (left, right) = drawing.new_axes(1, 2, (10, 2.9))
    except ImportError as error:
        return f"<div class='warning'>{_escape(str(error))}</div>"
    run.plot.imbalance(ax=left)
    run.plot.domains(ax=right)
    return image(figure, dpi=90)


def image(figure: Any, *, dpi: int = 110) -> str:
    """Return a figure as an inline HTML image."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi)
    text = base64.b64encode(buffer.getvalue()).decode()
    return f'<img alt="" width="{figure.get_figwidth() * 72:.0f}" src="data:image/png;base64,{text}">'


def runs_html(runs: Runs) -> str:
    """Return an HTML table of several runs for notebooks."""
    if not len(runs):
        return "<p>no runs</p>"
    columns = ["configuration", "balancer", "ranks", "calculators", "frames", "frames_per_s"]
    columns += ["particles", "mean_imbalance", "mean_efficiency", "finished"]
    table = runs.table[columns]
    return str(table.to_html(float_format=lambda value: f"{value:.3g}", border=0))
