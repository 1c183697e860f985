"""A call refuses nonsense with an ArgumentError or accepts it; what is accepted runs and stays finite."""

from __future__ import annotations

import random
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from nonsense import NONSENSE, constructors, drawn, methods, shown

import motes
from motes import _core
from motes._system.system import state_of
from motes.errors import ArgumentError, MotesError

STEPS_S = (1 / 24, 1 / 24, 1e-9, 1.0, 1e9)
FRAMES = 40
PLACES = [(0, 0, 0), (0.25, 0.5, 0), (1, 2, 3), (0, 1, 0), (1e6, -2, 3)]
SPEEDS = [(0, 0, 0), (0, 0.125, 1), (-1, -2, -3), (0, -1, 0), (1e4, 0, 0)]


class Fuzz:
    """Makes random calls, runs those that were accepted, and keeps one example of each failure."""

    def __init__(self, seed: int) -> None:
        """Start from a seed."""
        self.dice = random.Random(seed)
        self.taken = self.refused = 0
        self.wrong: dict[str, str] = {}
        self.recorded: list[str] = []

    def make(self, calls: list[Callable[..., Any]], system: motes.System) -> Any:
        """Make one of the calls at random; return its result, or None if it was refused."""
        call = self.dice.choice(calls)
        places, named = drawn(self.dice, call, system)
        name = getattr(call, "__qualname__", str(call))
        try:
            result = call(*places, **named)
        except Exception as error:
            self.refused += 1
            known = isinstance(error, TypeError) and ("missing" in str(error) or "unsupported" in str(error))
            if not isinstance(error, MotesError) and not known:
                self.wrong[f"{name}: {type(error).__name__}: {error}"] = shown(places, named)
            return None
        self.taken += 1
        self.recorded.append(f"{name}{shown(places, named)}")
        return result

    def run(self, count: int) -> None:
        """Make `count` calls, in worlds that step after every few calls."""
        while self.taken + self.refused < count:
            dt, substeps = self.dice.choice(STEPS_S), self.dice.choice([1, 2])
            world = motes.World(seed=1, dt=dt, substeps=substeps, progress="off")
            system = world.system("a", capacity=40, attributes={"heat": 0.0, "wind": (0, 0, 0)})
            makers, calls = constructors(), methods(system, "callback", "gather", "local", "pairs")
            with world:
                for frame in world.frames(FRAMES):
                    for _ in range(self.dice.randrange(6)):
                        self.make(makers, system)
                    self.recorded = [f"dt={dt}", f"frame {frame}"] if frame % 4 == 0 else self.recorded
                    system.emit(position=PLACES, velocity=SPEEDS)
                    for _ in range(self.dice.randrange(1, 8)):
                        self.make(calls, system)
                    self.step(system, last=frame % 4 == 3)

    def step(self, system: motes.System, *, last: bool) -> None:
        """Run the frame and check the particles; the last of four frames kills them all."""
        system.move()
        if last:
            system.world.renderer = self.renderer(system)
            system.world.render()
        else:
            system.world.step()
        p = system.gather()
        for name in ("position", "velocity"):
            if not np.isfinite(getattr(p, name)).all():
                self.wrong[f"{name} after {self.recorded[0]}"] = "\n    ".join(self.recorded)
        if last:
            system.kill_old(-np.inf)
            state_of(system).newborn.restore(({}, {}))

    def renderer(self, system: motes.System) -> motes.Renderer:
        """Make a renderer from nonsense if it is accepted, otherwise an ordinary one."""
        made = [self.make([motes.Renderer, motes.Camera, motes.Sprite], system) for _ in range(3)]
        sprites = [one for one in made if isinstance(one, motes.Sprite)]
        system.sprite = sprites[0] if sprites else system.sprite
        cameras = [one for one in made if isinstance(one, motes.Camera)]
        renderers = [one for one in made if isinstance(one, motes.Renderer)]
        if renderers:
            return renderers[0]
        try:
            return motes.Renderer(16, 12, camera=cameras[0])
        except (ArgumentError, IndexError):
            return motes.Renderer(16, 12, camera=motes.Camera((0, 0, 5), (0, 0, 0)))


