"""A run's loads, independent of its balancer: particle positions and machine speeds, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from .._values.space import are_bricks
from ..errors import LogError
from .bricks import Cloud, Tree
from .density import Density

if TYPE_CHECKING:
    from collections.abc import Mapping

    from pandas import DataFrame

__all__ = ["FrameCosts", "History", "Moment", "Particles", "Recorded", "Tables"]

Floats = npt.NDArray[np.float64]
Cuts = npt.NDArray[np.float32]
_DEATHS = 0.5
"""Ratio of deaths to sent particles from which crossings can no longer be derived from counts beside a cut,
because deaths and births change these counts more."""
_SMOOTH = 8
"""Crossings are averaged over this many frames on each side, because few particles cross a cut per frame."""
LEAST_PARTICLES, LEAST_SECONDS = 1000, 5e-5  # as in the engine: smaller samples do not measure speed


class Particles(Protocol):
    """Distribution of particles: a `Density` along one axis, or a `Cloud` in bricks; cuts match it."""

    @property
    def total(self) -> float:
        """Total number of particles."""

    def domains(self, cuts: Any) -> npt.NDArray[np.int64]:
        """Return the integer number of particles in each domain."""

    def overlaps(self, ours: Any, theirs: Any) -> tuple[Any, Any, Floats]:
        """Return the overlaps of two sets of domains: our domain, their domain, particles in both."""

    def around(self, cuts: Any) -> float:
        """Return the number of particles near cuts."""

    def divided(self, costs: Floats, shares: Floats, cuts: Any) -> Any:
        """Return the cuts that give each domain its share."""

    def exchange(self, before: npt.ArrayLike, after: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Return the minimum that each calculator sends and receives."""

    def none(self) -> Particles:
        """Return an empty distribution of the same kind."""


@dataclass(frozen=True)
class Moment:
    """One system in one frame; only `cuts`, which are the recorded run's, depend on the balancer."""

    density: Particles
    """Particles at the frame's end."""
    births: Particles
    killed: int
    cuts: Cuts | Tree
    speeds: Floats
    """Particles per second of each calculator, (calculators,)."""
    overhead_s: Floats
    """Fixed extra time of a calculator with any particles, (calculators,)."""
    changing: float = 0.0
    """Particles exchanged beyond the minimum because they swapped sides of a cut; if `crossing` is known,
    this frame's deviation from the smoothed rate."""
    crossing: float | None = None
    """Particles that cross a cut per frame, per particle near it (`around`); None: unknown."""


@dataclass(frozen=True)
class FrameCosts:
    """Costs of a frame in addition to the actions."""

    other_s: float
    """Seconds that depend on neither particles nor migrants."""
    bytes_each: float
    """Bytes per migrant."""
    migrant_s: float = 0.0
    """Seconds per migrant of the calculator that sends and receives most."""
    picture_s: Floats | None = None
    """Seconds per particle of each calculator's part of the picture; None: no picture."""


class Tables(Protocol):
    """Data needed from a recorded run; a `Run` has all of them."""

    @property
    def name(self) -> str:
        """The run's name, for error messages."""

    @property
    def calculators(self) -> list[int]:
        """The calculators' ranks in the order of their domains."""

    @property
    def systems(self) -> list[str]:
        """The particle systems' names."""

    def axis(self, system: str) -> str:
        """Return the axes along which a system's domains are cut.

        Args:
            system: the system's name.

        Returns:
            "x", "xz", ...; "hilbert", "morton"; "id" if particles are distributed by id.
        """

    @property
    def speeds(self) -> Mapping[int, float]:
        """Factors by which ranks were slowed down on purpose; empty if none were."""

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
    """Input of a replay.

    Attributes:
        ranks: the calculators, in the order of their domains.
        systems: names of the systems.
        axes: axes along which each system's domains are cut.
        frames: frame numbers.
    """

    ranks: list[int]
    systems: list[str]
    axes: list[str]
    frames: list[int]

    def moment(self, k: int, system: int) -> Moment:
        """Return one system in one frame.

        Args:
            k: index of the frame in the history.
            system: index of the system.
        """


