"""Numba: all four actions fused by hand into one loop, with a cheap 32-bit hash for random numbers.

This is what a user can write who needs only this list. Each particle's three numbers are hashes of its index
and the step (xor-shift and multiply, three rounds). The compiler vectorises the loop and may reorder sums
(`fastmath`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from numba import float32, int32, prange, uint32

from .scene import DT, FRICTION, GUST, LIFE, RESTITUTION, Columns

__all__ = ["Run"]

_DT, _LIFE = np.float32(DT), np.float32(LIFE)
_BACK, _SLIDE = np.float32(-RESTITUTION), np.float32(1 - FRICTION)
_UNIT = np.float32(2**-24)
_GX, _GY, _GZ = (np.float32(g * DT) for g in GUST)


@numba.njit(fastmath=True)
def _hash(h: Any) -> Any:
    h = uint32(uint32(h ^ (h >> uint32(16))) * uint32(0x21F0AAAD))
    h = uint32(uint32(h ^ (h >> uint32(15))) * uint32(0x735A2D97))
    return uint32(h ^ (h >> uint32(15)))


@numba.njit(fastmath=True)
def _within(bits: Any, most: Any) -> Any:
    """Return a number from 32 random bits, uniform in -most..most."""
    return (float32(int32(bits >> uint32(8))) * _UNIT * float32(2) - float32(1)) * most


def _loop(x: Any, y: Any, z: Any, u: Any, v: Any, w: Any, age: Any, key: Any) -> Any:
    killed = 0
    for i in prange(x.size):
        first = _hash(uint32(uint32(i) * uint32(0x9E3779B1) ^ key))
        second = _hash(uint32(first ^ key))
        third = _hash(uint32(second ^ key))
        p = u[i] + _within(first, _GX)
        q = v[i] + _within(second, _GY)
        r = w[i] + _within(third, _GZ)
        hit = y[i] + q * _DT < float32(0)
        p = p * _SLIDE if hit else p
        q = q * _BACK if hit else q
        r = r * _SLIDE if hit else r
        killed += age[i] >= _LIFE
        u[i] = p
        v[i] = q
        w[i] = r
        x[i] += p * _DT
        y[i] += q * _DT
        z[i] += r * _DT
        age[i] += _DT
    return killed


class Run:
    """Particles as columns."""

    def __init__(self, start: Columns, threads: int) -> None:
        """Keep the particles."""
        self._all = [column.copy() for column in start]
        self._loop: Callable[..., int] = numba.njit(fastmath=True, parallel=threads > 1)(_loop)
        if threads > 1:
            numba.set_num_threads(threads)
        self.killed = 0

    def step(self, number: np.uint32) -> None:
        """Take one step."""
        key = np.uint32((int(number) + 1) * 0x85EBCA6B & 0xFFFFFFFF)
        self.killed += self._loop(*self._all, key)

    def columns(self) -> Columns:
        """Copy the particles."""
        return np.array(self._all)
