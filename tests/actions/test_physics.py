"""Physics of interacting particles: conservation, collisions of two, heaps that stand still."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import motes
from motes.expressions import column
from motes.shapes import Plane

Record = Callable[[motes.System], None]
FLOOR = Plane((0, 0.02, 0), (0, 1, 0))  # for the centres of grains with a radius of 2 cm


def states(
    state: dict[str, Any], record: Record, frames: int, *, every: int = 1, **world: Any
) -> Iterator[motes.Particles]:
    """Yield particles before the recorded list acts on them, and then after every `every` frames."""
    made = motes.World(seed=3, progress="off", **world)
    system = made.system("all")
    with made:
        for frame in made.frames(frames + 1):
            if frame == 0:
                system.emit(**state)
            else:
                record(system)
            made.step()
            if frame % every == 0:
                yield system.gather()


def at(particles: motes.Particles) -> NDArray[np.float64]:
    return particles.position.astype(np.float64)


def speeds(particles: motes.Particles) -> NDArray[np.float64]:
    return particles.velocity.astype(np.float64)


@pytest.mark.parametrize("part", [1.0, 0.8])  # fraction of a circular orbit's speed
def test_two_bodies_keep_their_energy(part: float):
    pull, apart = 2.0, 1.5
    speed = part * math.sqrt(pull / (2 * apart))
    start = {
        "position": [(-apart / 2, 0, 0), (apart / 2, 0, 0)],
        "velocity": [(0, -speed, 0), (0, speed, 0)],
    }

    def orbit(bodies: motes.System) -> None:
        bodies.gravitate(pull, epsilon=0)
        bodies.move()

    moments = list(states(start, orbit, 1001, dt=1 / 100))
    apart_now = np.array([at(p)[1] - at(p)[0] for p in moments])
    # A leapfrog: each position lies in time between the velocities before and after it.
    v = np.array([speeds(p) for p in moments])
    kinetic = (((v[1:] + v[:-1]) / 2) ** 2).sum(axis=(1, 2)) / 2
    energies = (kinetic - pull / np.linalg.norm(apart_now[:-1], axis=1))[1:]
    assert np.abs(energies / energies[0] - 1).max() < 0.005
    turns = np.unwrap(np.arctan2(apart_now[:, 1], apart_now[:, 0])) / (2 * math.pi)
    # The semi-major axis by the vis-viva equation, the period by Kepler's third law.
    a = apart / (2 - part**2)
    period = 2 * math.pi * math.sqrt(a**3 / (2 * pull))
    assert turns[round(100 * period)] - turns[0] == pytest.approx(1, abs=0.005)


def cluster(n: int, seed: int = 0) -> dict[str, NDArray[np.float64]]:
    """Return particles that fly towards their centre."""
    dice = np.random.default_rng(seed)
    place = dice.normal(0, 0.5, (n, 3))
    return {"position": place, "velocity": -2 * place + dice.normal(0, 0.3, (n, 3)) + (0.5, -0.3, 0.1)}


@pytest.mark.parametrize("restitution", [0.1, 0.6, 1])
@pytest.mark.parametrize("mass", [(1, 1), (1, 8)])
def test_two_grains_head_on(restitution: float, mass: tuple[float, float]):
    def touch(balls: motes.System) -> None:
        balls.contact(5e4, restitution=restitution, radius=0.1)
        balls.move()

    start = {"position": [(-0.2, 0, 0), (0.2, 0, 0)], "velocity": [(2, 0, 0), (-1, 0, 0)], "mass": mass}
    *_, last = states(start, touch, 16, substeps=200)
    before = np.array((2.0, -1.0))
    middle = np.average(before, weights=mass)
    assert speeds(last)[:, 0] == pytest.approx(middle + restitution * (middle - before), abs=0.01)


def test_grains_keep_their_momentum_and_turn():
    start = cluster(200)
    radius = np.random.default_rng(1).uniform(0.06, 0.1, 200)
    start |= {"size": 2 * radius[:, None] * (1, 1, 1), "mass": (radius / 0.06) ** 3}

    def touch(grains: motes.System) -> None:
        grains.contact(20_000, friction=0.7, rolling_friction=0.1)
        grains.move()

    first, *later = states(start, touch, 60, every=4, substeps=60)
    mass = first.mass.astype(np.float64)[:, None]
    inertia = 0.4 * mass * radius[:, None] ** 2

    def turning(p: motes.Particles) -> NDArray[np.float64]:
        spin = p.rotational_velocity.astype(np.float64)
        return (np.cross(at(p), mass * speeds(p)) + inertia * spin).sum(axis=0)

    assert np.linalg.norm(later[-1].rotational_velocity, axis=1).mean() > 1
    assert max(p.contacts.mean() for p in later) > 1
    assert max(p.contacts.max() for p in later) <= 12, "all touches are remembered"
    all_push = np.linalg.norm(mass * speeds(first), axis=1).sum()
    for p in later:
        assert np.linalg.norm((mass * (speeds(p) - speeds(first))).sum(axis=0)) < 1e-5 * all_push
        assert np.linalg.norm(turning(p) - turning(first)) < 1e-4 * all_push  # lever arms of up to a metre


@pytest.mark.parametrize(
    ("friction", "rolling_friction", "acceleration"),
    [
        (0.5, 0.5, 0),  # stays at rest
        (0.5, 0, 5 / 7 * math.sin(math.radians(10))),  # rolls like a solid sphere
        (0, 0, math.sin(math.radians(10))),  # slips
        (0.1, 0, 5 / 7 * math.sin(math.radians(10))),  # rolls too: friction is above 2/7 tan 10 degrees
        (0.02, 0, math.sin(math.radians(10)) - 0.02 * math.cos(math.radians(10))),  # slips and rotates
    ],
)
def test_a_grain_on_a_slope(friction: float, rolling_friction: float, acceleration: float):
    down = 9.81 * np.array((math.sin(math.radians(10)), -math.cos(math.radians(10)), 0))

    def roll(
        grains: motes.System,
    ) -> None:  # on a fixed sphere so large that it acts as a plane
        small = column("mass") < 10
        grains.gravity(tuple(down), where=small)
        grains.contact(
            1e4, restitution=0.3, friction=friction, rolling_friction=rolling_friction, where=small
        )
        grains.move()

    start = {
        "position": [(0, -1000, 0), (0, 0.1, 0)],
        "size": [(2000, 1, 1), (0.2, 1, 1)],
        "mass": (1e9, 1),
    }
    way = [at(p)[1, 0] for p in states(start, roll, 100, every=50, dt=1 / 50, substeps=100)]
    if acceleration == 0:
        assert abs(way[2]) < 2e-3
        assert abs(way[2] - way[1]) < 1e-3
    else:
        assert way[2] == pytest.approx(0.5 * 9.81 * acceleration * 4, rel=0.02)


SPACING = 0.05  # m, between water particles


def water(*counts: int) -> dict[str, Any]:
    """Return a block of water, with slightly jittered particles."""
    grid = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), -1).reshape(-1, 3)
    jitter = np.random.default_rng(2).uniform(-1e-3, 1e-3, grid.shape)
    return {"position": (grid + 0.5) * SPACING + jitter, "mass": np.full(len(grid), 1000 * SPACING**3)}


def densities(p: motes.Particles) -> NDArray[np.float64]:
    """Return densities in kg/m3, with the kernel of Mueller et al. (2003) over two spacings."""
    radius2 = (2 * SPACING) ** 2
    apart2 = ((at(p)[:, None] - at(p)[None]) ** 2).sum(axis=2)
    spread = 315 / (64 * np.pi * radius2**4.5) * np.clip(radius2 - apart2, 0, None) ** 3
    return (spread * p.mass.astype(np.float64)).sum(axis=1)


def test_water_comes_to_rest_at_its_density():
    tank = motes.shapes.Box((0, 0, 0), (0.5, 9, 0.25))

    def pour(liquid: motes.System) -> None:
        liquid.gravity((0, -9.81, 0))
        liquid.fluid(radius=2 * SPACING, rest_density=1000)
        liquid.bounce(tank, restitution=0, friction=0)
        liquid.move()

    first, *_, last = states(water(5, 12, 5), pour, 24 * 5, every=24, substeps=20)
    x = at(last)
    assert x[:, 1].max() < 0.6 * at(first)[:, 1].max(), "the column has spread over the tank"
    inner = (x > 0.05).all(axis=1) & (x[:, 0] < 0.45) & (x[:, 2] < 0.2) & (x[:, 1] < 0.7 * x[:, 1].max())
    assert inner.sum() > 10
    assert densities(last)[inner].mean() == pytest.approx(1000, rel=0.03)
    assert densities(last).max() < 1200
    assert np.linalg.norm(speeds(last), axis=1).mean() < 0.1


def test_cohesion_draws_a_bar_together_and_momentum_is_kept():
    def longer(cohesion: float) -> float:
        start = water(16, 4, 4)
        start["velocity"] = np.tile((0.5, -0.25, 1.0), (len(start["position"]), 1))

        def hold(drop: motes.System) -> None:
            drop.fluid(radius=2 * SPACING, rest_density=1000, viscosity=0.02, cohesion=cohesion)
            drop.move()

        first, *_, last = states(start, hold, 48, every=48, substeps=20)
        assert speeds(last).mean(axis=0) == pytest.approx(speeds(first).mean(axis=0), abs=1e-4)
        assert densities(last).max() < 1050
        spread = np.linalg.eigvalsh(np.cov(at(last).T))
        return float(spread[-1] / spread[0])

    assert longer(0) > 12
    assert longer(300) < 7


def test_honey_flows_more_slowly_than_water():
    def shear(viscosity: float) -> float:
        start = water(8, 8, 8)
        start["velocity"] = np.sign(start["position"][:, 1:2] - 0.2) * (1, 0, 0)

        def flow(liquid: motes.System) -> None:
            liquid.fluid(radius=2 * SPACING, rest_density=1000, viscosity=viscosity)
            liquid.move()

        *_, last = states(start, flow, 6, substeps=20)
        return float(np.abs(speeds(last)[:, 0]).mean())

    assert shear(0.1) < 0.8 * shear(0.01) < 0.8 * shear(0)


@pytest.mark.parametrize(
    "wrong",
    [
        "s.contact(0)",
        "s.contact(-1)",
        "s.contact(math.nan)",
        "s.contact(1, restitution=2)",
        "s.contact(1, friction=-1)",
        "s.contact(1, rolling_friction=math.inf)",
        "s.contact(1, radius=0)",
        "s.fluid(0, 1)",
        "s.fluid(1e30, 1)",
        "s.fluid(1, 0)",
        "s.fluid(1, 1, viscosity=-1)",
        "s.fluid(1, 1, cohesion=math.inf)",
    ],
)
def test_wrong_grains_and_liquids_are_refused(wrong: str):
    world = motes.World(progress="off")
    s = world.system("s")
    with world, pytest.raises(motes.ArgumentError):
        eval(wrong, {"s": s, "math": math})


@pytest.mark.parametrize("law", ["contact", "fluid", "collide"])
def test_a_few_at_the_origin_and_at_one_place(law: str):
    start = {"position": [(0, 0, 0), (0.15, 0, 0), (0, 0, 0)]}

    def meet(few: motes.System) -> None:
        if law == "contact":
            few.contact(10, radius=0.1)
        elif law == "collide":
            few.collide(0.1)
        else:
            few.fluid(radius=0.2, rest_density=100)
        few.move()

    *_, last = states(start, meet, 3)
    assert np.isfinite(last.position).all()
    assert np.linalg.norm(at(last)[0] - at(last)[2]) > 0
    assert speeds(last).sum(axis=0) == pytest.approx(0, abs=1e-4)


def column_of(grains: int) -> dict[str, NDArray[np.float64]]:
    """Return a column of 4 cm grains, each layer over the gaps of the one below."""
    wide = round((grains * 0.53) ** (1 / 3))
    high = grains // wide**2
    y, x, z = (grid.ravel() for grid in np.mgrid[:high, :wide, :wide])
    place = np.stack([x - wide / 2, y, z - wide / 2], axis=1) * (0.046, 0.04, 0.046)
    place += (y % 2 * 0.023)[:, None] * (1, 0, 1) + (0, 0.03, 0)
    jitter = np.random.default_rng(5).uniform(-0.003, 0.003, place.shape) * (1, 0, 1)
    return {"position": place + jitter}


@pytest.mark.parametrize(("grains", "seconds"), [(2000, 8), pytest.param(20_000, 10, marks=pytest.mark.slow)])
def test_a_heap_at_rest_changes_no_bit(grains: int, seconds: int):
    def pile(sand: motes.System) -> None:
        sand.gravity((0, -9.81, 0))
        sand.collide(0.02, friction=0.5)
        sand.bounce(FLOOR, restitution=0, friction=1, exact_hit=False)
        sand.move()

    start = column_of(grains)
    first, *_, before, after = states(start, pile, 24 * (seconds + 2), every=48, substeps=20)
    assert at(before)[:, 1].max() < 0.8 * at(first)[:, 1].max(), "the column has fallen apart"
    assert before.position.tobytes() == after.position.tobytes()
    assert before.velocity.tobytes() == after.velocity.tobytes()
    assert at(after)[:, 1].min() > 0.019, "nothing is in the floor"
    assert np.linalg.norm(at(after)[:, [0, 2]], axis=1).max() < 3, "nothing has been thrown"


def flown_down(angle_deg: float, seconds: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return a layer's mean speed on a slope of fixed grains by frame, and its final profile of speeds."""
    wide, deep, layers, width, step = 5, 4, 6, 0.01, 1.25e-4
    dice = np.random.default_rng(2)
    x, y, z = (g.ravel() for g in np.mgrid[0:wide, 0 : layers + 1, 0:deep])
    place = np.stack([x, y * 1.05, z], axis=1) + dice.uniform(-0.12, 0.12, (len(x), 3)) * (y > 0)[:, None]
    place[y == 0, 1] += dice.uniform(-0.35, 0.35, (y == 0).sum())
    ends = {"x": (0, wide * width), "z": (0, deep * width)}
    world = motes.World(seed=1, dt=160 * step, substeps=160, periodic=ends, progress="off")
    grains = world.system("grains", attributes={"still": 1})
    moves = column("still") == 0
    slope = np.radians(angle_deg)
    speeds, profile = [], np.zeros(layers)
    with world:
        for frame in world.frames(round(seconds / world.dt)):
            if frame == 0:
                grains.configure(size=width, mass=2500 * np.pi / 6 * width**3)
                grains.emit(position=(place + (0.5, 0, 0.5)) * width, still=y == 0)
            grains.gravity((9.81 * np.sin(slope), -9.81 * np.cos(slope), 0), where=moves)
            grains.contact(1000, restitution=0.5, friction=0.5, where=moves)
            grains.move()
            world.step()
            p = grains.gather()
            height, speed = p.position[p.still == 0, 1], p.velocity[p.still == 0, 0] / np.sqrt(9.81 * width)
            speeds.append(speed.mean())
            if frame * world.dt > 0.7 * seconds:
                profile += [part.mean() for part in np.array_split(speed[np.argsort(height)], layers)]
    return np.array(speeds), profile / profile.max()


def test_a_layer_of_grains_rests_on_a_slope_or_flows_steadily_down():
    """Speed grows with height (Silbert et al. 2001, as in docs/lab/grains.md)."""
    still, _ = flown_down(16, 0.6)
    assert abs(still[-10:]).max() < 0.01
    speeds, profile = flown_down(27, 2)
    before, last = speeds[33:66].mean(), speeds[66:].mean()
    assert last > 0.5 and last == pytest.approx(before, rel=0.3)
    assert (np.diff(profile) > 0).all()