class Recorded:
    """The history of a recorded run."""

    def __init__(self, run: Tables, migrant_s: float | None = None) -> None:
        """Read the tables of a run.

        Args:
            run: the recorded run.
            migrant_s: seconds per migrant of the busiest calculator, if the network is known; None: fitted to
                the run's frames.

        Raises:
            LogError: if tables are missing or incomplete.
        """
        run = getattr(run, "unchanged", run)  # a replay ends where other calculators go on
        self.ranks = run.calculators
        self.systems = run.systems
        self._factors = np.array([run.speeds.get(rank, 1.0) for rank in self.ranks])
        if not len(run.density) or not len(run.load):
            raise LogError(f"{run.name}: a replay needs the log's load.jsonl and density.jsonl")
        frames = set(run.frames["frame"]) & set(run.density["frame"])
        self.frames = sorted(int(frame) for frame in frames)
        self.axes = [run.axis(system) for system in self.systems]
        self._grids = [self._of(run, system) for system in self.systems]
        self._whole(run.name)
        frame_rows = run.frames.set_index("frame").loc[self.frames]
        self._t_frame = frame_rows["t_frame_s"].to_numpy(np.float64)
        total = frame_rows["exchanged"].sum()
        self._bytes_each = float(frame_rows["exchanged_bytes"].sum() / total) if total else 0.0
        self._picture = self._pictures(run)
        self._migrant_s = self._fit_migrants(run) if migrant_s is None else migrant_s

    def _of(self, run: Tables, system: str) -> dict[str, Any]:
        load = run.load[run.load["system"] == system]
        density = run.density[run.density["system"] == system]
        grid: dict[str, Any] = {
            name: self._grid(load, name)
            for name in (
                "n_start",
                "created",
                "killed",
                "sent",
                "received",
                "speed",
                "t_compute_s",
                "domain_hi",
            )
        }
        grid["n"] = self._grid(density, "n")
        names = [name for name in density.columns if name.startswith("x_q")]
        grid["x"] = np.stack([self._grid(density, name) for name in names], axis=-1)
        if are_bricks(axes := run.axis(system)):
            self._add_bricks(run.name, axes, load, density, grid)
        processed = grid["n_start"] + grid["created"]
        grid["speeds"] = self._speeds(grid, processed)
        # A sample too small to measure the machine's speed still gives this frame's time. Extra time is
        # treated as a fixed overhead; less time as a higher speed.
        grid["speeds"] = np.where(processed > 0, np.fmax(grid["speeds"], grid["speed"]), grid["speeds"])
        longer = grid["t_compute_s"] - processed / grid["speeds"]
        grid["overhead"] = np.where((processed > 0) & (longer > 0), longer, 0.0)
        return grid

    def _add_bricks(
        self, run: str, axes: str, load: DataFrame, density: DataFrame, grid: dict[str, Any]
    ) -> None:
        """Add quantiles along all cut axes, and the ends of all domains."""
        numbers = grid["axes"] = ["xyz".index(axis) for axis in axes]
        told = [name for name in density.columns if name[1:3] == "_q" and name[0] in axes[1:]]
        if len(told) != 17 * (len(axes) - 1) or density[told].isna().all(axis=None):
            raise LogError(f"{run}: a replay of bricks needs density.jsonl to have quantiles along {axes}")
        along = [[self._grid(density, f"{axis}_q{q:02d}") for q in range(17)] for axis in axes[1:]]
        grid["x"] = np.stack([grid["x"], *(np.stack(one, axis=-1) for one in along)], axis=-2)
        low, high = np.full((2, *grid["n"].shape, 3), np.inf)
        low *= -1
        for axis, number in zip(axes, numbers, strict=True):
            start = "domain_" if axis == axes[0] else f"domain_{axis}_"
            for ends, name, beyond in ((low, "lo", -np.inf), (high, "hi", np.inf)):
                logged = self._grid(load, start + name)
                ends[..., number] = np.where(np.isnan(logged), beyond, logged)
        grid["low"], grid["high"] = low.astype(np.float32), high.astype(np.float32)

    def _grid(self, table: DataFrame, column: str) -> Floats:
        grid = table.pivot(index="frame", columns="rank", values=column)
        return grid.reindex(index=self.frames, columns=self.ranks).to_numpy(np.float64)

    def _whole(self, name: str) -> None:
        """Drop frames at the end with missing rows, which a killed run leaves behind."""
        missing = []
        for grid in self._grids:
            needed = sum(grid[key] for key in ("n", "n_start", "created", "killed", "sent", "t_compute_s"))
            gaps = np.isnan(needed).any(axis=1)
            if "axes" not in grid:  # bricks can extend to infinity on any side
                gaps |= np.isnan(grid["domain_hi"][:, :-1]).any(axis=1)
            missing.append(gaps)
        broken = np.logical_or.reduce(missing)
        whole = int(np.argmax(broken)) if broken.any() else len(self.frames)
        if whole == 0:
            raise LogError(f"{name}: no frame has rows for all calculators {self.ranks}")
        self.frames = self.frames[:whole]

    def _speeds(self, grid: dict[str, Any], processed: Floats) -> Floats:
        """Return speeds per frame; gaps get the last or first sample, else the other machines' mean."""
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
        """Return one system in one frame, from the log.

        Args:
            k: index of the frame in the history.
            system: index of the system.
        """
        grid = self._grids[system]
        n, created = grid["n"][k], grid["created"][k]
        density: Particles
        births: Particles
        cuts: Cuts | Tree
        density, births, cuts = self._places(grid, k) if "axes" not in grid else self._bricks(grid, k)
        crossing = None
        if "axes" in grid or np.nansum(grid["killed"]) < _DEATHS * np.nansum(grid["sent"]):
            least = density.exchange(grid["n_start"][k] + created, n)[0].sum()
            changing = max(float(grid["sent"][k].sum() - least), 0.0)
        else:
            crossing, changing = (float(values[k]) for values in self._crossing(system))
        return Moment(
            density=density,
            births=births,
            killed=int(np.nansum(grid["killed"][k])),
            cuts=cuts,
            speeds=grid["speeds"][k],
            overhead_s=grid["overhead"][k],
            changing=changing,
            crossing=crossing,
        )

    def _crossing(self, system: int) -> tuple[Floats, Floats]:
        """Return crossings per particle near a cut, and each frame's deviation from this rate in particles.

        The rate is smoothed over frames. Particles reassigned by moving cuts are excluded. Births and deaths
        do not matter, because only particles that cross a cut are sent.
        """
        grid = self._grids[system]
        if "crossing" not in grid:
            crossed, near = np.zeros((2, len(self.frames)))
            before: Cuts | None = None
            for k in range(len(self.frames)):
                density, _, cuts = self._places(grid, k)
                source, to, n = density.overlaps(cuts if before is None else before, cuts)
                crossed[k] = float(np.nansum(grid["sent"][k])) - float(n[source != to].sum())
                near[k], before = density.around(cuts), cuts
            window = np.ones(min(2 * _SMOOTH + 1, len(crossed)))
            steady, around = (np.convolve(one, window, "same") for one in (crossed, near))
            rate = np.where(around > 0, np.maximum(steady, 0.0) / np.where(around > 0, around, 1.0), 0.0)
            grid["crossing"] = rate, crossed - rate * near
        found: tuple[Floats, Floats] = grid["crossing"]
        return found

    @staticmethod
    def _places(grid: dict[str, Any], k: int) -> tuple[Density, Density, Cuts]:
        """Return the particles and births along an axis, and the cuts."""
        x = grid["x"][k]
        cuts = grid["domain_hi"][k, :-1].astype(np.float32)
        births = Density.of_quantiles(_somewhere(_born(grid, k, cuts), cuts), grid["created"][k])
        return Density.of_quantiles(x, grid["n"][k]), births, cuts

    @staticmethod
    def _bricks(grid: dict[str, Any], k: int) -> tuple[Cloud, Cloud, Tree]:
        """Return the particles and births in bricks, and the cuts."""
        x, axes = grid["x"][k], grid["axes"]
        low, high = grid["low"][k].astype(np.float64), grid["high"][k].astype(np.float64)
        somewhere = np.where(np.isnan(x), _middle(low, high)[:, axes, None], x)
        births = Cloud.of_quantiles(somewhere, grid["created"][k], axes)
        return Cloud.of_quantiles(x, grid["n"][k], axes), births, Tree.of_boxes(low, high)

    def costs(self, k: int) -> FrameCosts:
        """Return a frame's costs in addition to the actions.

        Args:
            k: index of the frame in the history.
        """
        n = np.maximum(sum(grid["n"][k] for grid in self._grids), 1.0)
        rest = self._t_frame[k] - self._slowest()[k] - self._migrant_s * self._migrants()[k]
        return FrameCosts(
            other_s=max(float(rest), 0.0),
            bytes_each=self._bytes_each,
            migrant_s=self._migrant_s,
            picture_s=self._picture[k] / n,
        )

    def _slowest(self) -> Floats:
        """Return the seconds of the slowest calculator's actions and picture, per frame."""
        spent = sum(grid["t_compute_s"][: len(self.frames)] for grid in self._grids)
        slowest: Floats = np.asarray(spent + self._picture).max(axis=1)
        return slowest

    def _migrants(self) -> Floats:
        """Return the migrants sent plus received by the busiest calculator, per frame."""
        moved = sum((grid["sent"] + grid["received"])[: len(self.frames)] for grid in self._grids)
        busiest: Floats = np.nan_to_num(np.asarray(moved)).max(axis=1)
        return busiest

    def _pictures(self, run: Tables) -> Floats:
        """Return each calculator's seconds of work on pictures, per frame, without waits."""
        times = getattr(run, "times", None)
        if times is None or not len(times):
            return np.zeros((len(self.frames), len(self.ranks)))
        return np.nan_to_num(self._grid(times, "picture_s"))

    def _fit_migrants(self, run: Tables) -> float:
        """Return the seconds per migrant: the slope of a line fitted to the frames.

        The slope is the median over pairs of frames (Theil-Sen), which makes it robust against interrupted
        frames. If all frames exchanged about the same number, the slope is unknown and taken as 0.
        """
        chosen = np.unique(np.linspace(0, len(self.frames) - 1, 300).astype(int))
        x, y = self._migrants()[chosen], (self._t_frame - self._slowest())[chosen]
        pairs = np.triu_indices(len(x), 1)
        apart = np.abs(x[pairs[0]] - x[pairs[1]])
        far = apart > max(0.25 * float(x.max(initial=0.0)), 1.0)
        if far.sum() < 8:
            return 0.0
        slopes = (y[pairs[0]] - y[pairs[1]])[far] / (x[pairs[0]] - x[pairs[1]])[far]
        return max(float(np.median(slopes)), 0.0)


