"""Interactions across the ends of periodic space."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from list_jobs import searched
from numpy.typing import NDArray
from standing import alike

import motes
from motes import expressions as ex
from motes import shapes
from motes.errors import RankError

Acts = Callable[[motes.System], Any]
LAWS: dict[str, Acts] = {
    "collide": lambda s: s.collide(0.4, restitution=0.5),
    "contact": lambda s: s.contact(500, radius=0.4),
    "fluid": lambda s: s.fluid(1.0, rest_density=1),
    "gravitate": lambda s: s.gravitate(2, 0.1, max_radius=1),
    "match_velocity": lambda s: s.match_velocity(0.1, 0.1, max_radius=1),
    "match_rotational_velocity": lambda s: s.match_rotational_velocity(0.1, 0.1, max_radius=1),
    "pairs": lambda s: s.pairs(lambda p: p.position - p.other_position, 1),
    "interact": lambda s: s.interact(1, acceleration=ex.normal * (1 - ex.r) * 40),
    "follow": lambda s: s.follow(2, 0.1),
    "tie": lambda s: s.tie(motes.Ties([(0, 1)], 0.3)),
    "tie to what is pinned": lambda s: s.tie(motes.Ties([(0, 1)], 0.3, pinned=[0]), stretch=0.1),
}


def moved(act: Acts, position: Any, periodic: Any, velocity: Any = None, frames: int = 1) -> NDArray[Any]:
    """Run `act` in each frame; return unwrapped positions, velocities and spins."""
    world = motes.World(seed=1, dt=0.0625, periodic=periodic, progress="off")
    s = world.system("s")
    spin = np.arange(3.0 * len(position)).reshape(-1, 3)
    with world:
        for frame in world.frames(frames):
            if frame == 0:
                wishes = {} if velocity is None else {"velocity": velocity}
                s.emit(position=position, rotational_velocity=spin, **wishes)
            act(s)
            s.move()
            world.step()
        p = s.gather(unwrapped=True)
        return np.concatenate([p.position, p.velocity, p.rotational_velocity], axis=1)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("axes", ["x", "z", "yz", "xyz"])
def test_what_is_near_across_an_end_is_near(name: str, axes: str):
    """Two particles on both sides of an end, or of a corner, behave as in the middle."""
    here = np.array([[-0.25, -0.125, -0.125], [0.25, 0.125, 0.125]])
    ends = {axis: (-4, 4) for axis in axes}
    velocity = [(0.5, 0, 0), (-0.5, 0, 1)]
    wanted = moved(LAWS[name], here, None, velocity)
    start = moved(lambda s: None, here, None, velocity)
    assert not np.array_equal(wanted, start), "they see each other"
    assert np.array_equal(moved(LAWS[name], here, ends, velocity), wanted), "in the middle"
    shift = np.array([4.0 * (axis in axes) for axis in "xyz"])
    found = moved(LAWS[name], here + shift, ends, velocity)
    found[:, :3] -= shift
    assert np.abs(found - wanted).max() < 1e-5


@searched(12)
@given(st.tuples(*[st.floats(-20, 20, width=32)] * 3))
def test_a_world_that_is_moved_does_the_same(shift: tuple[float, float, float]):
    dice = np.random.default_rng(8)
    position = dice.uniform(0, 3, (60, 3))
    velocity = dice.uniform(-2, 2, (60, 3))
    ends = {"x": (0, 3), "y": (0, 3), "z": (0, 3)}

    def act(s: motes.System) -> None:
        s.gravitate(0.5, 0.1, max_radius=1.5)
        s.contact(50, friction=0.5, radius=0.2)

    still = moved(act, position, ends, velocity, frames=4)
    there = moved(act, position + shift, ends, velocity, frames=4)
    there[:, :3] -= np.asarray(shift)
    assert np.abs(there - still).max() < 2e-3
    assert np.abs(still[:, 3:6].mean(axis=0) - velocity.mean(axis=0)).max() < 1e-4, "momentum"


def test_grains_remember_their_touches_across_an_end():
    """Two grains press on each other and slide: friction holds them as in the middle."""

    def act(s: motes.System) -> None:
        s.set(velocity=ex.column("velocity") * (0, 1, 0))
        s.contact(2000, friction=0.9, rolling_friction=0.3, radius=0.5)

    here, speed = np.array([[-0.45, 0, 0], [0.45, 0, 0]]), [(0, 1, 0), (0, -1, 0)]
    wanted = moved(act, here, None, speed, frames=12)
    found = moved(act, here + (2, 0, 0), {"x": (-2, 2)}, speed, frames=12)
    found[:, 0] -= 2
    assert np.abs(found - wanted).max() < 1e-3


def test_a_lattice_that_fills_space_is_at_rest():
    """All particles have the same neighbours, so gravity, springs and a fluid move none of them."""
    grid = np.stack(np.meshgrid(*[np.arange(8) * 0.25] * 3), axis=-1).reshape(-1, 3)
    ends = {axis: (0, 2) for axis in "xyz"}
    for act in (
        lambda s: s.gravitate(1, 0.01, max_radius=0.9),
        lambda s: s.contact(10, friction=0, radius=0.2),
        lambda s: s.fluid(0.5, rest_density=10),
    ):
        assert np.abs(moved(act, grid, ends)[:, 3:6]).max() < 1e-4


def test_a_ring_of_ties_goes_around_space():
    """A ring has no end: it pulls equally everywhere and behaves the same wherever it begins."""
    count = 8
    start = np.stack([np.arange(count) + 0.5, np.zeros(count), np.zeros(count)], axis=1)
    ring = motes.Ties([(i, (i + 1) % count) for i in range(count)], 0.75)
    ends = {"x": (0, count)}
    assert np.abs(moved(lambda s: s.tie(ring), start, ends)[:, 3:6]).max() < 1e-5
    start[3, 1] = 0.5
    plucked, begun_elsewhere = (
        moved(lambda s: s.tie(ring), start + (shift, 0, 0), ends, frames=6) for shift in (0, 4.25)
    )
    begun_elsewhere[:, 0] -= 4.25
    assert np.abs(plucked[[2, 4], 4]).min() > 0.1, "the wave has left"
    assert np.abs(plucked - begun_elsewhere).max() < 1e-4


def test_tethers_hold_across_an_end_unless_they_are_too_long_to_tell_the_end():
    """The first tether of the rope holds; the second is longer than half a period."""
    rope = motes.Ties([(0, 1), (1, 2)], 1.25, pinned=[0])
    start = np.array([(3, 0, 0), (0.5, 0, 0), (0.9, 1.9, 0)])
    found = moved(lambda s: s.tie(rope, stretch=1e9), start, {"x": (0, 4), "y": (0, 4)})
    start[1, 0] = 0.25
    assert np.abs(found[:, :3] - start).max() < 1e-5


TWO_SYSTEMS = """
import motes
world = motes.World(seed=1, periodic={"z": (0, 4)}, axis="z", roles="shared", progress="off")
a, b = world.system("a"), world.system("b", axis="x")
with world:
    for frame in world.frames(3):
        if frame == 0:
            a.emit(position=[(0, 0, 0.1), (0, 0, 2)])
            b.emit(position=[(0.1, 0, 3.9), (3, 0, 2)], velocity=[(0, 0, 1), (0, 0, 0)])
        a.collide(radius=0.3, other=b, other_radius=0.2)
        a.move()
        b.move()
        world.step()
        if frame == 2:
            found = [one.gather(to="all").velocity.tolist() for one in (a, b)]
            digest = world.digest()
            print(digest, found) if world.rank == 0 else None
