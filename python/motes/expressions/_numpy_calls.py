"""NumPy functions of expressions: `numpy.sin(column("age"))`, `numpy.float32(2) * expression`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..errors import ArgumentError
from . import _functions as ex
from ._conditions import as_condition
from ._expression import Expression, as_expression, choose, power

__all__ = ["numpy_function", "numpy_ufunc"]

_OPERATORS: dict[str, Callable[..., Any]] = {
    "add": lambda a, b: _expression(a) + b,
    "subtract": lambda a, b: _expression(a) - b,
    "multiply": lambda a, b: _expression(a) * b,
    "divide": lambda a, b: _expression(a) / b,
    "remainder": lambda a, b: _expression(a) % b,
    "negative": lambda a: -a,
    "positive": lambda a: a,
    "less": lambda a, b: _expression(a) < b,
    "less_equal": lambda a, b: _expression(a) <= b,
    "greater": lambda a, b: _expression(a) > b,
    "greater_equal": lambda a, b: _expression(a) >= b,
    "equal": lambda a, b: _expression(a) == b,
    "not_equal": lambda a, b: _expression(a) != b,
    "bitwise_and": lambda a, b: as_condition("operand", a) & b,
    "bitwise_or": lambda a, b: as_condition("operand", a) | b,
    "invert": lambda a: ~as_condition("operand", a),
    "logical_and": lambda a, b: as_condition("operand", a) & b,
    "logical_or": lambda a, b: as_condition("operand", a) | b,
    "logical_not": lambda a: ~as_condition("operand", a),
}
_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "absolute": ex.absolute,
    "arctan2": ex.atan2,
    "clip": ex.clamp,
    "cos": ex.cos,
    "exp": ex.exp,
    "fabs": ex.absolute,
    "floor": ex.floor,
    "log": ex.log,
    "maximum": ex.maximum,
    "minimum": ex.minimum,
    "power": power,
    "sign": ex.sign,
    "sin": ex.sin,
    "sqrt": ex.sqrt,
    "square": lambda a: power(a, 2),
}
_UFUNCS = {**_OPERATORS, **_FUNCTIONS}
_OTHERS: dict[str, Callable[..., Any]] = {
    "clip": ex.clamp,
    "cross": ex.cross,
    "dot": ex.dot,
    "norm": ex.length,
    "where": choose,
}


def numpy_ufunc(ufunc: np.ufunc, method: str, inputs: Sequence[Any], keywords: Mapping[str, Any]) -> Any:
    """Return the expression or condition equivalent to a call of a NumPy ufunc."""
    return _called(
        ufunc.__name__ if method == "__call__" else f"{ufunc.__name__}.{method}", _UFUNCS, inputs, keywords
    )


def numpy_function(function: Callable[..., Any], args: Sequence[Any], keywords: Mapping[str, Any]) -> Any:
    """Return the expression equivalent to a call of a NumPy function that is no ufunc."""
    return _called(function.__name__, _OTHERS, args, keywords)


def _called(
    name: str, known: Mapping[str, Callable[..., Any]], args: Sequence[Any], keywords: Mapping[str, Any]
) -> Any:
    if name not in known:
        allowed = f"one that expressions support: {', '.join(sorted({*_FUNCTIONS, *_OTHERS}))}"
        raise ArgumentError("function", f"numpy.{name}", allowed, known=[*_FUNCTIONS, *_OTHERS])
    if keywords:
        raise ArgumentError(next(iter(keywords)), f"in numpy.{name} of an expression", "left out")
    try:
        return known[name](*args)
    except TypeError:
        raise ArgumentError(
            "operands", f"{len(args)} in numpy.{name}", "as many as the function takes in an expression"
        ) from None


def _expression(value: Any) -> Expression:
    return as_expression("operand", value)
