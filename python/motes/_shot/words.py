"""Values as text in USD's own notation (.usda)."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

import numpy as np

__all__ = ["asset", "indented", "matrix", "number", "quoted", "vector", "vectors"]


def number(value: Any) -> str:
    """Return a finite number with the nine digits that float32 needs."""
    return f"{float(value) + 0.0:.9g}"  # no -0


def vector(values: Iterable[Any]) -> str:
    """Return a tuple of numbers."""
    return f"({', '.join(map(number, values))})"


def vectors(rows: Iterable[Iterable[Any]]) -> str:
    """Return an array of tuples."""
    return f"[{', '.join(map(vector, rows))}]"


def matrix(rows: Any) -> str:
    """Return a transform, (4, 4), whose columns are axes and position: USD writes those as rows."""
    lines = (", ".join(f"{one:.15g}" for one in row) for row in np.asarray(rows, np.float64).T + 0.0)
    return f"( {', '.join(f'({line})' for line in lines)} )"


def quoted(value: str) -> str:
    """Return a text in quotation marks."""
    letters = (letter if letter.isprintable() else " " for letter in value)
    return json.dumps("".join(letters), ensure_ascii=False)


def asset(folder: str, file: str) -> str:
    """Return the path of a file in a folder beside the stage."""
    around = "@@@" if "@" in folder else "@"
    return f"{around}./{folder}/{file}{around}"


def indented(lines: Iterable[str], by: int = 4) -> str:
    """Return lines, indented."""
    return "\n".join(" " * by + line for line in lines)
