"""A run that was continued from a checkpoint: who took part in it, and from which frame on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["latest", "of_facts", "ranks_of"]

Facts = Mapping[str, Any]


def of_facts(facts: Facts) -> list[dict[str, Any]]:
    """Return the facts of each part of a run: its start, and each continuation that is in the log.

    Each has `frame`, the first one, and what may differ between them, such as `ranks` and `calculators`.
    """
    continued = [part for part in facts.get("continued") or [] if isinstance(part, dict)]
    names = {"ranks", "calculators"}.union(*continued)
    parts: list[dict[str, Any]] = [{**{name: facts[name] for name in names if name in facts}, "frame": 0}]
    for part in continued:
        # What an earlier continuation did from there on has been dropped.
        parts = [earlier for earlier in parts if earlier["frame"] < part["frame"]] + [part]
    return parts


def latest(facts: Facts) -> dict[str, Any]:
    """Return the facts with those of the last part in place of the first one's."""
    last = of_facts(facts)[-1]
    return {**facts, **{name: value for name, value in last.items() if name != "frame"}}


def ranks_of(part: Facts) -> list[Any]:
    """Return the entries of `ranks`, one per rank; none where a log says only how many there were."""
    told = part.get("ranks")
    return told if isinstance(told, list) else []
