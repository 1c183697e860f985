"""Sums over all particles: the implementation of `System.total`, `histogram` and `tally`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._values import arguments
from ..actions.base import Where
from ..errors import ArgumentError
from ..expressions import Expression, column
from ..expressions._compiling import compile_values, components_of
from ..expressions._conditions import Columns, Program, condition_of
from .system_state import SystemState

__all__ = ["Sums"]

Edges = NDArray[np.float64]


class Sums:
    """Sums over the particles of all ranks."""

    def __init__(self, state: SystemState) -> None:
        """Create the sums over a system's particles."""
        self._state = state

    def total(self, expression: Expression | ArrayLike, where: Where) -> Any:
        """Sum an expression over all particles: `System.total`."""
        summed = self._compiled((), expression, where)
        total = self._sum("total", summed)
        return total if len(total) > 1 else float(total[0])

    def histogram(self, expression: Expression, edges: ArrayLike, weights: Any, where: Where) -> NDArray[Any]:
        """Count or sum in bins: `System.histogram`."""
        bins = [("expression", expression, histogram_edges(edges))]
        return self._sum("histogram", self._compiled(bins, weights, where, closed=True))

    def tally(
        self, low: ArrayLike, high: ArrayLike, shape: Sequence[int], weights: Any, where: Where
    ) -> NDArray[Any]:
        """Count or sum in the cells of a grid: `System.tally`."""
        cells = cell_edges(low, high, shape)
        sums = self._sum("tally", self._compiled(cells, weights, where))
        return sums.reshape([len(edges) - 1 for _, _, edges in cells])

    def _compiled(
        self,
        bins: Sequence[tuple[str, Any, Edges]],
        weights: Any,
        where: Where,
        *,
        closed: bool = False,
    ) -> _core.Sum:
        columns, time = self._state.columns, self._state.session.time
        return compile_sum(columns, bins, closed=closed, weights=weights, where=where, time=time)

    def _sum(self, verb: str, what: _core.Sum) -> NDArray[Any]:
        session = self._state.session
        engine = session.begin(f"{verb}()", reads=True)
        try:
            return engine.sum(self._state.index, verb, what)
        finally:
            session.end_conversation(engine)


def compile_sum(
    columns: Columns,
    dimensions: Sequence[tuple[str, Any, Edges]],
    *,
    closed: bool = False,
    weights: Any = None,
    where: Any = None,
    time: float = 0,
) -> _core.Sum:
    """Compile a sum over bins; each dimension is an argument's name, its scalar expression, and bin edges.

    `closed`: the last edge of each dimension belongs to its last bin. `time`: the animation time, s.
    """
    shapes: list[_core.Shape] = []
    sorted_by = [
        (compile_values(argument, value, 1, columns, shapes)[0], edges.tolist(), closed)
        for argument, value, edges in dimensions
    ]
    if weights is None:
        weighted: list[Program] = []
    elif dimensions:
        weighted = compile_values("weights", weights, 1, columns, shapes)
    else:
        weighted = components_of("expression", weights, columns, shapes)
    return _core.Sum(sorted_by, weighted, condition_of(where, columns, shapes), shapes, time)


def histogram_edges(edges: ArrayLike) -> Edges:
    """Check bin edges and return them as an array."""
    allowed = "ascending numbers, at least 2; the first and the last may be infinite"
    array = arguments.floats("edges", edges, np.float64, allowed)
    if array.ndim != 1 or len(array) < 2 or not (array[:-1] < array[1:]).all():
        raise ArgumentError("edges", edges, allowed)
    if len(array) - 1 > _core.most_bins:
        raise ArgumentError("edges", f"{len(array)} numbers", f"of at most {_core.most_bins} bins")
    return array


def cell_edges(low: ArrayLike, high: ArrayLike, shape: Any) -> list[tuple[str, Any, Edges]]:
    """Return the dimensions of a regular grid of cells."""
    first = arguments.triple("low", low, pair=False)
    last = arguments.triple("high", high, pair=False)
    cells = [arguments.integer("shape", n, low=1) for n in arguments.listed("shape", shape, "3 integers")]
    if len(cells) != 3:
        raise ArgumentError("shape", shape, "3 integers")
    if cells[0] * cells[1] * cells[2] > _core.most_bins:
        raise ArgumentError("shape", shape, f"of at most {_core.most_bins} cells")
    axes = [np.linspace(a, b, n + 1) for a, b, n in zip(first, last, cells, strict=True)]
    if not all((axis[:-1] < axis[1:]).all() for axis in axes):
        raise ArgumentError("high", high, f"above low = {first} in each component, by more than rounding")
    return [("position", column("position")[i], axis) for i, axis in enumerate(axes)]
