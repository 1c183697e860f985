"""The input of a balancer: the loads of one particle system, or of all, after a frame."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from .. import _core

__all__ = ["LoadTable", "table_of"]

T = TypeVar("T", bound=np.generic)

RECORD = np.dtype(
    [
        ("particles", np.int64),
        ("seconds", np.float64),
        ("speed", np.float64),
        ("low", np.float64),
        ("high", np.float64),
    ]
)


class LoadTable:
    """Loads of all calculators, one row each, in the order of their domains.

    `np.asarray(load)` is a structured array (calculators,) with the fields particles, seconds, speed, low,
    high; `load[i]` is one of its records. low and high are the ends of a slab, or of a range of ids; NaN for
    bricks. Arrays are read-only copies.
    """

    def __init__(self, table: _core.BalanceTable) -> None:
        """Wrap the engine's table; the engine passes it to `Balancer.decide`.

        Args:
            table: the engine's table.
        """
        self._table = table

    @property
    def frame(self) -> int:
        """Number of the frame that has just been computed."""
        return self._table.frame

    @property
    def evaluation(self) -> int:
        """How many times the balancer was called for this system before: 0, 1, ..."""
        return self._table.evaluation

    @property
    def system(self) -> str:
        """The particle system's name; "all" for the sum over systems."""
        return self._table.system

    @property
    def particles(self) -> npt.NDArray[np.int64]:
        """Particles after the exchange, int64 (calculators,)."""
        return _kept(self._table.particles.astype(np.int64))

    @property
    def seconds(self) -> npt.NDArray[np.float64]:
        """Time of this frame's actions, rescaled to `particles` (paper 3.2.4), float64 (calculators,)."""
        return _kept(self._table.seconds)

    @property
    def speed(self) -> npt.NDArray[np.float64]:
        """Smoothed particles per second, float64 (calculators,); 0 while unknown."""
        return _kept(self._table.speed)

    @property
    def error(self) -> npt.NDArray[np.float64]:
        """Relative standard error of `speed`, from its samples, float64 (calculators,); 0: unknown."""
        return _kept(self._table.error)

    @property
    def powers(self) -> npt.NDArray[np.float64]:
        """`speed` with unknown values replaced by the mean of the known ones, or 1 if none is known."""
        return _kept(self._table.complete_speed)

    @property
    def cuts(self) -> npt.NDArray[np.float32]:
        """Cuts between domains, metres along the axis, float32 (calculators - 1,), ascending for slabs."""
        return _kept(self._table.cuts)

    @property
    def imbalance(self) -> float:
        """Time of the slowest calculator divided by the mean, from particles and speeds; 1 is perfect."""
        return self._table.imbalance

    def __len__(self) -> int:
        """Return the number of calculators."""
        return len(self._table.particles)

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[np.void]:
        """Return the structured array."""
        records = np.empty(len(self), RECORD)
        ends = np.concatenate([[-np.inf], self._table.cuts, [np.inf]])
        if self._table.bricks:
            ends[:] = np.nan
        records["particles"] = self._table.particles
        records["seconds"] = self._table.seconds
        records["speed"] = self._table.speed
        records["low"] = ends[:-1]
        records["high"] = ends[1:]
        return records if dtype is None else records.astype(dtype)

    def __getitem__(self, key: Any) -> Any:
        """Return one or several records, or a field by name."""
        return np.asarray(self)[key]

    def __repr__(self) -> str:
        """Show the system, the frame and the number of calculators."""
        return f"<LoadTable {self.system!r}, frame {self.frame}: {len(self)} calculators>"


def table_of(load: LoadTable) -> _core.BalanceTable:
    """Return the engine's table; for use elsewhere in the package."""
    return load._table


def _kept(array: npt.NDArray[T]) -> npt.NDArray[T]:
    array.flags.writeable = False
    return array
