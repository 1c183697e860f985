"""Fabrics: particles that are born tied to each other, as cloths and ropes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import arguments
from .errors import ArgumentError
from .ties import BEND, MOST_TETHERS, SHEAR, STRETCH, Tethers, Ties
from .values import says_near_names

if TYPE_CHECKING:
    from .particles import Particles
    from .world import World

__all__ = ["Fabrics"]

MOST_AT_ONCE = 1_000_000  # distances to pinned particles, in memory


class Fabrics(ABC):
    """Births of tied particles. `System` is one."""

    world: World
    _index: int

    @abstractmethod
    def emit(
        self,
        particles: Particles | None = None,
        /,
        *,
        position: ArrayLike | None = None,
        **columns: ArrayLike,
    ) -> None:
        """Emit the particles of these arrays."""

    @says_near_names
    def cloth(
        self,
        rows: int,
        columns: int,
        origin: ArrayLike,
        along: ArrayLike,
        across: ArrayLike,
        pinned: Iterable[tuple[int, int]] = (),
    ) -> Ties:
        """Emit rows x columns particles, tied to a cloth; ids in the order of rows.

        Args:
            rows: at least 2.
            columns: at least 2.
            origin: where row 0, column 0 is, m.
            along: from there to the last row, m.
            across: from there to the last column, m.
            pinned: places (row, column) of particles that only the script moves.

        Returns:
            The ties, for `tie`.
        """
        return _cloth(self, rows, columns, origin, along, across, pinned)

    @says_near_names
    def rope(self, start: ArrayLike, end: ArrayLike, count: int, pinned: Iterable[int] = ()) -> Ties:
        """Emit particles in a straight line, tied to a rope.

        Args:
            start: where the first one is, m.
            end: where the last one is, m.
            count: at least 2.
            pinned: places, 0..count - 1, of particles that only the script moves.

        Returns:
            The ties, for `tie`.
        """
        return _rope(self, start, end, count, pinned)


@np.errstate(over="ignore", invalid="ignore")  # emit refuses what is not finite
def _cloth(
    system: Fabrics, rows: Any, columns: Any, origin: Any, along: Any, across: Any, pinned: Any
) -> Ties:
    rows = arguments.integer("rows", rows, low=2, high=10_000)
    columns = arguments.integer("columns", columns, low=2, high=10_000)
    corner = np.array(arguments.triple("origin", origin))
    sides = np.array([arguments.triple("along", along), arguments.triple("across", across)])
    if not np.linalg.norm(np.cross(*sides)) > 0:
        raise ArgumentError(
            "across", across, "a vector that is not parallel to `along`; both above 0 in length"
        )
    grid = np.stack(np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"), -1).reshape(-1, 2)
    rest = (grid / (rows - 1, columns - 1)) @ sides
    held = [_place_in_cloth(place, rows, columns) for place in _listed("pinned", pinned)]
    number = np.arange(rows * columns).reshape(rows, columns)
    steps = [(0, 1, STRETCH), (1, 0, STRETCH), (1, 1, SHEAR), (1, -1, SHEAR), (0, 2, BEND), (2, 0, BEND)]
    pairs, kinds = [], []
    for down, right, kind in steps:
        here = number[: rows - down, max(0, -right) : columns - max(0, right)]
        there = number[down:, max(0, right) : columns + min(0, right)]
        pairs.append(np.stack([here.ravel(), there.ravel()], -1))
        kinds.append(np.full(here.size, kind, np.uint8))
    return _born(system, "cloth", corner, rest, np.concatenate(pairs), np.concatenate(kinds), held)


@np.errstate(over="ignore", invalid="ignore")
def _rope(system: Fabrics, start: Any, end: Any, count: Any, pinned: Any) -> Ties:
    count = arguments.integer("count", count, low=2, high=10_000_000)
    begin = np.array(arguments.triple("start", start))
    way = np.array(arguments.triple("end", end)) - begin
    if not np.linalg.norm(way) > 0:
        raise ArgumentError("end", end, "another point than `start`")
    rest = np.linspace(0, 1, count)[:, None] * way
    number = np.arange(count)
    pairs = [np.stack([number[:-step], number[step:]], -1) for step in (1, 2)]
    kinds = [np.full(len(one), kind, np.uint8) for one, kind in zip(pairs, (STRETCH, BEND), strict=True)]
    held = [
        arguments.integer("pinned", place, low=-count, high=count - 1) % count
        for place in _listed("pinned", pinned)
    ]
    return _born(system, "rope", begin, rest, np.concatenate(pairs), np.concatenate(kinds), held)


def _listed(argument: str, places: Any) -> list[Any]:
    return arguments.listed(argument, places, "a list of places")


def _place_in_cloth(place: Any, rows: int, columns: int) -> int:
    allowed = f"places (row, column), 0..{rows - 1} and 0..{columns - 1}, or negative from the end"
    pair = arguments.listed("pinned", place, allowed)
    if len(pair) != 2:
        raise ArgumentError("pinned", place, allowed)
    row = arguments.integer("pinned", pair[0], low=-rows, high=rows - 1) % rows
    return row * columns + arguments.integer("pinned", pair[1], low=-columns, high=columns - 1) % columns


def _born(
    system: Fabrics,
    call: str,
    origin: NDArray[np.float64],
    rest: NDArray[np.float64],
    pairs: NDArray[np.int64],
    kinds: NDArray[np.uint8],
    held: list[int],
) -> Ties:
    """Emit particles at `origin + rest` and return their ties, which are as long as they are at rest."""
    first = _next_id(system, call, len(rest))
    lengths = np.linalg.norm(rest[pairs[:, 0]] - rest[pairs[:, 1]], axis=1).astype(np.float32)
    pins = np.unique(np.array(held, np.int64))
    made = object.__new__(Ties)
    made._keep(
        (pairs + first).astype(np.uint64),
        lengths,
        kinds,
        (pins + first).astype(np.uint64),
        _tethers_at_rest(first, rest, pins),
    )
    system.emit(position=rest + origin)  # last: what was refused has left no births
    return made


def _next_id(system: Fabrics, call: str, count: int) -> int:
    """Return the first of the ids that the next `count` particles get."""
    engine = system.world._begin(call)
    try:
        first, room = engine.next_birth(system._index)
    finally:
        system.world._usage.end()
    if room < count:
        raise ArgumentError(
            call, count, f"at most {room} particles: the system's capacity has room for no more"
        )
    return int(first)


def _tethers_at_rest(first: int, rest: NDArray[np.float64], pins: NDArray[np.int64]) -> Tethers:
    """Tether each particle to the pinned ones that are nearest to it at rest."""
    count = min(len(pins), MOST_TETHERS)
    nearest = np.empty((len(rest), count), np.uint32)
    lengths = np.empty((len(rest), count), np.float32)
    step = max(1, MOST_AT_ONCE // max(1, len(pins)))
    for begin in range(0, len(rest) if count else 0, step):
        part = slice(begin, begin + step)
        far = np.linalg.norm(rest[part, None] - rest[pins], axis=2)
        nearest[part] = order = np.argsort(far, axis=1, kind="stable")[:, :count]
        lengths[part] = np.take_along_axis(far, order, axis=1)
    ids = np.repeat(np.arange(first, first + len(rest), dtype=np.uint64), count)
    return ids, nearest.ravel(), lengths.ravel()
