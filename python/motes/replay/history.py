"""A run's loads without its balancer: where particles were, how fast the machines were, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from ..errors import LogError
from .density import Density, exchange

if TYPE_CHECKING:
    from collections.abc import Mapping

    from pandas import DataFrame

__all__ = ["FrameCosts", "History", "Moment", "Recorded", "Tables"]

Floats = npt.NDArray[np.float64]
Cuts = npt.NDArray[np.float32]
LEAST_PARTICLES, LEAST_SECONDS = 1000, 5e-5  # as in the engine: smaller samples say nothing about a machine


@dataclass(frozen=True)
class Moment:
    """One system in one frame; only `cuts` depend on who balanced: they were the run's."""

    density: Density
    """At the frame's end."""
    births: Density
    killed: int
    cuts: Cuts
    speeds: Floats
    """Particles per second of each calculator, (calculators,)."""
    overhead_s: Floats
    """Fixed extra time of a calculator with any particles, (calculators,)."""
    changing: float = 0.0
    """Particles that swapped sides of a cut: those exchanged beyond the least necessary."""


@dataclass(frozen=True)
class FrameCosts:
    """What a frame cost in addition to the actions."""

    other_s: float
    bytes_each: float


class Tables(Protocol):
    """What is read from a recorded run; a `Run` has all of it."""

    @property
    def name(self) -> str:
        """The run's name in errors."""

    @property
    def calculators(self) -> list[int]:
        """The calculators' ranks in the order of their domains."""

    @property
    def systems(self) -> list[str]:
        """The particle systems' names."""

    @property
    def speeds(self) -> Mapping[int, float]:
        """Factors by which ranks were slowed down on purpose; empty if none was."""

    @property
    def hosts(self) -> Mapping[int, str]:
        """Each rank's host."""

    @property
    def frames(self) -> DataFrame:
        """The log's table `frames`."""

    @property
    def load(self) -> DataFrame:
        """The log's table `load`."""

    @property
    def density(self) -> DataFrame:
        """The log's table `density`."""


class History(Protocol):
    """What a replay needs to know."""

    ranks: list[int]
    systems: list[str]
    frames: list[int]

    def moment(self, k: int, system: int) -> Moment:
        """Return one system in the k-th frame."""


