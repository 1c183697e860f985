"""A run's loads without its balancer: where particles were, how fast the machines were, frame by frame."""

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
"""Where so many die for each particle that is sent, what is missing on one side of a cut says little about
who crossed it: it died there, and others were born elsewhere."""
_SMOOTH = 8
"""Frames on each side over which crossings are averaged: few particles cross a cut in one frame."""
LEAST_PARTICLES, LEAST_SECONDS = 1000, 5e-5  # as in the engine: smaller samples say nothing about a machine


class Particles(Protocol):
    """Where particles are: a `Density` along one axis, or a `Cloud` in bricks; cuts are of that kind."""

    @property
    def total(self) -> float:
        """All particles."""

    def domains(self, cuts: Any) -> npt.NDArray[np.int64]:
        """Whole particles in each domain."""

    def overlaps(self, ours: Any, theirs: Any) -> tuple[Any, Any, Floats]:
        """Particles by two sets of cuts at once: our domain, their domain, particles in both."""

    def around(self, cuts: Any) -> float:
        """Particles near a cut."""

    def divided(self, costs: Floats, shares: Floats, cuts: Any) -> Any:
        """Return the cuts that give each domain its share."""

    def exchange(self, before: npt.ArrayLike, after: npt.ArrayLike) -> tuple[Floats, Floats]:
        """The least that each calculator sends and receives."""

    def none(self) -> Particles:
        """Return the same kind without particles."""


@dataclass(frozen=True)
class Moment:
    """One system in one frame; only `cuts` depend on who balanced: they were the run's."""

    density: Particles
    """At the frame's end."""
    births: Particles
    killed: int
    cuts: Cuts | Tree
    speeds: Floats
    """Particles per second of each calculator, (calculators,)."""
    overhead_s: Floats
    """Fixed extra time of a calculator with any particles, (calculators,)."""
    changing: float = 0.0
    """Particles that swapped sides of a cut: those exchanged beyond the least necessary; where `crossing` is
    known, those by which this frame differs from its neighbours."""
    crossing: float | None = None
    """Particles that cross a cut in a frame, for each particle near it (`around`); None: not known."""


@dataclass(frozen=True)
class FrameCosts:
    """What a frame cost in addition to the actions."""

    other_s: float
    """What no calculator's particles and no migrants cost."""
    bytes_each: float
    """Of a migrant."""
    migrant_s: float = 0.0
    """Seconds of the frame per migrant of the calculator that sends and receives most."""
    picture_s: Floats | None = None
    """Seconds per particle of each calculator's part of the picture; None: no picture."""


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

    def axis(self, system: str) -> str:
        """Return the axes that a system's domains cut.

        Args:
            system: its name.

        Returns:
            "x", "xz", ...; "hilbert", "morton"; "id" where ids decide.
        """

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
    """What a replay needs to know.

    Attributes:
        ranks: the calculators, in the order of their domains.
        systems: names.
        axes: what each system's domains cut.
        frames: numbers.
    """

    ranks: list[int]
    systems: list[str]
    axes: list[str]
    frames: list[int]

    def moment(self, k: int, system: int) -> Moment:
        """Return one system in one frame.

        Args:
            k: the place of the frame in the history.
            system: the system's place.
        """


