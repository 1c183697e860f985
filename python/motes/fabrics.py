"""Fabrics: particles that are born tied to each other, as cloths and ropes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import arguments
from .errors import ArgumentError
from .ties import BEND, MOST_TETHERS, SHEAR, STRETCH, Ties
from .values import says_near_names

if TYPE_CHECKING:
    from .world import World

__all__ = ["Fabrics"]


class Fabrics(ABC):
    """Births of tied particles. `System` is one."""

    world: World
    _index: int

    @abstractmethod
    def emit(self, *, position: ArrayLike, **columns: ArrayLike) -> None:
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

        Row 0, column 0 is at `origin`, the last row at `origin + along`, the last column at
        `origin + across`. `pinned`: places (row, column) of particles that only the script moves. Return the
        ties, for `tie`.
        """
        return _cloth(self, rows, columns, origin, along, across, pinned)

    @says_near_names
    def rope(self, start: ArrayLike, end: ArrayLike, count: int, pinned: Iterable[int] = ()) -> Ties:
        """Emit `count` particles from `start` to `end`, tied to a rope. `pinned`: places, 0..count - 1.

        Return the ties, for `tie`.
        """
        return _rope(self, start, end, count, pinned)


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
    first = _emit(system, "cloth", rest + corner)
    number = np.arange(rows * columns).reshape(rows, columns)
    steps = [(0, 1, STRETCH), (1, 0, STRETCH), (1, 1, SHEAR), (1, -1, SHEAR), (0, 2, BEND), (2, 0, BEND)]
    pairs, kinds = [], []
    for down, right, kind in steps:
        here = number[: rows - down, max(0, -right) : columns - max(0, right)]
        there = number[down:, max(0, right) : columns + min(0, right)]
        pairs.append(np.stack([here.ravel(), there.ravel()], -1))
        kinds.append(np.full(here.size, kind, np.uint8))
    held = [_place_in_cloth(place, rows, columns) for place in _listed("pinned", pinned)]
    return _tied(first, rest, np.concatenate(pairs), np.concatenate(kinds), held)


def _rope(system: Fabrics, start: Any, end: Any, count: Any, pinned: Any) -> Ties:
    count = arguments.integer("count", count, low=2, high=10_000_000)
    begin = np.array(arguments.triple("start", start))
    way = np.array(arguments.triple("end", end)) - begin
    if not np.linalg.norm(way) > 0:
        raise ArgumentError("end", end, "another point than `start`")
    rest = np.linspace(0, 1, count)[:, None] * way
    first = _emit(system, "rope", rest + begin)
    number = np.arange(count)
    pairs = [np.stack([number[:-step], number[step:]], -1) for step in (1, 2)]
    kinds = [np.full(len(one), kind, np.uint8) for one, kind in zip(pairs, (STRETCH, BEND), strict=True)]
    held = [
        arguments.integer("pinned", place, low=-count, high=count - 1) % count
        for place in _listed("pinned", pinned)
    ]
    return _tied(first, rest, np.concatenate(pairs), np.concatenate(kinds), held)


def _listed(argument: str, places: Any) -> list[Any]:
    return arguments.listed(argument, places, "a list of places")


def _place_in_cloth(place: Any, rows: int, columns: int) -> int:
    allowed = f"places (row, column), 0..{rows - 1} and 0..{columns - 1}, or negative from the end"
    pair = arguments.listed("pinned", place, allowed)
    if len(pair) != 2:
        raise ArgumentError("pinned", place, allowed)
    row = arguments.integer("pinned", pair[0], low=-rows, high=rows - 1) % rows
    return row * columns + arguments.integer("pinned", pair[1], low=-columns, high=columns - 1) % columns


def _emit(system: Fabrics, call: str, position: NDArray[np.float64]) -> int:
    """Emit particles and return the id of the first one."""
    engine = system.world._begin(call)
    try:
        first, room = engine.next_birth(system._index)
    finally:
        system.world._usage.end()
    if room < len(position):
        raise ArgumentError(
            call, len(position), f"at most {room} particles: the system's capacity has room for no more"
        )
    system.emit(position=position)
    return int(first)


def _tied(
    first: int, rest: NDArray[np.float64], pairs: NDArray[np.int64], kinds: NDArray[np.uint8], held: list[int]
) -> Ties:
    """Make ties of particles whose ids follow each other, as long as they are at rest."""
    lengths = np.linalg.norm(rest[pairs[:, 0]] - rest[pairs[:, 1]], axis=1).astype(np.float32)
    held = sorted(set(held))
    tethers: list[tuple[int, int, float]] = []
    if held:
        far = np.linalg.norm(rest[:, None] - rest[None, held], axis=2)
        nearest = np.argsort(far, axis=1, kind="stable")[:, :MOST_TETHERS]
        tethers = [(first + i, int(pin), float(far[i, pin])) for i in range(len(rest)) for pin in nearest[i]]
    made = object.__new__(Ties)
    ids = (pairs + first).astype(np.uint64)
    made._keep(ids, lengths, kinds, np.array(held, np.uint64) + np.uint64(first), tethers)
    return made
