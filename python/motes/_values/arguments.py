"""Checks of arguments: return a valid value, or raise ArgumentError, which says what is allowed."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from ..errors import ArgumentError

__all__ = [
    "FARTHEST",
    "PAIR",
    "choice",
    "color",
    "existing_file",
    "file_path",
    "flag",
    "floats",
    "integer",
    "is_path",
    "key",
    "listed",
    "number",
    "place",
    "rows",
    "triple",
    "whole_numbers",
    "with_z",
]

MOST = 1.7e308  # a larger int does not fit into a float
NO_NUMBERS = (bool, np.timedelta64)  # although their classes are integers
PLAIN = {float, int}
PAIR = "2 numbers stand for (x, y, 0)"
FARTHEST = 1e15  # the largest coordinate in pictures, m: its square still fits into a float32
Triple = tuple[float, float, float]


def number(
    argument: str, value: Any, *, low: float = -math.inf, high: float = math.inf, finite: bool = True
) -> float:
    """Return `value` as a float in low..high."""
    if type(value) is float and low <= value <= high and (not finite or -math.inf < value < math.inf):
        return value  # the fast path: scripts pass hundreds of such numbers in each frame
    if type(value) is int and low <= value <= high and -MOST < value < MOST:
        return float(value)
    if isinstance(value, NO_NUMBERS) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise ArgumentError(argument, value, "a number")
    try:
        if type(value) is int:
            result = float(value)
        else:
            with np.errstate(over="ignore"):
                result = float(value)
    except OverflowError:
        raise ArgumentError(argument, value, _range("a finite number", low, high)) from None
    if math.isnan(result) or (finite and math.isinf(result)) or not low <= result <= high:
        raise ArgumentError(argument, value, _range("a finite number" if finite else "a number", low, high))
    return result


def integer(argument: str, value: Any, *, low: int = 0, high: int | None = None) -> int:
    """Return `value` as an int in low..high."""
    if isinstance(value, NO_NUMBERS) or not isinstance(value, (int, np.integer)):
        raise ArgumentError(argument, value, _range("an integer", low, math.inf if high is None else high))
    result = int(value)
    if result < low or (high is not None and result > high):
        raise ArgumentError(argument, value, _range("an integer", low, math.inf if high is None else high))
    return result


def flag(argument: str, value: Any) -> bool:
    """Return `value`, which must be a bool."""
    if not isinstance(value, (bool, np.bool_)):
        raise ArgumentError(argument, value, "True or False")
    return bool(value)


def choice(argument: str, value: Any, allowed: Sequence[str]) -> Any:
    """Return `value`, which must be one of the allowed strings; typed Any, since callers need a `Literal`."""
    if not isinstance(value, str) or value not in allowed:
        raise ArgumentError(argument, value, " or ".join(repr(text) for text in allowed), known=allowed)
    return value


def key(argument: str, value: Any) -> str:
    """Return a script's key as a string that differs from every script line such as "snow.py:21"."""
    if isinstance(value, bool) or not isinstance(value, (str, int, np.integer)):
        raise ArgumentError(argument, value, "a string or an integer")
    return repr(value if isinstance(value, str) else int(value))


def triple(
    argument: str, value: Any, *, low: float = -math.inf, high: float = math.inf, pair: bool = True
) -> Triple:
    """Return `value`, a vector, as a tuple of floats: 3 finite numbers, or 2, which stand for (x, y, 0).

    `pair=False` requires 3.
    """
    if type(value) is tuple and len(value) == 3:  # the fast path: scripts pass many such vectors per frame
        x, y, z = value
        if (
            type(x) in PLAIN
            and type(y) in PLAIN
            and type(z) in PLAIN
            and low <= x <= high
            and low <= y <= high
            and low <= z <= high
            and -MOST < x < MOST
            and -MOST < y < MOST
            and -MOST < z < MOST
        ):
            return float(x), float(y), float(z)
    try:
        numbers = floats(argument, value, np.float64, "3 numbers")
        if numbers.shape != (3,) and not (pair and numbers.shape == (2,)):
            raise ArgumentError(argument, value, "3 numbers")
    except ArgumentError:
        raise ArgumentError(argument, value, "3 numbers", hint=PAIR if pair else "") from None
    result = (float(numbers[0]), float(numbers[1]), float(numbers[2]) if len(numbers) == 3 else 0.0)
    if not all(math.isfinite(x) and low <= x <= high for x in result):
        raise ArgumentError(argument, value, _range("3 finite numbers", low, high))
    return result


def place(argument: str, value: Any) -> Triple:
    """Return `value`, a vector as in `triple`, with coordinates that pictures can be computed with."""
    return triple(argument, value, low=-FARTHEST, high=FARTHEST)


def named_color(argument: str, text: str) -> Triple:
    """Return the linear RGB of a colour given as text; the table of names is loaded on first use."""
    from . import colors

    return colors.named(argument, text)