class Recorded:
    """The history of a recorded run."""

    def __init__(self, run: Tables, migrant_s: float | None = None) -> None:
        """Take the tables of a run.

        Args:
            run: whose.
            migrant_s: seconds per migrant of the busiest calculator, where the network is known; None: as
                the run's frames that exchanged more took longer.

        Raises:
            LogError: if they do not suffice.
        """
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
        # A sample too small for the machine's speed still says how long this frame took. What it took longer
        # would be as much for more particles; what it took less would be in proportion.
        grid["speeds"] = np.where(processed > 0, np.fmax(grid["speeds"], grid["speed"]), grid["speeds"])
        longer = grid["t_compute_s"] - processed / grid["speeds"]
        grid["overhead"] = np.where((processed > 0) & (longer > 0), longer, 0.0)
        return grid

    def _add_bricks(
        self, run: str, axes: str, load: DataFrame, density: DataFrame, grid: dict[str, Any]
    ) -> None:
        """Add quantiles along all axes that are cut, and the ends of all domains."""
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
        """Leave out the frames at the end whose rows are not all there: the run was killed."""
        missing = []
        for grid in self._grids:
            needed = sum(grid[key] for key in ("n", "n_start", "created", "killed", "sent", "t_compute_s"))
            gaps = np.isnan(needed).any(axis=1)
            if "axes" not in grid:  # bricks may reach to infinity on any side
                gaps |= np.isnan(grid["domain_hi"][:, :-1]).any(axis=1)
            missing.append(gaps)
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
        """Return one system in one frame, from the log.

        Args:
            k: the place of the frame in the history.
            system: the system's place.
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
        """Return how many particles crossed per particle near a cut, and by how many more in each frame.

        The first is smoothed over frames. What moving cuts gave to other calculators is left out. Births and
        deaths do not count: only who crosses a cut is sent.
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
        """Particles and births along an axis, and the cuts."""
        x = grid["x"][k]
        cuts = grid["domain_hi"][k, :-1].astype(np.float32)
        births = Density.of_quantiles(_somewhere(_born(grid, k, cuts), cuts), grid["created"][k])
        return Density.of_quantiles(x, grid["n"][k]), births, cuts

    @staticmethod
    def _bricks(grid: dict[str, Any], k: int) -> tuple[Cloud, Cloud, Tree]:
        """The same in bricks."""
        x, axes = grid["x"][k], grid["axes"]
        low, high = grid["low"][k].astype(np.float64), grid["high"][k].astype(np.float64)
        somewhere = np.where(np.isnan(x), _middle(low, high)[:, axes, None], x)
        births = Cloud.of_quantiles(somewhere, grid["created"][k], axes)
        return Cloud.of_quantiles(x, grid["n"][k], axes), births, Tree.of_boxes(low, high)

    def costs(self, k: int) -> FrameCosts:
        """Return what a frame cost besides the actions.

        Args:
            k: the place of the frame in the history.
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
        """Return the seconds that the slowest calculator's particles took, per frame."""
        spent = sum(grid["t_compute_s"][: len(self.frames)] for grid in self._grids)
        slowest: Floats = np.asarray(spent + self._picture).max(axis=1)
        return slowest

    def _migrants(self) -> Floats:
        """Return how many migrants the busiest calculator sent and received, per frame."""
        moved = sum((grid["sent"] + grid["received"])[: len(self.frames)] for grid in self._grids)
        busiest: Floats = np.nan_to_num(np.asarray(moved)).max(axis=1)
        return busiest

    def _pictures(self, run: Tables) -> Floats:
        """Return each calculator's seconds of work for pictures, per frame; waits are not in it."""
        times = getattr(run, "times", None)
        if times is None or not len(times):
            return np.zeros((len(self.frames), len(self.ranks)))
        return np.nan_to_num(self._grid(times, "picture_s"))

    def _fit_migrants(self, run: Tables) -> float:
        """Return by how many seconds a migrant makes a frame longer: the slope of a line through the frames.

        The slope between frames of like cost is found in pairs (Theil and Sen), so that interrupted frames do
        not count; where all frames exchanged about the same, it is unknown, and migrants cost nothing.
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
    """Return quantiles of where each calculator's particles are born, inside its domain.

    The log does not tell; but in a frame in which most of a calculator's particles were born, they are still
    near. Sources seldom move far; where there was no such frame, all of its particles stand for the newborn.
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
    """Give calculators without particles a place for their births: inside the domain, near other ones."""
    low = np.concatenate([[-np.inf], cuts])
    high = np.concatenate([cuts, [np.inf]])
    return np.where(np.isnan(x), _middle(low, high)[:, None], x)


def _middle(low: Floats, high: Floats) -> Floats:
    """Return a place inside each domain."""
    with np.errstate(invalid="ignore"):
        middle = np.where(np.isinf(low), high - 1, np.where(np.isinf(high), low + 1, (low + high) / 2))
    return np.where(np.isfinite(middle), middle, 0.0)
