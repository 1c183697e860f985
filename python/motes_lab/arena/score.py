"""One balancer on one workload and machine, played frame by frame and scored against the best cuts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from motes.balance import Balancer
from motes.replay import History, simulate

from ..workloads import Workload
from .machines import BYTES, Machine

__all__ = ["Bounds", "Score", "Track", "name_of", "scored"]

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Score:
    """Result of one balancer on one workload and machine.

    Attributes:
        machine: the machine's name.
        workload: the workload's name.
        balancer: the balancer's name.
        ranks: number of calculators.
        frames: number of frames played.
        particles: total number of the workload's particles.
        seconds: total over all frames; a frame takes as long as its slowest calculator.
        optimum_s: `seconds` with each frame's best cuts, if moving particles cost nothing.
        efficiency: time with perfect balance and no moves, divided by `seconds`, 0..1.
        distance: seconds / optimum_s - 1; 0 is optimal.
        moved: particles that new cuts gave to another calculator.
        verified: whether all particles were where expected.
        digest: digest of all particles at the end; "" on virtual machines.
        decided_s: real seconds spent on all decisions on this computer; not part of `seconds`.
        frame_s: seconds of each frame.
        best_s: optimal seconds of each frame.
    """

    machine: str
    workload: str
    balancer: str
    ranks: int
    frames: int
    particles: int
    seconds: float
    optimum_s: float
    efficiency: float
    distance: float
    moved: int
    verified: bool
    digest: str = ""
    decided_s: float = field(default=0.0, repr=False, compare=False)
    frame_s: Sequence[float] = field(default=(), repr=False, compare=False)
    best_s: Sequence[float] = field(default=(), repr=False, compare=False)

    @property
    def figures(self) -> dict[str, Any]:
        """The figures shown in tables; reproducible on a virtual machine."""
        left_out = ("decided_s", "frame_s", "best_s")
        return {name: value for name, value in vars(self).items() if name not in left_out}

    @property
    def is_slow_to_decide(self) -> bool:
        """Whether decisions take more than a tenth of the frames' time, the limit of a run's warning."""
        return self.decided_s > 0.1 * self.seconds


class Bounds:
    """Lower bounds on each frame's time, for any balancer."""

    def __init__(self, workload: Workload, speeds: npt.ArrayLike) -> None:
        """Set the workload and its machines.

        Args:
            workload: the workload.
            speeds: particles per second of each calculator, undisturbed.
        """
        self.workload = workload
        self.speeds: Floats = np.asarray(speeds, np.float64)

    @cached_property
    def best_s(self) -> Floats:
        """Seconds of the slowest calculator in each frame with that frame's best cuts, (frames,)."""
        frames = range(self.workload.frames)
        return np.array([self.workload.optimum(frame, self.speeds).seconds for frame in frames])

    @cached_property
    def ideal_s(self) -> Floats:
        """Seconds of each frame if all calculators took equally long, (frames,)."""
        calculators = len(self.speeds)
        rates = [self.speeds * self.workload.slowdown(k, calculators) for k in range(self.workload.frames)]
        work = [
            self.workload.acting(k).sum() + self.workload.fixed_s(k, self.speeds) @ rate
            for k, rate in enumerate(rates)
        ]
        return np.array([n / rate.sum() for n, rate in zip(work, rates, strict=True)])


class Track(Bounds):
    """A workload on a virtual machine, which any number of balancers can play; deterministic."""

    def __init__(self, workload: Workload, machine: Machine) -> None:
        """Set the workload and the machine.

        Args:
            workload: the workload.
            machine: the virtual machine.
        """
        super().__init__(workload, np.array(machine.speeds) / machine.particle_s)
        self.machine = machine

    @cached_property
    def history(self) -> History:
        """The workload as a history for replay."""
        return self.workload.history(self.speeds)

    def play(self, balancer: Balancer, name: str = "") -> Score:
        """Play the workload under a balancer, like `motes.replay`, and score it.

        Besides the actions, a frame's time includes packing, sending and unpacking the particles that the
        balancer moves.

        Args:
            balancer: the balancer; it gets the same loads as in a run.
            name: the balancer's name in tables; "": its class, with the options that differ from defaults.

        Returns:
            The score; every repeat gives the same one.
        """
        seconds, moved, whole, before, decided_s = [], 0, True, None, 0.0
        for step in simulate(self.history, balancer):
            (system,) = step.systems
            moving = np.zeros(len(self.speeds))
            if before is not None and system.moved:
                moving = self._moving_s(*system.density.overlaps(before, system.cuts))
            seconds.append(float((step.seconds + moving).max()))
            moved += system.moved
            decided_s += step.decided_s
            whole = whole and int(step.particles.sum()) == int(self.workload.counts(step.k).sum())
            before = system.cuts
        called = name or name_of(balancer)
        return scored(
            self.machine.name, called, seconds, self, moved=moved, verified=whole, decided_s=decided_s
        )

    def _moving_s(self, source: Any, to: Any, particles: Floats) -> Floats:
        """Return the seconds that each calculator needs to give and take particles."""
        other, count = source != to, len(self.speeds)
        given = np.bincount(source[other], particles[other], count)
        taken = np.bincount(to[other], particles[other], count)
        work = (given * self.machine.leave_s + taken * self.machine.arrive_s) / np.array(self.machine.speeds)
        link = np.maximum(given, taken) * (BYTES * self.machine.byte_s)
        messages = np.bincount(source[other], minlength=count) + np.bincount(to[other], minlength=count)
        total: Floats = work + link + messages * self.machine.message_s
        return total


def scored(
    machine: str,
    balancer: str,
    frame_s: Sequence[float],
    bounds: Bounds,
    *,
    moved: int,
    verified: bool,
    digest: str = "",
    decided_s: float = 0.0,
) -> Score:
    """Return the score of the frames' times against the lower bounds.

    Args:
        machine: the machine's name.
        balancer: the balancer's name.
        frame_s: seconds of each frame.
        bounds: lower bounds of the workload on these machines.
        moved: particles that new cuts gave to another calculator.
        verified: whether all particles were where expected.
        digest: digest of all particles at the end.
        decided_s: real seconds spent on all decisions.
    """
    seconds, optimum_s = float(np.sum(frame_s)), float(bounds.best_s.sum())
    return Score(
        machine=machine,
        workload=bounds.workload.name,
        balancer=balancer,
        ranks=len(bounds.speeds),
        frames=len(frame_s),
        particles=bounds.workload.particles,
        seconds=seconds,
        optimum_s=optimum_s,
        efficiency=float(bounds.ideal_s.sum()) / seconds,
        distance=seconds / optimum_s - 1,
        moved=moved,
        verified=verified,
        digest=digest,
        decided_s=decided_s,
        frame_s=list(frame_s),
        best_s=bounds.best_s.tolist(),
    )


def name_of(balancer: Balancer) -> str:
    """Return a balancer's class with the options that differ from defaults, except lists such as powers."""
    options = []
    for name, value in vars(balancer).items():
        if name.startswith("_") or isinstance(value, (list, tuple, np.ndarray)):
            continue
        if value != getattr(type(balancer), name, None):
            options.append(f"{name}={value!r}")
    return f"{type(balancer).__name__}({', '.join(options)})" if options else type(balancer).__name__
