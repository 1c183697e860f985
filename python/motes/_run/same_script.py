"""Check whether a checkpoint was made by this script, with these arguments."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

__all__ = ["changed_setting", "difference", "facts"]

_SHOWN = 60  # most characters of a line that are shown


def facts() -> dict[str, Any]:
    """Return the facts about the script for a checkpoint; path and text are empty if it is not a file."""
    path = Path(sys.argv[0]) if sys.argv and sys.argv[0] else None
    text = path.read_text(errors="replace") if path is not None and path.is_file() else ""
    import hashlib

    digest = hashlib.sha256(text.encode()).hexdigest()
    return {
        "path": str(path) if path else "",
        "sha256": digest,
        "text": text,
        "arguments": sys.argv[1:],
    }


def changed_setting(settings: Iterable[tuple[str, Any, Any]]) -> str:
    """Describe the first argument of World that has changed, given (name, then, now); "" if none has."""
    for name, then, now in settings:
        if then != now:
            return f"World({name}=...) was {then!r} and is {now!r}"
    return ""


def difference(then: dict[str, Any], now: dict[str, Any]) -> str:
    """Describe how this script or its arguments differ from those of `facts`; "" if they do not.

    The text may be left out.
    """
    if then["arguments"] != now["arguments"]:
        return (
            f"the script's arguments were {_arguments(then['arguments'])} and are "
            f"{_arguments(now['arguments'])}"
        )
    if then["sha256"] == now["sha256"]:
        return ""
    if "text" not in then:
        return f"it was made by {then['path'] or 'no script'}, whose text was a different one"
    pairs = itertools.zip_longest(then["text"].splitlines(), now["text"].splitlines())
    for number, (before, after) in enumerate(pairs, start=1):
        if before != after:
            start = _first_difference(before or "", after or "")
            return f"the script's line {number} was {_line(before, start)} and is {_line(after, start)}"
    return "the script's line endings have changed"


def _arguments(given: list[str]) -> str:
    return repr(" ".join(given)) if given else "none"


def _first_difference(before: str, after: str) -> int:
    pairs = enumerate(zip(before, after, strict=False))
    return next((i for i, (a, b) in pairs if a != b), min(len(before), len(after)))


def _line(text: str | None, difference: int) -> str:
    """Return a line's text, or of a long one the part around the difference."""
    if text is None:
        return "missing"
    start = max(0, difference - _SHOWN // 2) if len(text.strip()) > _SHOWN else 0
    shown = text[start:].strip()
    shown = shown if len(shown) <= _SHOWN else shown[:_SHOWN] + "..."
    return repr("..." + shown if start > 0 else shown)
