"""Taichi: one kernel over fields, with its own random numbers."""

from typing import Any

import numpy as np
import taichi as ti

from .scene import DT, FRICTION, GUST, LIFE, RESTITUTION, Columns

__all__ = ["Run"]


class Run:
    """Particles as one field for each column."""

    def __init__(self, start: Columns, threads: int) -> None:
        """Keep the particles."""
        ti.init(arch=ti.cpu, cpu_max_num_threads=threads, log_level=ti.ERROR, fast_math=True, random_seed=1)
        self._all = [ti.field(ti.f32, shape=start.shape[1]) for _ in start]
        for field, column in zip(self._all, start, strict=True):
            field.from_numpy(column)
        self._kernel = _kernel(*self._all)

    def step(self, number: np.uint32) -> None:
        """Take one step."""
        self._kernel()
        ti.sync()

    def columns(self) -> Columns:
        """Copy the particles."""
        return np.array([field.to_numpy() for field in self._all])


def _kernel(x: Any, y: Any, z: Any, u: Any, v: Any, w: Any, age: Any) -> Any:
    gx, gy, gz = (g * DT for g in GUST)
    back, slide = -RESTITUTION, 1 - FRICTION

    @ti.kernel
    def step() -> ti.i32:
        killed = 0
        for i in x:
            p = u[i] + (ti.random() * 2 - 1) * gx
            q = v[i] + (ti.random() * 2 - 1) * gy
            r = w[i] + (ti.random() * 2 - 1) * gz
            if y[i] + q * DT < 0:
                p *= slide
                q *= back
                r *= slide
            if age[i] >= LIFE:
                killed += 1
            u[i], v[i], w[i] = p, q, r
            x[i] += p * DT
            y[i] += q * DT
            z[i] += r * DT
            age[i] += DT
        return killed

    return step
