"""Parts of a run whose ranks or roles changed: it continued on others, or recovered from a loss of ranks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ._tables import stretches

if TYPE_CHECKING:
    from .run import Run

__all__ = ["parts_of"]

_TABLES = ("frames", "load", "balance", "density", "events", "times", "waits")
_ROLES = ("calculators", "manager", "image_generator")


def parts_of(run: Run) -> list[Run]:
    """Return the parts of a run, in each of which all ranks and their roles stay the same.

    Each has the facts and rows of its frames, so what is computed from it is about its own ranks. A run whose
    ranks never changed is its only part; parts without frames are left out.
    """
    starts: list[dict[str, Any]] = []
    for part in stretches.of_facts(run.facts):
        facts = {**run.facts, **part}
        if not starts or _ranks(facts) != _ranks(starts[-1]):
            starts.append(facts)
    if len(starts) == 1:
        return [run]
    ends = [facts["frame"] for facts in starts[1:]] + [float("inf")]
    parts = [_part(run, facts, end) for facts, end in zip(starts, ends, strict=True)]
    return [part for part in parts if len(part.frames)] or [run]


def _ranks(facts: stretches.Facts) -> list[Any]:
    """Return what must stay the same in a part: the number of ranks, and their roles."""
    told = facts.get("ranks")
    return [len(told) if isinstance(told, list) else told, *map(facts.get, _ROLES)]


def _part(run: Run, facts: dict[str, Any], end: float) -> Run:
    from .run import Run

    first = facts.pop("frame")
    facts.pop("continued", None)
    tables = {name: run.table(name) for name in _TABLES}
    mine = {name: rows[(rows["frame"] >= first) & (rows["frame"] < end)] for name, rows in tables.items()}
    return Run({**facts, "name": run.name}, mine)
