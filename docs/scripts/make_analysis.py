"""Write docs/analysis.md's plots from their docstrings, and docs/notes/log.md from the log's schema.

`python docs/scripts/make_analysis.py`. A test compares the files with `page()` and `columns()`, so they
are always up to date.
"""

from __future__ import annotations

import inspect
from pathlib import Path

from motes.analysis._plots import Plots, RunsPlots
from motes.analysis._tables.schema import QUANTILES, TABLES, WAYS, Table

PAGE = Path(__file__).resolve().parents[1] / "analysis.md"
COLUMNS = PAGE.parent / "notes" / "log.md"


def page() -> str:
    """Return the page with a new list of plots."""
    return _between(PAGE.read_text(), "plots", plots())


def columns() -> str:
    """Return the page of columns with new lists."""
    tables = "\n\n".join(table(name, one) for name, one in TABLES.items())
    return _between(COLUMNS.read_text(), "tables", tables)


def _between(text: str, name: str, content: str) -> str:
    start, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
    head, _, rest = text.partition(start)
    return f"{head}{start}\n{content}\n\n{end}{rest.partition(end)[2]}"


def plots() -> str:
    """List the plots."""
    lines = ["## Plots", ""]
    lines += ["Each returns a matplotlib Axes, takes `ax=`, and shows nothing by itself.", ""]
    lines += ["| plot | shows |", "|---|---|"]
    for kind, owner in ((Plots, "run.plot"), (RunsPlots, "runs.plot")):
        for name, method in vars(kind).items():
            if inspect.isfunction(method) and not name.startswith("_") and name != "labels":
                first = inspect.cleandoc(method.__doc__ or "").split("\n\n")[0]
                lines.append(f"| `{owner}.{name}` | {' '.join(first.split())} |")
    return "\n".join(lines)


def table(name: str, one: Table) -> str:
    """Describe one table."""
    when = "" if one.required else "; only if there was something to write"
    call = "()" if name == "waits" else ""
    lines = [f"## `run.{name}{call}`: {one.file}", "", f"One row per {one.row}{when}.", ""]
    for column in one.columns:
        if column.name == "frame":
            continue  # described once at the top of the page
        if column.name[1:] in {name[1:] for name in QUANTILES[1:]}:
            continue
        if column.name in WAYS[1:]:
            continue
        label = f"`{column.name}`"
        meaning = column.meaning
        if column.name == WAYS[0]:
            label = f"`{column.name}` .. `{WAYS[-1]}`"
            meaning = "how far particles moved along the first cut axis: 1/16, 3/16, ... of a sample less far"
        if column.name[1:] == QUANTILES[0][1:]:
            label = f"`{column.name}` .. `{column.name[0]}{QUANTILES[-1][1:]}`"
        if column.name == QUANTILES[0]:
            meaning = "17 quantiles along the first cut axis; null: no particles"
        unit = f" ({column.unit})" if column.unit else ""
        earlier = f"; earlier `{column.earlier}`" if column.earlier else ""
        lines.append(f"- {label}{unit}: {meaning}{earlier}")
    return "\n".join(lines)


if __name__ == "__main__":
    PAGE.write_text(page())
    COLUMNS.write_text(columns())
