"""Checks of values read from a log; LogError names the file and line of an impossible value."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...errors import LogError
from .schema import Column

__all__ = ["check_facts", "check_rows", "check_unique"]

Row = dict[str, Any]
_LARGEST = 2**53
"""Largest integer allowed; floats represent integers exactly up to here."""
_HUGE = 1e100
"""Limit of numbers, which leaves room for sums and changes of units within float64."""
_ALLOWED = {int: "a whole number up to 2^53", float: "a number below 1e100", str: "a string"}


def check_unique(rows: Sequence[Row], names: Sequence[str], path: Path) -> None:
    """Raise LogError if two rows have the same key, made of the columns `names`."""
    seen = set()
    for row in rows:
        key = tuple(row.get(name) for name in names)
        if key in seen:
            values = ", ".join(f"{name} {value!r}" for name, value in zip(names, key, strict=True))
            raise LogError(f"{path}: two rows for {values}")
        seen.add(key)


def check_rows(rows: Sequence[Row], columns: Sequence[Column], path: Path, lines: Sequence[int]) -> None:
    """Raise LogError, naming the line, if a known column holds an impossible value.

    `lines`: line number of each row in the file. Unknown columns are not checked.
    """
    for column in columns:
        values = [row.get(column.name) for row in rows]
        if not _all_good(values, column):
            for value, line in zip(values, lines, strict=True):
                if not _all_good([value], column):
                    allowed = _ALLOWED[column.kind] + ("" if column.key else " or null")
                    if column.key and column.kind is int:
                        allowed += " and >= 0"
                    raise LogError(
                        f"{path}, line {line}: {column.name} must be {allowed}, got {_short(value)}"
                    )


def _all_good(values: list[Any], column: Column) -> bool:
    """Return whether a column may hold these values; checking types first is fast for whole tables."""
    kinds = set(map(type, values))
    if type(None) in kinds:
        if column.key:
            return False
        values = [value for value in values if value is not None]
        kinds.discard(type(None))
    if not values:
        return True
    if column.kind is str:
        return kinds == {str} and _is_unicode("".join(values))
    if column.kind is int:
        least = 0 if column.key else -_LARGEST
        return kinds == {int} and least <= min(values) and max(values) <= _LARGEST
    return kinds <= {int, float} and min(values) > -_HUGE and max(values) < _HUGE


def _is_unicode(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:  # half of a surrogate pair
        return False
    return True


def check_facts(facts: Mapping[str, Any], path: Path) -> None:
    """Raise LogError if a known fact in run.json has an impossible value; unknown facts are not checked."""
    for name, (allowed, is_good) in _FACTS.items():
        value = facts.get(name)
        if value is not None and not is_good(value):
            raise LogError(f"{path}: {name} must be {allowed}, got {_short(value)}")


def _is_rank(value: Any) -> bool:
    return type(value) is int and 0 <= value <= 2**31


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _are(test: Callable[[Any], bool]) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, list) and all(map(test, value))


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and abs(value) < _HUGE


def _is_space(value: Any) -> bool:
    return _is_text(value) or (_are(_is_number)(value) and len(value) == 2)


def _is_host(value: Any) -> bool:
    return isinstance(value, dict) and _is_rank(value.get("rank")) and _is_text(value.get("host", ""))


def _are_speeds(value: Any) -> bool:
    return isinstance(value, dict) and all(
        rank.isascii() and rank.isdigit() and _is_number(speed) and speed > 0 for rank, speed in value.items()
    )


def _are_calculators(value: Any) -> bool:
    return _are(_is_rank)(value) and len(set(value)) == len(value)


def _is_continuation(value: Any) -> bool:
    return (
        isinstance(value, dict)
        and _is_rank(value.get("frame"))
        and value["frame"] > 0
        and all(value.get(name) is None or test(value[name]) for name, (_, test) in _FACTS.items())
    )


_FACTS: dict[str, tuple[str, Callable[[Any], bool]]] = {
    "argv": ("a list of strings", _are(_is_text)),
    "axes": ("a list of strings", _are(_is_text)),
    "axis": ("a string", _is_text),
    "balancer": ("a string", _is_text),
    "calculators": ("a list of different ranks", _are_calculators),
    "continued": ("a list of objects, each with a frame > 0 and facts", _are(_is_continuation)),
    "cores": ("a whole number", _is_rank),
    "host": ("a string", _is_text),
    "image_generator": ("a rank", _is_rank),
    "manager": ("a rank", _is_rank),
    "name": ("a string", _is_text),
    "pid": ("a whole number", _is_rank),
    "ranks": ("a number, or a list of ranks and hosts", lambda v: _is_rank(v) or _are(_is_host)(v)),
    "script": ("a string", _is_text),
    "script_sha256": ("a string", _is_text),
    "space": ("a string or two numbers", _is_space),
    "speeds": ("speeds by rank", _are_speeds),
    "systems": ("a list of strings", _are(_is_text)),
}


def _short(value: object, limit: int = 60) -> str:
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # more digits or deeper nesting than Python's limits
        text = f"a value of type {type(value).__name__}"
    return text if len(text) <= limit else text[: limit - 3] + "..."