class Recorded:
    """The history of a recorded run."""

    def __init__(self, run: Tables) -> None:
        """Take the tables of a run; LogError if they do not suffice."""
        self.ranks = run.calculators
        self.systems = run.systems
        self._factors = np.array([run.speeds.get(rank, 1.0) for rank in self.ranks])
        if not len(run.density) or not len(run.load):
            raise LogError(f"{run.name}: a replay needs the log's load.jsonl and density.jsonl")
        frames = set(run.frames["frame"]) & set(run.density["frame"])
        self.frames = sorted(int(frame) for frame in frames)
        for system in self.systems:
            _refuse_bricks(run, system)
        self._grids = [self._of(run, system) for system in self.systems]
        self._whole(run.name)
        frame_rows = run.frames.set_index("frame").loc[self.frames]
        self._t_frame = frame_rows["t_frame_s"].to_numpy(np.float64)
        total = frame_rows["exchanged"].sum()
        self._bytes_each = float(frame_rows["exchanged_bytes"].sum() / total) if total else 0.0

    def _of(self, run: Tables, system: str) -> dict[str, Any]:
        load = run.load[run.load["system"] == system]
        density = run.density[run.density["system"] == system]
        grid: dict[str, Any] = {
            name: self._grid(load, name)
            for name in ("n_start", "created", "killed", "sent", "speed", "t_compute_s", "domain_hi")
        }
        grid["n"] = self._grid(density, "n")
        names = [name for name in density.columns if name.startswith("x_q")]
        grid["x"] = np.stack([self._grid(density, name) for name in names], axis=-1)
        processed = grid["n_start"] + grid["created"]
        grid["speeds"] = self._speeds(grid, processed)
        # A sample too small for the machine's speed still says how long this frame took. What it took longer
        # would be as much for more particles; what it took less would be in proportion.
        grid["speeds"] = np.where(processed > 0, np.fmax(grid["speeds"], grid["speed"]), grid["speeds"])
        longer = grid["t_compute_s"] - processed / grid["speeds"]
        grid["overhead"] = np.where((processed > 0) & (longer > 0), longer, 0.0)
        return grid

    def _grid(self, table: DataFrame, column: str) -> Floats:
        grid = table.pivot(index="frame", columns="rank", values=column)
        return grid.reindex(index=self.frames, columns=self.ranks).to_numpy(np.float64)

    def _whole(self, name: str) -> None:
        """Leave out the frames at the end whose rows are not all there: the run was killed."""
        missing = []
        for grid in self._grids:
            needed = sum(grid[key] for key in ("n", "n_start", "created", "killed", "sent", "t_compute_s"))
            missing.append(np.isnan(needed).any(axis=1) | np.isnan(grid["domain_hi"][:, :-1]).any(axis=1))
        broken = np.logical_or.reduce(missing)
        whole = int(np.argmax(broken)) if broken.any() else len(self.frames)
        if whole == 0:
            raise LogError(f"{name}: no frame has the rows of all calculators {self.ranks}")
        self.frames = self.frames[:whole]

    def _speeds(self, grid: dict[str, Any], processed: Floats) -> Floats:
        """Samples of each frame; for gaps: the last or first sample, or the mean of other machines."""
        speed = grid["speed"]
        good = (speed > 0) & (processed >= LEAST_PARTICLES) & (grid["t_compute_s"] >= LEAST_SECONDS)
        if not good.any():
            good = speed > 0
        filled = np.where(good, speed, np.nan)
        rows = np.arange(len(filled))[:, None]
        known = ~np.isnan(filled)
        last = np.maximum.accumulate(np.where(known, rows, -1), axis=0)
        first = np.argmax(known, axis=0)
        filled = np.take_along_axis(filled, np.where(last < 0, first, last), axis=0)
        per_factor = filled / self._factors
        seen = ~np.isnan(per_factor)
        sums = np.where(seen, per_factor, 0.0).sum(axis=1, keepdims=True)
        mean = sums / np.maximum(seen.sum(axis=1, keepdims=True), 1)
        mean[mean == 0] = 1.0
        return np.where(seen, filled, mean * self._factors)

    def moment(self, k: int, system: int) -> Moment:
        """Return one system in the k-th frame."""
        grid = self._grids[system]
        x, n, created = grid["x"][k], grid["n"][k], grid["created"][k]
        cuts = grid["domain_hi"][k, :-1].astype(np.float32)
        return Moment(
            density=Density.of_quantiles(x, n),
            births=Density.of_quantiles(_somewhere(x, cuts), created),
            killed=int(np.nansum(grid["killed"][k])),
            cuts=cuts,
            speeds=grid["speeds"][k],
            overhead_s=grid["overhead"][k],
            changing=max(
                float(grid["sent"][k].sum() - exchange(grid["n_start"][k] + created, n)[0].sum()), 0
            ),
        )

    def costs(self, k: int) -> FrameCosts:
        """Return the other costs of the k-th frame."""
        slowest = float(sum(grid["t_compute_s"][k] for grid in self._grids).max())
        return FrameCosts(
            other_s=max(float(self._t_frame[k]) - slowest, 0.0),
            bytes_each=self._bytes_each,
        )


def _somewhere(x: Floats, cuts: Cuts) -> Floats:
    """Give calculators without particles a place for their births: inside the domain, near other ones."""
    low = np.concatenate([[-np.inf], cuts])
    high = np.concatenate([cuts, [np.inf]])
    middle = np.where(np.isinf(low), high - 1, np.where(np.isinf(high), low + 1, (low + high) / 2))
    middle = np.where(np.isfinite(middle), middle, 0.0)
    return np.where(np.isnan(x), middle[:, None], x)


def _refuse_bricks(run: Tables, system: str) -> None:
    """The log says how particles lie along one axis, which is not enough to cut them along two."""
    load = run.load[run.load["system"] == system]
    others = [name for name in map(str, load) if name.startswith(("domain_y_", "domain_z_"))]
    if load[others].notna().any(axis=None):
        raise LogError(
            f"{run.name}: a replay needs slabs or particles dealt out by id; domains of {system!r} are bricks"
        )
