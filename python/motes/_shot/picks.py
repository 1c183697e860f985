"""Which picture of a sheet each particle shows."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._picture.sprites import Sprite
from ..expressions import minimum
from ..expressions._conditions import components, program_of
from ..expressions._expression import node_of

__all__ = ["columns_of_pick", "tile_numbers"]

Array = NDArray[Any]
_STREAM = 4 << 4  # sprite_tile in cpp/particles/streams.h, before the bits of the draw
_MOTE, _S = 0x6D6F7465, 0x73


def tile_numbers(
    sprite: Sprite, column: Callable[[str], Array], seed: int, system: int, time: float
) -> NDArray[np.int32]:
    """Return the number of each particle's picture: of two that are blended, the nearer one.

    A pick that asks whether particles are inside a shape gives the first picture.
    """
    count: int = sprite.__dict__["_tiles"][2]
    ids = column("id")
    if count == 1:
        return np.zeros(len(ids), np.int32)
    if sprite.pick is None or (isinstance(sprite.pick, str) and sprite.pick == "random"):
        part = (_bits(seed, system, ids) >> 8).astype(np.float32) * np.float32(2**-24)
        return np.asarray(np.minimum(np.floor(part * np.float32(count)), count - 1), np.int32)
    if isinstance(sprite.pick, str):
        life = column("age") / column("lifetime")
        numbers = np.asarray(minimum(life, 1)) * np.float32(count - 1)
    else:
        numbers = _evaluated(node_of(sprite.pick), column, time)
    numbers = np.where(np.abs(numbers) <= 1e9, numbers, 0)
    return np.asarray(np.rint(np.mod(numbers, count)) % count, np.int32)


def columns_of_pick(sprite: Sprite) -> set[str]:
    """Return the columns that a sprite's `pick` reads."""
    return set() if sprite.pick is None or isinstance(sprite.pick, str) else _names(node_of(sprite.pick))


def _evaluated(node: Any, column: Callable[[str], Array], time: float) -> Array:
    """Compute an expression of columns."""
    names = sorted(_names(node))
    columns = {name: np.atleast_2d(column(name).astype(np.float32).T) for name in names}
    places, planes = {}, [column("id").astype(np.float32)]
    for name, rows in columns.items():
        places[name] = (len(planes), len(rows))
        planes += [np.ascontiguousarray(row) for row in rows]
    shown = {"time": ("constant", time), "id": ("column", 0)}
    steps = tuple(shown.get(step[0], step) for step in components(node, places)[0])
    if any(step[0] == "inside" for step in steps):
        return np.zeros(len(planes[0]), np.float32)
    numbers: Array = _core.evaluate(program_of(steps, []), planes)
    return numbers


def _names(node: Any) -> set[str]:
    if not isinstance(node, tuple):
        return set()
    if len(node) == 2 and node[0] == "column" and isinstance(node[1], str):
        return set() if node[1] == "id" else {node[1]}
    return set().union(*map(_names, node))


# --- the draw of "random", as cpp/particles/philox.h and cpp/particles/random.h make it


def _bits(seed: int, system: int, ids: Array) -> NDArray[np.uint32]:
    """Return the first word of each id's draw."""
    mixed = _philox((system, _MOTE, _S, 0), (seed & 0xFFFFFFFF, seed >> 32))
    halves = [_philox((0, _STREAM, _MOTE, half), (mixed[0], mixed[1])) for half in (0, 1)]
    k = [np.uint32(word) for half in halves for word in half]
    low, upper = (ids & 0xFFFFFFFF).astype(np.uint32), (ids >> np.uint64(32)).astype(np.uint32)
    a, b = low + upper * np.uint32(0x9E3779B1), low + upper * np.uint32(0x85EBCA6A)
    a = a ^ a >> 16 ^ k[0] ^ k[0] >> 16
    a *= np.uint32(0x7FEB352D)
    a = (a ^ a >> 15) + k[1]
    a *= np.uint32(0x846CA68B)
    a ^= a >> 16
    b = b ^ b >> 15 ^ k[2] ^ k[2] >> 15
    b *= np.uint32(0xD168AAAD)
    b = (b ^ b >> 15) + k[3]
    b *= np.uint32(0xAF723597)
    b ^= b >> 15
    word = (a ^ k[4]) * np.uint32(0x9E3779B1)
    return np.asarray((word ^ word >> 16) + b)


def _philox(counter: tuple[int, int, int, int], key: tuple[int, int]) -> tuple[int, int, int, int]:
    low, high = key
    for _ in range(10):
        first, second = 0xD2511F53 * counter[0], 0xCD9E8D57 * counter[2]
        counter = (
            second >> 32 ^ counter[1] ^ low,
            second & 0xFFFFFFFF,
            first >> 32 ^ counter[3] ^ high,
            first & 0xFFFFFFFF,
        )
        low, high = (low + 0x9E3779B9) & 0xFFFFFFFF, (high + 0xBB67AE85) & 0xFFFFFFFF
    return counter
