"""Parts of a run that was continued from checkpoints: first frame and ranks of each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["latest", "of_facts", "ranks_of"]

Facts = Mapping[str, Any]


def of_facts(facts: Facts) -> list[dict[str, Any]]:
    """Return the facts of each part of a run: its start, and each continuation in the log.

    Each has its first `frame`, and the facts that can differ between parts, such as `ranks` and
    `calculators`.
    """
    continued = [part for part in facts.get("continued") or [] if isinstance(part, dict)]
    names = {"ranks", "calculators"}.union(*continued)
    parts: list[dict[str, Any]] = [{**{name: facts[name] for name in names if name in facts}, "frame": 0}]
    for part in continued:
        # Frames of earlier parts from this one's first frame on have been dropped.
        parts = [earlier for earlier in parts if earlier["frame"] < part["frame"]] + [part]
    return parts


def latest(facts: Facts) -> dict[str, Any]:
    """Return the facts, updated with those of the last part."""
    last = of_facts(facts)[-1]
    return {**facts, **{name: value for name, value in last.items() if name != "frame"}}


def ranks_of(part: Facts) -> list[Any]:
    """Return the entries of `ranks`, one per rank; empty if the log has only their number."""
    told = part.get("ranks")
    return told if isinstance(told, list) else []
