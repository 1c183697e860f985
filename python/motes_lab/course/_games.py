"""Games: a hidden load on hidden machines, what a policy sees of it, and the points for its seconds.

The course's own solution and many simple policies play each game, too: points say where a submission stands
between them. A game is fair if no simple policy comes close to the solution.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from motes import _core
from motes.balance import Balancer, LoadTable, Orders, Targets
from motes.replay.history import Floats

from ..arena import Machine, Score, Track
from ..workloads import Workload
from ..workloads.base import Counts, laid
from ._simple import simple
from ._texts import own

__all__ = ["Game", "Hidden", "Result", "Seen", "machine"]

PARTICLE_S = 1e-7
"""Seconds that one particle takes at speed 1."""
PATIENCE = (1, 3, 8, 24)
"""Frames within which a move must pay, for each policy with full knowledge."""
LEAD = 1.1
"""Smallest ratio of the best simple policy's time to that of the course's own solution, in a fair game."""
OWN = 0.8
"""Fewest points of the course's own solution, as a fraction of all."""

Table = dict[str, Any]


class Hidden(Workload):
    """Particles spread evenly, and a crowd that is born in some frame and then moves about."""

    name = "hidden"

    def __init__(
        self, places: Sequence[float], *, part: float, slow: Floats, width: float = 0.1, born: int = 0
    ):
        """Make a load of as many frames as places.

        Args:
            places: the crowd's middle in each frame, as fractions of the row.
            part: fraction of all particles that are in the crowd.
            slow: fraction of its speed that each machine has in each frame, (frames, calculators).
            width: half the crowd's width, as a fraction of the row.
            born: the frame in which the crowd is born.
        """
        super().__init__(frames=len(places), cells=256, particles=200_000)
        self._at = [round(place * self.cells) for place in places]
        self._part, self._slow, self._width, self._born = part, slow, width, born

    def born(self, frame: int) -> Counts | None:
        """Return the particles born in a frame, before they move, (2 sheets, cells)."""
        crowd = round(self._part * self.particles)
        sheets = np.zeros((2, self.cells), np.int64)
        if frame == 0 and crowd < self.particles:
            sheets[0] = laid(np.ones(self.cells), self.particles - crowd)
        if frame == self._born and crowd:
            off = (np.arange(self.cells) - self._at[frame]) / (self._width * self.cells)
            sheets[1] = laid(np.maximum(1 - off * off, 0) ** 2, crowd)
        return sheets if sheets.any() else None

    def shifts(self, frame: int) -> tuple[int, int]:
        """Return the cells by which each sheet moves in a frame."""
        return 0, self._at[frame] - self._at[frame - 1] if frame > self._born else 0

    def slowdown(self, frame: int, calculators: int) -> Floats:
        """Return the fraction of its speed that each machine has in a frame, (calculators,)."""
        parts: Floats = self._slow[frame]
        return parts


def machine(speeds: Sequence[float], particle_move_s: float) -> Machine:
    """Make machines of relative speeds; a particle that moves costs `particle_move_s` seconds at each end."""
    return Machine("hidden", tuple(speeds), PARTICLE_S, particle_move_s, particle_move_s, 0.0, 0.0)


class Seen(Balancer):
    """A policy that sees loads as measured: with noise, and unsmoothed if `raw`."""

    def __init__(
        self,
        ask: Callable[[Table], Targets | Orders],
        *,
        raw: bool,
        noise: Floats | None = None,
        smoothing: float = 0.5,
    ) -> None:
        """Wrap a policy.

        Args:
            ask: the policy; it takes the arguments of the core's table of loads.
            raw: whether it sees speeds of the last frame, without their errors.
            noise: relative errors of measured seconds, (frames, calculators).
            smoothing: as in `Balancer`.
        """
        self._ask, self._raw, self._noise, self.smoothing = ask, raw, noise, smoothing

    def __deepcopy__(self, _: object) -> Seen:
        """Return itself: it plays one game, and its state is in the submission's process."""
        return self

    @staticmethod
    def by(balancer: Balancer, *, raw: bool, noise: Floats | None) -> Seen:
        """Let a balancer of this process see what a submission would see."""

        def ask(table: Table) -> Targets | Orders:
            return balancer.decide(LoadTable(_core.BalanceTable(**table)))

        return Seen(ask, raw=raw, noise=noise, smoothing=balancer.smoothing)

    def decide(self, load: LoadTable) -> Targets | Orders:
        """Return the policy's decision.

        Args:
            load: the loads of all calculators.

        Returns:
            The policy's answer.
        """
        seconds = load.seconds if self._noise is None else load.seconds * (1 + self._noise[load.frame])
        known = (load.particles > 0) & (seconds > 0)
        speeds = np.where(known, load.particles / np.where(known, seconds, 1), 0)
        return self._ask(
            {
                "frame": load.frame,
                "evaluation": load.evaluation,
                "system": load.system,
                "particles": load.particles.tolist(),
                "seconds": seconds.tolist(),
                "speed": (speeds if self._raw else load.speed).tolist(),
                "cuts": load.cuts.tolist(),
                "error": [] if self._raw else load.error.tolist(),
            }
        )

    def __repr__(self) -> str:
        """Name the submission's class, for error messages."""
        return "Mine()"