"""


def test_two_systems_collide_across_an_end():
    line = alike(TWO_SYSTEMS, ranks=(1, 2, 3, 5))[0]
    first, second = eval(line.partition(" ")[2])
    assert first[0][2] > 0.3 and second[0][2] < 0.7
    assert first[1] == second[1] == [0, 0, 0]


def test_a_newborn_that_overlaps_one_across_an_end_is_cleared():
    world = motes.World(seed=1, periodic={"x": (0, 4)}, progress="off")
    s = world.system("s")
    with world:
        s.burst((0.05, 0, 0))
        s.move()
        world.step()
        s.burst((3.95, 0, 0))
        s.burst((3.5, 0, 0))
        s.collide(0.2, clear=0.1)
        world.step()
        assert s.gather().id.tolist() == [0, 2]


@pytest.mark.parametrize("law", ["collide", "contact", "contact of clumps"])
def test_particles_that_grow_too_large_are_reported(law: str):
    world = motes.World(seed=1, periodic={"x": (0, 4)}, progress="off")
    s = world.system("s")
    with (
        pytest.raises((RankError, ValueError), match=rf"{law.split()[0]} reaches 2\.2.* at most 2\.0"),
        world,
    ):
        if "clumps" in law:
            s.clumps([(0, 0, 0, 0.5)])
        s.configure(size=2.2)
        s.burst(shapes.Box((0, 0, 0), (4, 1, 1)), count=3)
        s.collide() if law == "collide" else s.contact(1000)
        world.step()
