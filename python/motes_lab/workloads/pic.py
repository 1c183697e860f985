"""The particle-in-cell kernel of the Parallel Research Kernels: drifting charges with known final positions.

E. Georganas, R. F. Van der Wijngaart, T. G. Mattson: Design and implementation of a parallel research kernel
for assessing dynamic load-balancing capabilities, IPDPS 2016. Fixed charges are at the corners of square
cells, positive in even columns and negative in odd ones. The four charges of its cell act on each particle,
whose own charge makes it move 2 k + 1 cells to the right and m cells up in each step.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from motes.errors import ArgumentError
from motes.expressions import column, dot, floor, length

from .._engine import arguments
from .base import Counts, Workload, laid

if TYPE_CHECKING:
    from motes import Particles, System

__all__ = ["DISTRIBUTIONS", "Pic"]

Distribution: TypeAlias = Literal["geometric", "sinusoidal", "linear", "patch"]
DISTRIBUTIONS: tuple[Distribution, ...] = ("geometric", "sinusoidal", "linear", "patch")
PLANE = np.array((1.0, 1.0, 0.0))
NEAR = 1e-3
"""Tolerance of final positions, m, for cells of 1 m; positions are float32."""


class Pic(Workload):
    """The kernel on a periodic square of cells, each 1 m wide, with steps of 1 s.

    A particle's z stores its charge, which the motion in the plane does not change, and `up` the force on it.
    The particles of a column are spread evenly over its rows, whereas the original kernel draws each cell's
    number at random.
    """

    def __init__(
        self,
        distribution: Literal["geometric", "sinusoidal", "linear", "patch"] = "geometric",
        ratio: float = 0.99,
        k: int = 1,
        m: int = 2,
        cells: int = 1000,
        particles: int = 100_000,
        *,
        slope: float = 1.0,
        offset: float = 3.0,
        patch: tuple[int, int, int, int] | None = None,
        frames: int = 60,
    ) -> None:
        """Set the parameters of the kernel.

        Args:
            distribution: distribution of the particles over the columns of cells. "geometric": ratio^column;
                "sinusoidal": cos^2 over half a period; "linear": offset - slope * column / cells; "patch":
                uniform in a rectangle.
            ratio: parameter of "geometric", above 0.
            k: particles move 2 k + 1 cells to the right in each step.
            m: particles move m cells up in each step.
            cells: number of cells along each side, even.
            particles: total number of particles.
            slope: parameter of "linear".
            offset: parameter of "linear", at least the slope.
            patch: left, right, bottom and top cell of "patch", inclusive; None: the first fifth of the
                columns and the second tenth of the rows, as in the kernel's own tests.
            frames: number of frames that the arena plays.
        """
        super().__init__(frames=frames, cells=cells, particles=particles)
        if self.cells % 2:
            raise ArgumentError("cells", cells, "an even number: charges alternate around the ring of cells")
        self.distribution = arguments.choice("distribution", distribution, DISTRIBUTIONS)
        self.ratio = arguments.number("ratio", ratio, low=1e-6, high=1e6)
        self.k = arguments.integer("k", k, low=0, high=self.cells)
        self.m = arguments.integer("m", m, low=-self.cells, high=self.cells)
        self.slope = arguments.number("slope", slope, low=0)
        self.offset = arguments.number("offset", offset, low=self.slope)
        self.patch = self._checked(patch)
        self.name = f"pic_{self.distribution}"

    def _checked(self, patch: Any) -> tuple[int, int, int, int]:
        fifth, tenth = self.cells // 5, self.cells // 10
        left, right, bottom, top = (0, fifth, tenth, 2 * tenth) if patch is None else map(int, patch)
        if not (0 <= left <= right < self.cells and 0 <= bottom <= top < self.cells):
            raise ArgumentError(
                "patch", patch, f"left <= right and bottom <= top, all in 0..{self.cells - 1}"
            )
        return left, right, bottom, top

    @cached_property
    def _columns(self) -> Counts:
        """Number of particles born in each column of cells, int64 (cells,)."""
        x = np.arange(self.cells)
        if self.distribution == "geometric":
            return laid(self.ratio ** x.astype(np.float64), self.particles)
        if self.distribution == "sinusoidal":
            return laid(np.cos(np.pi * x / (self.cells - 1)) ** 2, self.particles)
        if self.distribution == "linear":
            return laid(self.offset - self.slope * x / self.cells, self.particles)
        return laid((x >= self.patch[0]) & (x <= self.patch[1]), self.particles)

    @cached_property
    def _starts(self) -> tuple[Counts, Counts]:
        """Initial column and row of each particle, in the order of ids."""
        count = self._columns
        columns = np.repeat(np.arange(self.cells), count)
        number = np.arange(self.particles) - np.repeat(np.cumsum(count) - count, count)
        first, last = (self.patch[2], self.patch[3]) if self.distribution == "patch" else (0, self.cells - 1)
        rows = first + (2 * number + 1) * (last + 1 - first) // (2 * count[columns])
        return columns, rows

    def born(self, frame: int) -> Counts | None:
        """Return the particles born in a frame per column, (2 sheets, cells); None: no births.

        Args:
            frame: frame index, from 0.
        """
        if frame:
            return None
        return np.stack([self._columns, np.zeros_like(self._columns)])

    def shifts(self, frame: int) -> tuple[int, int]:
        """Return by how many columns each sheet moves in a frame.

        Args:
            frame: frame index, from 0.
        """
        return 2 * self.k + 1, 2 * self.k + 1

    @property
    def world(self) -> dict[str, Any]:
        """Keyword arguments for `World`: a periodic square."""
        ends = (0.0, float(self.cells))
        return {**super().world, "periodic": {"x": ends, "y": ends}}

    @property
    def charge(self) -> float:
        """Charge that moves a particle in an even column one cell from rest, in units of a fixed charge."""
        r2, cosine = 0.5, 0.5**0.5  # the same for all four corners
        return float(r2 / (2 * cosine))

    def step(self, system: System, frame: int) -> None:
        """Record a frame's births and actions: all births in frame 0, and one step of the motion.

        Args:
            system: the system that plays the workload.
            frame: frame index, from 0.
        """
        if frame == 0:
            columns, rows = self._starts
            sign = np.where(columns % 2 == 0, 1, -1)
            places = (columns + 0.5, rows + 0.5, sign * ((2 * self.k + 1) * self.charge))
            upwards = np.broadcast_to((0.0, float(self.m), 0.0), (len(columns), 3))
            system.emit(position=np.stack(places, axis=1), velocity=upwards)
        system.set(up=(0.0, 0.0, 0.0))
        for corner in product((0, 1), repeat=2):
            system.set(up=column("up") + _drawn(corner))
        # x += v dt + a dt^2 / 2, v += a dt
        half = column("velocity") + 0.5 * column("up")
        system.set(velocity=half)
        system.move()
        system.set(velocity=half)

    def verify(self, particles: Particles, steps: int) -> bool:
        """Return whether each particle is at its expected position.

        Args:
            particles: all particles of the system, as returned by `System.gather`.
            steps: number of frames that have run.
        """
        columns, rows = self._starts
        if len(particles) != len(columns):
            return False
        wanted = np.stack([columns + steps * (2 * self.k + 1), rows + steps * self.m], axis=1) + 0.5
        off = particles.position[:, :2] - wanted % self.cells
        off -= self.cells * np.rint(off / self.cells)
        return bool((np.abs(off) <= NEAR).all())


def _drawn(corner: Sequence[int]) -> Any:
    """Return the force of one corner of its cell on each particle, q Q r / |r|^3; y points up."""
    at = column("position")
    r = at % 1.0 * PLANE - np.array((*corner, 0.0))
    sign = 1 - 2 * ((floor(at.x) + corner[0]) % 2)
    return at.z * sign * r / (dot(r, r) * length(r))