class _Knowing(Balancer):
    """Knows speeds and loads without noise, but not the future.

    It moves particles if that pays within `patience` frames while nothing changes.
    """

    smoothing = 0.0

    def __init__(self, track: Track, patience: float, move_s: float) -> None:
        """`patience` is in frames; `move_s` in seconds per particle that moves, at each end."""
        self._track, self._patience, self._move_s = track, patience, move_s

    def decide(self, load: LoadTable) -> Targets | Orders:
        workload = self._track.workload
        rates = self._track.speeds * workload.slowdown(load.frame, len(load))
        below = np.concatenate([[0], np.cumsum(workload.counts(load.frame))])
        cells = np.ceil(np.asarray(load.cuts, np.float64) - 0.5)  # particles are in the middle of their cell
        held = below[np.clip(cells, 0, workload.cells).astype(np.int64)].astype(np.float64)
        wanted = np.cumsum(rates)[:-1] * (below[-1] / rates.sum())
        now, then = (np.concatenate([[0.0], cuts, [float(below[-1])]]) for cuts in (held, wanted))
        kept = np.maximum(np.minimum(now[1:], then[1:]) - np.maximum(now[:-1], then[:-1]), 0)
        moving = float((np.diff(now) + np.diff(then) - 2 * kept).max()) * self._move_s
        saved = float((np.diff(now) / rates).max() - (np.diff(then) / rates).max())
        return Targets(rates) if self._patience * saved > moving else Orders([])


@dataclass(frozen=True)
class Result:
    """A policy's result in a game.

    Attributes:
        name: of the game.
        points: 0..100.
        seconds: of all frames.
        zero_s: seconds that are worth 0 points: those of the best simple policy.
        full_s: seconds that are worth 100 points: those of the better of two policies, the course's own
            solution and one that knows each machine but not the future; where the latter is far better, those
            with which the solution is worth 80 points.
        moved: particles that the policy moved.
        full_moved: particles that the better of the two policies moved.
        frame_s: seconds of each frame.
    """

    name: str
    points: float
    seconds: float
    zero_s: float
    full_s: float
    moved: int
    full_moved: int
    frame_s: Sequence[float] = field(repr=False, compare=False, default=())


@dataclass(frozen=True)
class Game:
    """A load on machines.

    Attributes:
        name: the description for students.
        workload: the particles' places in each frame.
        machine: the speeds.
        noise: relative errors of measured seconds, (frames, calculators); None: no errors.
        raw: whether policies see each frame's own speeds, not the engine's smoothed ones.
        options: arguments with which a policy is made.
        evening: whose solution plays for comparison.
    """

    name: str
    workload: Hidden
    machine: Machine
    noise: Floats | None = None
    raw: bool = True
    options: dict[str, float] = field(default_factory=dict)
    evening: int = 0
    _simple_s: list[float] = field(default_factory=list, repr=False, compare=False)

    @cached_property
    def track(self) -> Track:
        """The track on which policies play the game."""
        return Track(self.workload, self.machine)

    @cached_property
    def own(self) -> Score:
        """The score of the course's own solution."""
        return self.track.play(self.seen(own(self.evening)(**self.options)))

    @cached_property
    def is_fair(self) -> bool:
        """Whether the course's own solution is clearly faster than each simple policy."""
        return all(seconds > LEAD * self.own.seconds for seconds in self.simple_s())

    def simple_s(self) -> Iterator[float]:
        """Let each simple policy play once, and yield its seconds."""
        equal = self.noise is None and self.raw and len(set(self.machine.speeds)) == 1
        for number, policy in enumerate(simple(equal=equal, smoothed=not self.raw)):
            if number == len(self._simple_s):
                self._simple_s.append(self.track.play(self.seen(policy)).seconds)
            yield self._simple_s[number]

    @cached_property
    def bounds(self) -> tuple[float, float, Score]:
        """Seconds worth 0 points, seconds worth 100 points, and the best score known."""
        zero_s, move_s = min(self.simple_s()), self.machine.leave_s
        knowing = [self.track.play(_Knowing(self.track, frames, move_s)) for frames in PATIENCE]
        best = min([self.own, *knowing], key=lambda score: score.seconds)
        return zero_s, max(best.seconds, zero_s - (zero_s - self.own.seconds) / OWN), best

    def seen(self, balancer: Balancer) -> Balancer:
        """Let a balancer of this process see what a submission would see."""
        return Seen.by(balancer, raw=self.raw, noise=self.noise)

    def play(self, balancer: Balancer) -> Result:
        """Let a balancer play the game.

        Args:
            balancer: sees the true loads; wrap it in `seen` to show it what a submission would see.

        Returns:
            The result, which is the same in each repeat.
        """
        score = self.track.play(balancer)
        zero_s, full_s, best = self.bounds
        worth = (zero_s - score.seconds) / (zero_s - full_s)
        return Result(
            self.name,
            points=round(100 * min(max(worth, 0.0), 1.0), 1),
            seconds=score.seconds,
            zero_s=zero_s,
            full_s=full_s,
            moved=score.moved,
            full_moved=best.moved,
            frame_s=score.frame_s,
        )