def nonsense_calls(count: int, seed: int) -> None:
    """Make random calls, and fail with a list of all errors."""
    fuzz = Fuzz(seed)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", motes.MotesWarning)  # nonsense causes many of these
        fuzz.run(count)
    assert not fuzz.wrong, "\n".join(f"{what}\n    {how}" for what, how in sorted(fuzz.wrong.items()))
    assert min(fuzz.taken, fuzz.refused) > count / 10, "both happen"


def test_nonsense_is_refused_or_runs():
    nonsense_calls(3000, seed=1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_more_nonsense_is_refused_or_runs(seed):
    nonsense_calls(10_000, seed=100 + seed)


ANSWERS: dict[str, Callable[[Any], Any]] = {
    "decide's answer": lambda value: value,
    "shares": motes.balance.Targets,
    "a share": lambda value: motes.balance.Targets([value, 1, 1]),
    "orders": motes.balance.Orders,
    "an order": lambda value: motes.balance.Orders([value]),
    "from": lambda value: motes.balance.Orders([(value, 1, 1)]),
    "to": lambda value: motes.balance.Orders([(0, value, 1)]),
    "count": lambda value: motes.balance.Orders([(0, 1, value)]),
}


@pytest.mark.parametrize("what", ANSWERS)
def test_answers_of_nonsense_become_legal_or_name_policy_and_frame(what):
    class Odd(motes.balance.Balancer):
        value: Any = None

        def decide(self, load: motes.balance.LoadTable) -> Any:
            return ANSWERS[what](self.value)

    table = _core.BalanceTable(12, 0, "snow", [100] * 3, [0.0] * 3, [1e6] * 3, [1, 2])
    odd = Odd()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for odd.value in [*NONSENSE, [1e308] * 3, [1e-320, 0, 0], (0, 1, 5), {0: 1, 1: 1, 2: 1}, "111"]:
            try:
                plan = odd._policy.plan(table)
            except ArgumentError as error:
                assert "Odd(), frame 12" in str(error)
                continue
            if len(plan.shares):
                assert len(plan.shares) == 3 and plan.shares.sum() == pytest.approx(1)
            assert all(abs(source - to) == 1 and 0 < count <= 100 for source, to, count in plan.orders)


OPTIONS = [
    *(
        (kind, name)
        for kind in (motes.balance.Pairwise, motes.balance.PrefixCuts)
        for name in ("threshold", "min_particles")
    ),
    *(
        (motes.balance.Diffusive, name)
        for name in ("threshold", "rate", "min_particles", "manager", "smoothing", "over")
    ),
    *((lambda: motes.balance.Proportional([1, 1, 1]), name) for name in ("powers", "threshold", "over")),
    (motes.balance.PrefixCuts, "powers"),
]


@pytest.mark.parametrize(("kind", "name"), OPTIONS)
def test_options_of_balancers_are_checked_when_set_later_too(kind, name):
    refused = 0
    for value in NONSENSE:
        balancer = kind()
        setattr(balancer, name, value)
        try:
            balancer._policy.check(3)
            assert eval(repr(balancer), vars(motes.balance))._policy.name == balancer._policy.name
        except ArgumentError:
            refused += 1
    assert refused > len(NONSENSE) / 2


@pytest.mark.parametrize(
    "wish",
    ["dt", "substeps", "axis", "space", "roles", "digest", "seed", "balancer", "combine", "clock", "spans"],
)
def test_worlds_of_nonsense_run(wish):
    """A world runs with every setting that it accepts."""
    ran = 0
    sense = [(-1e12, 1e15), "fit", "shared", "y", 2**64 - 1, 1e-9, 1e9, "overlapped", "wall"]
    for value in [*NONSENSE, *sense, motes.balance.Pairwise()]:
        try:
            world = motes.World(**{"seed": 1, "progress": "off", wish: value})
        except ArgumentError as error:
            assert wish in str(error)
            continue
        ran += 1
        system = world.system("a")
        with world:
            for _ in world.frames(2):
                system.emit(position=PLACES, velocity=SPEEDS)
                system.random_displacement(motes.shapes.Sphere((0, 0, 0), 1))
                system.move()
                world.step()
            assert np.isfinite(system.gather().position).all()
    assert ran
