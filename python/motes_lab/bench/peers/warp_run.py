"""NVIDIA Warp on the processor, where it uses one core: one kernel, with its own random numbers."""

from typing import Any

import numpy as np
import warp as wp

from .scene import DT, FRICTION, GUST, LIFE, RESTITUTION, Columns

__all__ = ["Run"]

_DT, _LIFE = wp.constant(DT), wp.constant(LIFE)
_BACK, _SLIDE = wp.constant(-RESTITUTION), wp.constant(1 - FRICTION)
_GX, _GY, _GZ = (wp.constant(g * DT) for g in GUST)


@wp.kernel
def _step(
    x: wp.array(dtype=float),
    y: wp.array(dtype=float),
    z: wp.array(dtype=float),
    u: wp.array(dtype=float),
    v: wp.array(dtype=float),
    w: wp.array(dtype=float),
    age: wp.array(dtype=float),
    killed: wp.array(dtype=int),
    seed: int,
) -> None:
    i = wp.tid()
    state = wp.rand_init(seed, i)
    p = u[i] + wp.randf(state, -_GX, _GX)
    q = v[i] + wp.randf(state, -_GY, _GY)
    r = w[i] + wp.randf(state, -_GZ, _GZ)
    if y[i] + q * _DT < 0.0:
        p = p * _SLIDE
        q = q * _BACK
        r = r * _SLIDE
    if age[i] >= _LIFE:
        wp.atomic_add(killed, 0, 1)
    u[i] = p
    v[i] = q
    w[i] = r
    x[i] = x[i] + p * _DT
    y[i] = y[i] + q * _DT
    z[i] = z[i] + r * _DT
    age[i] = age[i] + _DT


class Run:
    """Particles as one array for each column."""

    def __init__(self, start: Columns, threads: int) -> None:
        """Keep the particles."""
        self._all = [wp.array(column, dtype=float, device="cpu") for column in start]
        self._killed = wp.zeros(1, dtype=int, device="cpu")

    def step(self, number: np.uint32) -> None:
        """Take one step."""
        inputs: list[Any] = [*self._all, self._killed, int(number)]
        wp.launch(_step, dim=self._all[0].shape[0], inputs=inputs, device="cpu")

    def columns(self) -> Columns:
        """Copy the particles."""
        return np.array([column.numpy() for column in self._all])
