"""Sums over all particles: what `System.total`, `histogram` and `tally` ask of the engine."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, arguments
from .actions.base import Where
from .conditions import Columns, Program, condition_of
from .errors import ArgumentError
from .expressions import Expression, column, compile_values, components_of
from .values import says_near_names

if TYPE_CHECKING:
    from .world import World

__all__ = ["Sums"]

Edges = NDArray[np.float64]


class Sums:
    """Sums over the particles of all ranks. `System` has them."""

    world: World
    _index: int
    _columns: Columns

    @says_near_names
    def total(self, expression: Expression | ArrayLike, *, where: Where = None) -> Any:
        """Sum an expression over all particles. Collective.

        The exact sum of the expression's float32 values, rounded once, whatever the ranks, threads and order;
        so it equals `math.fsum` of these values. With NaN, or both infinities, it is NaN; with one infinity
        it is that one; of no particles it is 0. `total(1)` counts.

        Args:
            expression: a number or a vector per particle.
            where: which particles: those in a shape, or for which a comparison of columns holds; None: all.

        Returns:
            A float, or for a vector an array of 3; on every rank.
        """
        summed = compile_sum(self._columns, (), weights=expression, where=where, time=self.world.time)
        found = self._sum("total", summed)
        return found if len(found) > 1 else float(found[0])

    @says_near_names
    def histogram(
        self,
        expression: Expression,
        edges: ArrayLike,
        weights: Expression | float | None = None,
        *,
        where: Where = None,
    ) -> NDArray[Any]:
        """Count particles by an expression, or sum `weights` in each bin. Collective.

        Bin i holds edges[i] <= value < edges[i + 1], the last one its upper edge too, as in
        `numpy.histogram`. Values outside and NaN are left out.

        Args:
            expression: a number per particle.
            edges: ascending numbers, at least 2; the outer ones may be infinite.
            weights: what is added up in each bin; None: particles are counted.
            where: which particles: those in a shape, or for which a comparison of columns holds; None: all.

        Returns:
            Counts, int64, or sums, float64, exact and rounded once as those of `total`; on every rank.
        """
        bins = [("expression", expression, histogram_edges(edges))]
        time = self.world.time
        summed = compile_sum(self._columns, bins, closed=True, weights=weights, where=where, time=time)
        return self._sum("histogram", summed)

    @says_near_names
    def tally(
        self,
        low: ArrayLike,
        high: ArrayLike,
        shape: Sequence[int],
        weights: Expression | float | None = None,
        *,
        where: Where = None,
    ) -> NDArray[Any]:
        """Count particles in a grid of cells, or sum `weights` in each. Collective.

        The cells' edges are those of `numpy.linspace(low[0], high[0], nx + 1)` and so on; a cell holds its
        lower faces, not its upper ones. Particles outside are left out.

        Args:
            low: the grid's lowest corner, m.
            high: its highest corner, m.
            shape: the number of cells along each axis, (nx, ny, nz).
            weights: what is added up in each cell; None: particles are counted.
            where: which particles: those in a shape, or for which a comparison of columns holds; None: all.

        Returns:
            Counts, int64, or sums, float64, exact and rounded once as those of `total`, indexed [ix, iy, iz];
            on every rank.
        """
        cells = cell_edges(low, high, shape)
        time = self.world.time
        summed = compile_sum(self._columns, cells, weights=weights, where=where, time=time)
        return self._sum("tally", summed).reshape([len(edges) - 1 for _, _, edges in cells])

    def _sum(self, verb: str, what: _core.Sum) -> NDArray[Any]:
        engine = self.world._begin(f"{verb}()", reads=True)
        try:
            return engine.sum(self._index, verb, what)
        finally:
            self.world._end_call(engine)


def compile_sum(
    columns: Columns,
    dimensions: Sequence[tuple[str, Any, Edges]],
    *,
    closed: bool = False,
    weights: Any = None,
    where: Any = None,
    time: float = 0,
) -> _core.Sum:
    """Compile a sum over bins: dimensions are an argument's name, its expression of one number, and edges.

    `closed`: the last edges belong to the last bins. `time`: of the animation, seconds.
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
    """Return the edges of bins as an array, checked."""
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
