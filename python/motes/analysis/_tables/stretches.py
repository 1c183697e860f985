"""Parts of a run that was continued from checkpoints: first frame and ranks of each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["changes", "latest", "of_facts", "ranks_of"]

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


def changes(facts: Facts) -> list[dict[str, Any]]:
    """Return the facts of each part of a run in which all ranks and their roles stay the same.

    Each has its first `frame`, and no `continued`.
    """
    parts: list[dict[str, Any]] = []
    for stretch in of_facts(facts):
        part = {name: value for name, value in {**facts, **stretch}.items() if name != "continued"}
        if not parts or _ranks(part) != _ranks(parts[-1]):
            parts.append(part)
    return parts


def _ranks(part: Facts) -> list[Any]:
    """Return what stays the same in a part: the number of ranks, and their roles."""
    ranks = part.get("ranks")
    roles = [part.get(name) for name in ("calculators", "manager", "image_generator")]
    return [len(ranks) if isinstance(ranks, list) else ranks, *roles]


def latest(facts: Facts) -> dict[str, Any]:
    """Return the facts, updated with those of the last part."""
    last = of_facts(facts)[-1]
    return {**facts, **{name: value for name, value in last.items() if name != "frame"}}


def ranks_of(part: Facts) -> list[Any]:
    """Return the entries of `ranks`, one per rank; empty if the log has only their number."""
    ranks = part.get("ranks")
    return ranks if isinstance(ranks, list) else []
