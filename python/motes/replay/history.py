"""A run's loads, independent of its balancer: particle positions and machine speeds, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from .._values.space import are_bricks
from ..errors import LogError
from .bricks import Cloud, Tree
from .density import Density
from .flows import matched, migrants, spread

if TYPE_CHECKING:
    from pandas import DataFrame

    from .tables import Tables

__all__ = ["History", "Moment", "Particles", "Recorded"]

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
    ways: Floats | None = None
    """How far particles moved along the axis in this frame: equally likely ways of each recorded domain,
    (calculators, ways), NaN in empty domains; None: unknown."""
    agreement: float = 1.0
    """Ratio of recorded migrants to those that ways predict for the recorded cuts."""
    before: Cuts | Tree | None = None
    """The recorded run's cuts in the previous frame."""
    earlier: Particles | None = None
    """Particles at the end of the previous frame; None: there was none."""
    flows: Floats | None = None
    """The recorded run's migrants from each calculator to each other one; None: unknown."""
    guessed: float = 0.0
    """The number of migrants that ways predict for the recorded cuts."""
    fixed_s: Floats | float = 0.0
    """Time of other work of each calculator, which no cut changes, (calculators,)."""
    renewed: bool = False
    """Whether `density` acts in this frame, divided by its cuts, not what the frame before has left: tasks of
    another code, whose work changes and which move between frames."""


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
    """The history of a recorded run.

    Attributes:
        acted: seconds of actions, (frames, calculators) like the next two.
        held: particles at the frame's end.
        created: particles born.
    """

    def __init__(self, run: Tables) -> None:
        """Read the tables of a run.

        Args:
            run: the recorded run.

        Raises:
            LogError: if tables are missing or incomplete.
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
        self.acted, self.held, self.created = map(self._sum, ("t_compute_s", "n", "created"))
        self._balance_rows = {} if run.balance.empty else dict(iter(run.balance.groupby("frame")))
        self.decentralised = run.balancer.startswith("Diffusive")
        self.plans = not run.balancer.startswith("Static") and "manager=False" not in run.balancer
        self._moments: dict[tuple[int, int], Moment] = {}

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
        ways = [name for name in density.columns if name.startswith("way_q")]
        if run.axis(system) in ("x", "y", "z") and density[ways].notna().any(axis=None):
            grid["ways"] = _held(np.stack([self._grid(density, name) for name in ways], axis=-1))
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
        columns = [[name for name in density.columns if name.startswith(f"{axis}_q")] for axis in axes[1:]]
        if any(len(names) != 17 or density[names].isna().all(axis=None) for names in columns):
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
        moment = self._moment(k, system)
        if moment.ways is None:
            return moment
        around = range(max(k - _SMOOTH, 0), min(k + _SMOOTH + 1, len(self.frames)))
        known = [self._moment(j, system) for j in around]
        guess = sum(one.guessed for one in known)
        sent = sum(float(np.nansum(self._grids[system]["sent"][j])) for j in around)
        few = 1e-4 * sum(one.density.total for one in known)
        ratio = min(max(sent / guess, 0.5), 2.0) if guess > few else 1.0
        return replace(moment, agreement=ratio)

    def _moment(self, k: int, system: int) -> Moment:
        """Return one system in one frame, but without `agreement`."""
        if (k, system) not in self._moments:
            self._moments[k, system] = self._made(k, system)
        return self._moments[k, system]

    def _made(self, k: int, system: int) -> Moment:
        grid = self._grids[system]
        n, created = grid["n"][k], grid["created"][k]
        density: Particles
        births: Particles
        cuts: Cuts | Tree
        density, births, cuts = self._places(grid, k) if "axes" not in grid else self._bricks(grid, k)
        crossing, changing = None, 0.0
        if "ways" in grid:
            pass  # tell more than counts beside cuts
        elif "axes" in grid or np.nansum(grid["killed"]) < _DEATHS * np.nansum(grid["sent"]):
            least = density.exchange(grid["n_start"][k] + created, n)[0].sum()
            changing = max(float(grid["sent"][k].sum() - least), 0.0)
        else:
            crossing, changing = (float(values[k]) for values in self._crossing(system))
        moment = Moment(
            density=density,
            births=births,
            killed=int(np.nansum(grid["killed"][k])),
            cuts=cuts,
            speeds=grid["speeds"][k],
            overhead_s=grid["overhead"][k],
            changing=changing,
            crossing=crossing,
            ways=grid["ways"][k] if "ways" in grid else None,
            before=self._cuts(grid, max(k - 1, 0)),
            earlier=self._moment(k - 1, system).density if k and "ways" in grid else None,
        )
        sent, received = (np.nan_to_num(grid[name][k]) for name in ("sent", "received"))
        if moment.ways is None:
            return replace(moment, flows=spread(sent, received))
        assert isinstance(moment.cuts, np.ndarray) and isinstance(moment.before, np.ndarray)
        guess = migrants(moment, moment.before, moment.cuts)
        return replace(moment, flows=matched(guess, sent, received), guessed=float(guess.sum()))

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
        crossing: tuple[Floats, Floats] = grid["crossing"]
        return crossing

    @staticmethod
    def _cuts(grid: dict[str, Any], k: int) -> Cuts | Tree:
        """Return the cuts of a frame."""
        if "axes" in grid:
            return Tree.of_boxes(grid["low"][k].astype(np.float64), grid["high"][k].astype(np.float64))
        cuts: Cuts = grid["domain_hi"][k, :-1].astype(np.float32)
        return cuts

    @staticmethod
    def _places(grid: dict[str, Any], k: int) -> tuple[Density, Density, Cuts]:
        """Return the particles and births along an axis, and the cuts."""
        x = grid["x"][k]
        cuts = Recorded._cuts(grid, k)
        assert isinstance(cuts, np.ndarray)
        births = Density.of_quantiles(_somewhere(_born(grid, k, cuts), cuts), grid["created"][k])
        return Density.of_quantiles(x, grid["n"][k]), births, cuts

    @staticmethod
    def _bricks(grid: dict[str, Any], k: int) -> tuple[Cloud, Cloud, Tree]:
        """Return the particles and births in bricks, and the cuts."""
        x, axes = grid["x"][k], grid["axes"]
        low, high = grid["low"][k].astype(np.float64), grid["high"][k].astype(np.float64)
        cuts = Recorded._cuts(grid, k)
        assert isinstance(cuts, Tree)
        somewhere = np.where(np.isnan(x), _middle(low, high)[:, axes, None], x)
        births = Cloud.of_quantiles(somewhere, grid["created"][k], axes)
        return Cloud.of_quantiles(x, grid["n"][k], axes), births, cuts

    # --- what the recorded run did

    def flows(self, k: int) -> list[Floats]:
        """Return the migrants of each system in the k-th frame, (calculators, calculators) each.

        Args:
            k: index of the frame in the history.
        """
        by_system = [self._moment(k, system).flows for system in range(len(self.systems))]
        return [flows for flows in by_system if flows is not None]

    def cut_requests(self, k: int) -> list[tuple[Floats, list[int], bool, bool]]:
        """Return who looked for new cuts at the end of the k-th frame.

        Args:
            k: index of the frame in the history.

        Returns:
            For each system whose cuts a balancer asked for: its particles, the calculators that looked,
            whether they made histograms, and whether domains are bricks.
        """
        rows = self._balance_rows.get(self.frames[k])
        requests: list[tuple[Floats, list[int], bool, bool]] = []
        for name, of_system in () if rows is None else rows.groupby("system"):
            if name not in self.systems:
                continue
            grid = self._grids[self.systems.index(str(name))]
            shares = bool(of_system["given"].isna().all() and of_system["ordered"].isna().all())
            if shares:  # the rows do not tell, but who looks for cuts nearly always finds other ones
                other = (of_system["cut_before"] != of_system["cut_after"]).any()
                donors = list(range(len(self.ranks))) if other else []
            else:
                moved = of_system[of_system["given"].notna() & (of_system["ordered"] != 0)]
                right = (moved["ordered"] > 0).to_numpy()
                givers = np.where(right, moved["left_rank"], moved["right_rank"])
                donors = [self.ranks.index(int(rank)) for rank in givers if int(rank) in self.ranks]
            if donors:
                requests.append((np.nan_to_num(grid["n"][k]), donors, shares, "axes" in grid))
        return requests

    def slowness(self) -> Floats:
        """Return each machine's seconds per particle, averaged over frames and systems."""
        each = [(1 / grid["speeds"]).mean(axis=0) for grid in self._grids]
        return np.asarray(np.mean(each, axis=0), np.float64)

    def _sum(self, name: str) -> Floats:
        return np.asarray(np.nan_to_num(np.sum([grid[name] for grid in self._grids], axis=0)), np.float64)


def _held(ways: Floats) -> Floats:
    """Replace ways of frames in which no domain has any by those of the frame before or, at first, after."""
    known = np.flatnonzero(~np.isnan(ways).all(axis=(1, 2)))
    rows = np.searchsorted(known, np.arange(len(ways)), side="right") - 1
    held: Floats = ways[known[np.maximum(rows, 0)]]
    return held


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
