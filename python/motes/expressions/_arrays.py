"""Functions of expressions on NumPy arrays, computed by the engine's own kernels."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any

import numpy as np

from ..errors import ArgumentError
from ._conditions import Condition, Region, components, program_of
from ._expression import Expression, node_of

__all__ = ["takes_arrays"]

_NUMBERS = (int, float, np.integer, np.floating)


def takes_arrays(*vectors: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return a decorator for functions of expressions that lets them take arrays and numbers, too.

    Args:
        vectors: names of the parameters that are vectors; the last axis of their arrays has three components.
    """

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        signature = inspect.signature(function)
        operands = [p.name for p in signature.parameters.values() if p.kind is not p.KEYWORD_ONLY]

        @functools.wraps(function)
        def called(*args: Any, **keywords: Any) -> Any:
            bound = signature.bind(*args, **keywords)
            arrays = {name: bound.arguments[name] for name in operands if name in bound.arguments}
            arrays.pop("curve", None)
            if not _are_values(arrays.values()):
                return function(*args, **keywords)
            columns = {name: _array(name, value, name in vectors) for name, value in arrays.items()}
            bound.arguments.update({name: Expression(("column", name)) for name in columns})
            return _evaluated(function(*bound.args, **bound.kwargs), columns, vectors)

        return called

    return decorate


def _are_values(values: Any) -> bool:
    """Tell whether values are arrays and numbers alone, at least one of them."""
    values = list(values)
    if any(isinstance(value, (Expression, Condition, Region, str)) for value in values):
        return False
    if any(isinstance(value, np.ndarray) for value in values):
        return all(isinstance(value, (*_NUMBERS, np.ndarray, tuple, list)) for value in values)
    return all(isinstance(value, _NUMBERS) and not isinstance(value, bool) for value in values)


def _array(name: str, value: Any, vector: bool) -> np.ndarray:
    array = np.asarray(value)
    if array.dtype.kind not in "iuf":
        raise ArgumentError(name, value, "an array of real numbers, or an expression")
    if vector and (array.ndim == 0 or array.shape[-1] != 3):
        raise ArgumentError(name, value, "an array whose last axis has 3 components, or an expression")
    with np.errstate(over="ignore"):
        return array.astype(np.float32)


def _evaluated(expression: Expression, arrays: dict[str, np.ndarray], vectors: tuple[str, ...]) -> Any:
    """Compute an expression of arrays: float32, an axis of three components last if it is a vector."""
    from .. import _core

    shapes = [array.shape[:-1] if name in vectors else array.shape for name, array in arrays.items()]
    try:
        shape = np.broadcast_shapes(*shapes)
    except ValueError:
        name, array = next(reversed(arrays.items()))
        raise ArgumentError(name, array, f"of a shape that fits the others': {shapes[:-1]}") from None
    planes: list[np.ndarray] = []
    places = {}
    for name, array in arrays.items():
        parts = np.moveaxis(array, -1, 0) if name in vectors else array[None]
        places[name] = (len(planes), len(parts))
        planes += [np.ascontiguousarray(np.broadcast_to(part, shape)).reshape(-1) for part in parts]
    results = [
        _core.evaluate(program_of(steps, []), planes).reshape(shape)
        for steps in components(node_of(expression), places)
    ]
    values = results[0] if len(results) == 1 else np.stack(results, axis=-1)
    return values[()]
