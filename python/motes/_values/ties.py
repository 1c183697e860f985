"""Ties: pairs of tied particles, by id, and the length of each tie."""

from __future__ import annotations

import heapq
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..errors import ArgumentError
from . import arguments
from .values import Value, value

__all__ = ["BEND", "MOST_TETHERS", "SHEAR", "STRETCH", "Tethers", "Ties", "ties_of"]

STRETCH, SHEAR, BEND = 0, 1, 2
MOST_TETHERS = 4  # per particle: to the pinned particles that are nearest along the ties
MOST_TIES = 50_000_000

# Columns with one row per tether: the particle's id, the index of its pinned particle, the length in m.
Tethers: TypeAlias = tuple[NDArray[np.uint64], NDArray[np.uint32], NDArray[np.float32]]


@value()
class Ties(Value):
    """Pairs of particles kept at a fixed distance, for `System.tie`. Immutable.

    Attributes:
        pairs: ids of the tied particles, shape (n, 2).
        lengths: lengths of the ties in m, shape (n,), or one number.
        kinds: 0: the tie resists stretching; 1: shearing; 2: bending; shape (n,). None: all 0.
        pinned: ids of particles that the ties do not move.
    """

    pairs: ArrayLike
    lengths: ArrayLike
    kinds: ArrayLike | None = None
    pinned: ArrayLike = ()

    def __post_init__(self) -> None:
        """Check the arrays and store them in the engine."""
        pairs = _ids("pairs", self.pairs)
        if pairs.size == 0:
            pairs = pairs.reshape(0, 2)
        if pairs.ndim != 2 or pairs.shape[1] != 2 or len(pairs) > MOST_TIES:
            raise ArgumentError("pairs", self.pairs, f"ids of shape (n, 2), at most {MOST_TIES} pairs")
        count = len(pairs)
        lengths = arguments.floats("lengths", self.lengths, np.float32, "numbers >= 0 of shape (n,), or one")
        if lengths.ndim == 0:
            lengths = np.full(count, lengths, np.float32)
        if lengths.shape != (count,) or not np.isfinite(lengths).all() or (lengths < 0).any():
            raise ArgumentError("lengths", self.lengths, f"numbers >= 0 of shape ({count},), or one")
        allowed = f"0, 1 or 2 for each of the {count} ties"
        given = np.zeros(count, np.uint8) if self.kinds is None else self.kinds
        kinds = arguments.whole_numbers("kinds", given, allowed)
        if kinds.shape != (count,) or (kinds > 2).any():
            raise ArgumentError("kinds", self.kinds, allowed)
        pinned = _ids("pinned", self.pinned).reshape(-1)
        if len(set(pinned.tolist())) != len(pinned):
            raise ArgumentError("pinned", self.pinned, "different ids")
        self._keep(pairs, np.ascontiguousarray(lengths), np.ascontiguousarray(kinds, np.uint8), pinned)

    def _keep(
        self,
        pairs: NDArray[np.uint64],
        lengths: NDArray[np.float32],
        kinds: NDArray[np.uint8],
        pinned: NDArray[np.uint64],
        tethers: Tethers | None = None,
    ) -> None:
        if tethers is None:
            tethers = _tethers(pairs, lengths, pinned)
        key = _core.keep_ties(pairs.reshape(-1), lengths, kinds, pinned, *tethers)
        for array in (pairs, lengths, kinds, pinned):
            array.setflags(write=False)
        self.__dict__.update(pairs=pairs, lengths=lengths, kinds=kinds, pinned=pinned, _name=key)

    def __len__(self) -> int:
        """Count the ties."""
        return len(self.__dict__["pairs"])

    def _key(self) -> tuple[Any, ...]:
        return (self.__dict__["_name"],)

    def __repr__(self) -> str:
        """Show only counts: the arrays may be long."""
        return f"<Ties: {len(self)} ties, {len(self.__dict__['pinned'])} particles pinned>"


def ties_of(
    pairs: NDArray[np.uint64],
    lengths: NDArray[np.float32],
    kinds: NDArray[np.uint8],
    pinned: NDArray[np.uint64],
    tethers: Tethers,
) -> Ties:
    """Return ties with the given arrays and tethers, unchecked."""
    ties = object.__new__(Ties)
    ties._keep(pairs, lengths, kinds, pinned, tethers)
    return ties


def _tethers(pairs: NDArray[np.uint64], lengths: NDArray[np.float32], pinned: NDArray[np.uint64]) -> Tethers:
    """Find each particle's nearest pinned particles along ties, by Dijkstra's algorithm from all of them."""
    near: dict[int, list[tuple[int, float]]] = {}
    for (a, b), length in zip(pairs.tolist(), lengths.tolist(), strict=True):
        near.setdefault(a, []).append((b, length))
        near.setdefault(b, []).append((a, length))
    tethers: dict[int, dict[int, float]] = {}
    queue = [(0.0, pin, number) for number, pin in enumerate(pinned.tolist())]
    heapq.heapify(queue)
    while queue:
        far, particle, pin = heapq.heappop(queue)
        own = tethers.setdefault(particle, {})
        if pin in own or len(own) == MOST_TETHERS:
            continue
        own[pin] = far
        for other, length in near.get(particle, ()):
            if pin not in tethers.get(other, {}):
                heapq.heappush(queue, (far + length, other, pin))
    rows = [(p, pin, far) for p, own in sorted(tethers.items()) for pin, far in sorted(own.items())]
    ids, places, far_away = zip(*rows, strict=True) if rows else ((), (), ())
    return np.array(ids, np.uint64), np.array(places, np.uint32), np.array(far_away, np.float32)


def _ids(argument: str, given: Any) -> NDArray[np.uint64]:
    array = arguments.whole_numbers(argument, given, "ids: whole numbers >= 0")
    return np.ascontiguousarray(array, np.uint64)
