"""Pairs that collide at any speed: momentum is conserved and energy never added."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest

import motes

DT = 0.5
COUNT = 300


class Pairs(NamedTuple):
    """Pairs of particles far from other pairs: two rows of each array."""

    position: np.ndarray
    velocity: np.ndarray
    mass: np.ndarray
    size: np.ndarray

    def reversed(self) -> Pairs:
        """Return the pairs with their ends swapped."""
        return Pairs(*(array[::-1] for array in self))

    def energy(self, velocity: np.ndarray) -> np.ndarray:
        """Return each pair's kinetic energy relative to its centre of mass, J."""
        reduced = self.mass.prod(axis=0) / self.mass.sum(axis=0)
        return reduced * ((velocity[0] - velocity[1]) ** 2).sum(axis=1) / 2

    def momentum(self, velocity: np.ndarray) -> np.ndarray:
        """Return each pair's momentum, kg m/s."""
        return (self.mass[..., None] * velocity).sum(axis=0)


def unit(dice: np.random.Generator) -> np.ndarray:
    v = dice.normal(size=(COUNT, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def flying(speed: float, seed: int, *, alike: bool = False) -> Pairs:
    """Return pairs that start apart and fly at each other, head-on or grazing.

    speed: mean relative displacement in a step, in reaches.
    """
    dice = np.random.default_rng(seed)
    middle = 60.0 * np.stack(np.unravel_index(np.arange(COUNT), (7, 7, 7)), axis=1)
    size = np.ones((2, COUNT)) if alike else dice.uniform(0.3, 1.7, (2, COUNT))
    reach = size.mean(axis=0)[:, None]
    gap = reach * (1.001 + dice.exponential(0.7, (COUNT, 1)) * (dice.random((COUNT, 1)) < 0.8))
    way = unit(dice)
    aside = unit(dice) * reach * dice.random((COUNT, 1)) * (dice.random((COUNT, 1)) < 0.7)
    aim = aside - way * gap
    aim *= (
        speed * reach / DT * dice.uniform(0.3, 1.7, (COUNT, 1)) / np.linalg.norm(aim, axis=1, keepdims=True)
    )
    part, drift = dice.random((COUNT, 1)), unit(dice) * np.linalg.norm(aim, axis=1, keepdims=True)
    drift *= dice.random((COUNT, 1))
    mass = np.ones((2, COUNT)) if alike else 10 ** dice.uniform(-2, 2, (2, COUNT))
    position = [middle - way * gap / 2, middle + way * gap / 2]
    return Pairs(*map(np.float32, (position, [drift - aim * part, drift + aim * (1 - part)], mass, size)))


def met(pairs: Pairs, record: Any, frames: int, two_systems: bool = False) -> np.ndarray:
    """Return the velocities after some frames of an action."""
    world = motes.World(seed=1, dt=DT, progress="off")
    systems = [world.system("a"), world.system("b")]
    with world:
        for frame in world.frames(frames):
            if frame == 0:
                for system, end in ((systems[0], 0), (systems[two_systems], 1)):
                    x, v, m, size = (array[end] for array in pairs)
                    system.emit(position=x, velocity=v, mass=m, size=np.repeat(size[:, None], 3, axis=1))
            record(systems[0], systems[1] if two_systems else None)
            for system in systems:
                system.move()
            world.step()
        found = [system.gather().velocity for system in systems]
    return np.concatenate(found).reshape(2, COUNT, 3).astype(np.float64)


@pytest.mark.parametrize("two_systems", [False, True])
@pytest.mark.parametrize("speed", [0.05, 0.3, 0.8, 1.2, 2.0, 4.0])
def test_collisions_never_add_energy(speed: float, two_systems: bool):
    for seed in range(6):
        pairs = flying(speed, seed, alike=seed == 5)
        if seed % 2:
            pairs = pairs.reversed()
        restitution, friction = (0, 0.3, 0.5, 0.9, 1, 1)[seed], (0, 0.3, 0)[seed % 3]

        def collide(
            s: motes.System,
            other: motes.System | None,
            restitution: float = restitution,
            friction: float = friction,
        ) -> None:
            s.collide(restitution=restitution, friction=friction, other=other)

        before = pairs.velocity.astype(np.float64)
        for frames in (1, 4):
            after = met(pairs, collide, frames, two_systems)
            assert (after != before).any(axis=(0, 2)).sum() > (20 if speed < 4 else 5), "pairs that met"
            assert (pairs.energy(after) <= pairs.energy(before) * (1 + 1e-5)).all()
            error = pairs.momentum(after) - pairs.momentum(before)
            assert np.abs(error).max() < 1e-5 * np.abs(pairs.mass[..., None] * before).max()


@pytest.mark.parametrize("speed", [0.3, 0.8, 1.2, 2.0, 4.0])
def test_ties_between_those_that_fly_past_each_other_add_no_energy(speed: float):
    """Ties are as long as their pairs are apart, so they hold no energy at first."""
    for seed in range(3):
        pairs = flying(speed, seed, alike=seed == 2)
        lengths = np.linalg.norm(np.subtract(*pairs.position), axis=1)
        ties = motes.Ties(np.arange(2 * COUNT).reshape(2, -1).T, lengths)
        for frames in (1, 4):
            after = met(pairs, lambda s, _, ties=ties: s.tie(ties), frames)
            gain = pairs.energy(after) / pairs.energy(pairs.velocity.astype(np.float64))
            assert gain.max() < 1.05, (seed, frames, gain.max())


def test_a_fast_pair_bounces_off_where_it_touched_first():
    """Head-on, at 1.6 reaches per step: the ends have passed each other by 0.3 reaches when the step ends."""
    for restitution in (0, 0.5, 1):
        x = np.float32([(-0.65, 0, 0), (0.65, 0, 0)])
        v = np.float32([(1.6, 0, 0), (-1.6, 0, 0)])
        world = motes.World(seed=1, dt=DT, progress="off")
        s = world.system("s")
        with world:
            for frame in world.frames(3):
                if frame == 0:
                    s.emit(position=x, velocity=v)
                s.collide(0.5, restitution=restitution, friction=0.5)
                s.move()
                world.step()
                if frame == 0:
                    first = s.gather().velocity[0, 0]
            found = s.gather()
        if restitution == 0:  # they touch at the end of the step, then stop
            assert first == pytest.approx(0.15 / DT) and abs(found.velocity[0, 0]) < 1e-6
        else:
            assert first == pytest.approx(-1.6 * restitution)
        assert np.abs(found.velocity[0] + found.velocity[1]).max() == 0


def test_gravity_decides_what_is_too_slow_to_rebound():
    """Without it all pairs rebound, at any speed; with it those slower than 0.8 of `sleep` do not."""

    def parted(speed: float, *, gravity: float = 0, **given: Any) -> float:
        world = motes.World(seed=1, dt=0.01, progress="off")
        s = world.system("s")
        with world:
            s.emit(position=[(-0.505, 0, 0), (0.505, 0, 0)], velocity=[(speed, 0, 0), (-speed, 0, 0)])
            if gravity:
                s.gravity((0, -gravity, 0))
            s.collide(0.505, restitution=0.5, friction=0, **given)
            world.step()
            return -float(s.gather().velocity[0, 0]) / speed

    rebound, stop = pytest.approx(0.5, abs=1e-4), pytest.approx(0, abs=1e-4)
    assert parted(0.4) == rebound and parted(40) == rebound
    slow = 2 * 9.81 * 0.01  # of the pair: each has half of it
    assert parted(slow / 2 * 1.01, gravity=9.81) == rebound and parted(slow / 2 * 0.99, gravity=9.81) == stop
    assert parted(slow, gravity=1.9 * 9.81) == rebound and parted(slow, gravity=2.1 * 9.81) == stop
    assert parted(0.5, sleep=1.24) == rebound and parted(0.5, sleep=1.26) == stop