def _born(grid: dict[str, Any], k: int, cuts: Cuts) -> Floats:
    """Return quantiles of each calculator's births, inside its domain.

    The log does not contain them. They are taken from the last frame in which more than half of a
    calculator's particles were newborn, because sources seldom move far. Without such a frame, the quantiles
    of all its particles are used.
    """
    if "fresh" not in grid:
        rows = np.arange(len(grid["n"]))[:, None]
        fresh = (grid["created"] > 0.5 * grid["n"]) & ~np.isnan(grid["x"]).any(axis=-1)
        grid["fresh"] = np.maximum.accumulate(np.where(fresh, rows, -1), axis=0)
    last = grid["fresh"][k]
    x: Floats = np.where(last[:, None] < 0, grid["x"][k], grid["x"][last, np.arange(len(last))])
    low, high = np.concatenate([[-np.inf], cuts]), np.concatenate([cuts, [np.inf]])
    return np.clip(x, low[:, None], np.nextafter(high, -np.inf)[:, None])


def _somewhere(x: Floats, cuts: Cuts) -> Floats:
    """Replace missing quantiles of births by a position inside the domain."""
    low = np.concatenate([[-np.inf], cuts])
    high = np.concatenate([cuts, [np.inf]])
    return np.where(np.isnan(x), _middle(low, high)[:, None], x)


def _middle(low: Floats, high: Floats) -> Floats:
    """Return a position inside each domain."""
    with np.errstate(invalid="ignore"):
        middle = np.where(np.isinf(low), high - 1, np.where(np.isinf(high), low + 1, (low + high) / 2))
    return np.where(np.isfinite(middle), middle, 0.0)
