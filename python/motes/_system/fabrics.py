"""Fabrics: particles that are born as cloths and ropes, with their ties."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._values import arguments
from .._values.ties import BEND, MOST_TETHERS, SHEAR, STRETCH, Tethers, Ties, ties_of
from ..errors import ArgumentError
from .births import Births

__all__ = ["cloth", "rope"]

MOST_AT_ONCE = 1_000_000  # distances to pinned particles that are held in memory at once


@np.errstate(over="ignore", invalid="ignore")  # emit refuses non-finite positions
def cloth(births: Births, rows: Any, columns: Any, origin: Any, along: Any, across: Any, pinned: Any) -> Ties:
    """Record the births of `System.cloth`, and return its ties."""
    rows = arguments.integer("rows", rows, low=2, high=10_000)
    columns = arguments.integer("columns", columns, low=2, high=10_000)
    corner = np.array(arguments.triple("origin", origin))
    sides = np.array([arguments.triple("along", along), arguments.triple("across", across)])
    if not np.linalg.norm(np.cross(*sides)) > 0:
        raise ArgumentError(
            "across", across, "a vector that is not parallel to `along`; both must be longer than 0"
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
    return _born(births, "cloth", corner, rest, np.concatenate(pairs), np.concatenate(kinds), held)


@np.errstate(over="ignore", invalid="ignore")
def rope(births: Births, start: Any, end: Any, count: Any, pinned: Any) -> Ties:
    """Record the births of `System.rope`, and return its ties."""
    count = arguments.integer("count", count, low=2, high=10_000_000)
    begin = np.array(arguments.triple("start", start))
    way = np.array(arguments.triple("end", end)) - begin
    if not np.linalg.norm(way) > 0:
        raise ArgumentError("end", end, "a point other than `start`")
    rest = np.linspace(0, 1, count)[:, None] * way
    number = np.arange(count)
    pairs = [np.stack([number[:-step], number[step:]], -1) for step in (1, 2)]
    kinds = [np.full(len(one), kind, np.uint8) for one, kind in zip(pairs, (STRETCH, BEND), strict=True)]
    held = [
        arguments.integer("pinned", place, low=-count, high=count - 1) % count
        for place in _listed("pinned", pinned)
    ]
    return _born(births, "rope", begin, rest, np.concatenate(pairs), np.concatenate(kinds), held)


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
    births: Births,
    call: str,
    origin: NDArray[np.float64],
    rest: NDArray[np.float64],
    pairs: NDArray[np.int64],
    kinds: NDArray[np.uint8],
    held: list[int],
) -> Ties:
    """Emit particles at `origin + rest` and return their ties; lengths are distances at rest."""
    first = births.next_id(call, len(rest))
    lengths = np.linalg.norm(rest[pairs[:, 0]] - rest[pairs[:, 1]], axis=1).astype(np.float32)
    pins = np.unique(np.array(held, np.int64))
    ties = ties_of(
        (pairs + first).astype(np.uint64),
        lengths,
        kinds,
        (pins + first).astype(np.uint64),
        _tethers_at_rest(first, rest, pins),
    )
    births.emit(None, rest + origin, {})  # last: if an argument is refused above, nothing has been emitted
    return ties


def _tethers_at_rest(first: int, rest: NDArray[np.float64], pins: NDArray[np.int64]) -> Tethers:
    """Tether each particle to the pinned particles nearest to it at rest."""
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