def color(argument: str, value: Any, *, low: float = -math.inf, high: float = math.inf) -> Triple:
    """Return `value`, a colour of 3 finite numbers or a text for `named_color`, as a tuple of floats."""
    if isinstance(value, str):
        return named_color(argument, value)
    return triple(argument, value, low=low, high=high, pair=False)


def floats(argument: str, value: Any, dtype: DTypeLike, allowed: str) -> NDArray[Any]:
    """Return `value` as an array of floats; too large ones become infinite."""
    try:
        with np.errstate(over="ignore"):
            array = np.asarray(value)
            # NumPy would parse text, drop imaginary parts, and expose masked values.
            if array.dtype.kind not in "biufO" or np.ma.is_masked(value):
                raise TypeError
            return np.asarray(array, dtype)
    except Exception:  # of any kind: the conversion runs methods of users' classes
        raise ArgumentError(argument, value, allowed) from None


def whole_numbers(argument: str, value: Any, allowed: str) -> NDArray[Any]:
    """Return `value` as an array of whole numbers >= 0; an empty one may come from any type."""
    try:
        array = np.asarray(value)
        whole = array.dtype.kind in "iu" and not np.ma.is_masked(value)
        if array.size and (not whole or (array < 0).any()):
            raise TypeError
    except Exception:  # of any kind: the conversion runs methods of users' classes
        raise ArgumentError(argument, value, allowed) from None
    return array


def with_z(array: NDArray[Any]) -> NDArray[Any]:
    """Return vectors of 3 numbers, shape (..., 3): those of 2 numbers get z = 0."""
    if array.shape[-1] == 3:
        return array
    return np.concatenate([array, np.zeros((*array.shape[:-1], 1), array.dtype)], axis=-1)


def listed(argument: str, value: Any, allowed: str) -> list[Any]:
    """Return the items of `value`."""
    try:
        return list(value)
    except Exception:  # of any kind: this runs methods of users' classes
        raise ArgumentError(argument, value, allowed) from None


def file_path(argument: str, value: Any) -> Path:
    """Return `value`, a string or a path, as a path."""
    if not isinstance(value, (str, os.PathLike)):
        raise ArgumentError(argument, value, "a path")
    try:
        path = Path(value)
        encoded = os.fsencode(path)
    except TypeError:  # a path of bytes
        raise ArgumentError(argument, value, "a path as a string, not bytes") from None
    except UnicodeEncodeError:
        raise ArgumentError(argument, value, "a path that the file system can write") from None
    if b"\0" in encoded:
        raise ArgumentError(argument, value, "a path without null characters")
    return path


def existing_file(argument: str, value: Any) -> Path:
    """Return `value` as the path of a file, not of a folder, nor of a pipe, where a reader could wait."""
    path = file_path(argument, value)
    if path.is_file():
        return path
    allowed = "a regular file" if path.exists() else "an existing file"
    raise ArgumentError(argument, os.fspath(path), allowed)


def is_path(text: str) -> bool:
    """Return whether a text that may be a colour or a path is a path."""
    return "." in text or "/" in text or os.sep in text


def colors_of_rows(argument: str, values: Any) -> Any:
    """Return the linear RGB of a list of colours given as text; return anything else unchanged."""
    texts = isinstance(values, (list, tuple)) and all(isinstance(one, str) for one in values)
    return [named_color(argument, text) for text in values] if texts and values else values


def _range(kind: str, low: float, high: float) -> str:
    if low > -math.inf and high < math.inf:
        return f"{kind} in {low:g}..{high:g}"
    if low > -math.inf:
        return f"{kind} >= {low:g}"
    if high < math.inf:
        return f"{kind} <= {high:g}"
    return kind


def rows(attribute: str, values: Any, width: int, count: int | None) -> NDArray[np.float32]:
    """Return an attribute's float32 column of `width` numbers per particle; `count`: the expected rows."""
    pair = width == 3 and attribute != "color"
    shape = f"(n, {width})" if width > 1 else "(n,)"
    allowed = f"finite numbers of shape {shape}"
    if attribute == "color" and isinstance(values, str):
        values = np.tile(named_color(attribute, values), (1 if count is None else count, 1))
    elif attribute == "color":
        values = colors_of_rows(attribute, values)
    array = floats(attribute, values, np.float32, allowed)
    if pair and array.ndim == 2 and array.shape[1] == 2:
        array = with_z(array)
    array = np.ascontiguousarray(array)
    fits = array.ndim == 2 and array.shape[1] == width if width > 1 else array.ndim == 1
    endless = attribute == "lifetime" and (array > -np.inf).all()
    if not fits or not (np.isfinite(array).all() or endless):
        raise ArgumentError(attribute, values, allowed)
    if count is not None and len(array) != count:
        raise ArgumentError(attribute, values, f"of {count} rows, like position")
    return array
