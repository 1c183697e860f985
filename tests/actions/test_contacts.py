"""Contact memory: from frame to frame, with several contacts, on ranks that keep lists and ghosts."""

from __future__ import annotations

import numpy as np
import pytest
from standing import alike

import motes
from motes.expressions import column

BED = """
import numpy as np
import motes
from motes.expressions import column

axes, other = {0!r}, {1!r}
rng = np.random.default_rng(5)
places = np.stack(np.meshgrid(*[np.arange(7)] * 3, indexing="ij"), -1).reshape(-1, 3) * 0.1 - 0.3
box = motes.shapes.Box((-0.4, -0.4, -0.4), (0.4, 0.6, 0.4))
with motes.World(
    seed=1, dt=0.02, substeps=30, progress="off", roles="shared", space=(-0.4, 0.4),
    balancer=motes.balance.PrefixCuts(),
) as world:
    grains = world.system("grains", axis=axes)
    grains.emit(
        position=places + rng.uniform(-0.01, 0.01, places.shape),
        velocity=rng.uniform(-0.5, 0.5, places.shape),
        size=np.repeat(rng.uniform(0.05, 0.12, (len(places), 1)), 3, axis=1),
        mass=rng.uniform(0.5, 2, len(places)),
    )
    for frame in world.frames(6):
        grains.gravity((0.0, -9.81, 0.0))
        grains.contact(2000, friction=0.6, rolling_friction=0.05)
        grains.bounce(box, restitution=0.2)
        if frame == 3:
            grains.set(velocity=column("velocity") * 3)
        if frame == 4:
            grains.configure(size=0.05)
            grains.source(motes.shapes.Box((-0.3, 0.4, -0.3), (0.3, 0.5, 0.3)), 1000)
            grains.sink(motes.shapes.Box((-0.4, -0.4, -0.4), (-0.3, 0.6, 0.4)))
        if other:
            grains.collide(radius=0.02)
        grains.move()
        world.step()
        digest = world.digest()
        if "manager" in world.role:
            print(digest, flush=True)
"""


@pytest.mark.parametrize("axes", ["x", "xy"])
def test_grains_that_cross_borders_while_lists_are_kept(axes: str):
    assert len(set(alike(BED.format(axes, False), ranks=(1, 2, 3, 5)))) == 6


@pytest.mark.slow
def test_lists_beside_an_interaction_that_moves_particles_to_their_owners():
    assert len(set(alike(BED.format("xyz", True), ranks=(1, 3, 5)))) == 6


def touching() -> tuple[motes.World, motes.System]:
    """Return a world that is not yet open, and its system."""
    world = motes.World(seed=1, dt=0.001, progress="off")
    return world, world.system("s")


PLACES = [(0, 0, 0), (0.9, 0, 0), (9, 0, 0), (9.9, 0, 0)]


def test_contacts_of_different_particles_may_stand_in_one_list():
    world, s = touching()
    with world:
        s.emit(position=PLACES)
        for _ in world.frames(3):
            s.contact(10, radius=0.5, where=column("position").x < 5)
            s.contact(10, radius=0.5, where=column("position").x > 5)
            world.step()
            v = s.gather().velocity[:, 0]
            assert v[0] < 0 < v[1]
            np.testing.assert_allclose(v[2:], v[:2], rtol=1e-3)


STOPPED = """
import numpy as np
import motes
rng = np.random.default_rng(3)
box = motes.shapes.Box((-0.6, -0.6, -0.6), (0.6, 0.6, 0.6))
with motes.World(seed=1, dt=0.02, substeps=2, progress="off", roles="shared", space=(-0.05, 0.05)) as world:
    grains = world.system("grains")
    places, velocity = rng.uniform(-0.5, 0.5, (400, 3)), rng.uniform(-4, 4, (400, 3))
    grains.emit(position=places, velocity=velocity, size=np.full((400, 3), 0.12))
    for frame in world.frames(16):
        for stiffness in (500, 200)[: max(0, 5 - frame)]:
            grains.contact(stiffness)
        grains.collide(radius=0.01)
        grains.bounce(box)
        grains.move()
        world.step()
        digest = world.digest()
        if "manager" in world.role:
            print(digest, flush=True)
"""


def test_what_grains_remember_when_contact_stops_is_the_same_on_any_ranks():
    assert len(set(alike(STOPPED, ranks=(1, 3)))) == 16


@pytest.mark.parametrize("place", [0, 1])
def test_of_two_contacts_the_first_remembers(place: int):
    """The second contact, too soft to push, must not overwrite how far a pair has slid."""

    def slid(others: int) -> np.ndarray:
        world, s = touching()
        with world:
            s.emit(position=PLACES, velocity=[(0, 0.1, 0), (0, -0.1, 0)] * 2)
            for _ in world.frames(40):
                s.contact(50, radius=0.5, friction=0.9)
                for _ in range(others):
                    s.contact(1e-4, radius=0.5, friction=0)
                s.move()
                world.step()
            return s.gather().velocity[2 * place : 2 * place + 2, 1]

    np.testing.assert_allclose(slid(1), slid(0), rtol=1e-3)
    np.testing.assert_allclose(slid(2), slid(0), rtol=1e-3)


def test_who_is_not_chosen_remembers_no_grain():
    """A grain along which another slid before it was chosen feels it as one that has just arrived."""
    world = motes.World(seed=1, dt=1e-3, progress="off")
    grains = world.system("grains", attributes={"late": 1})
    with world:
        grains.emit(
            position=[(0, 0, 0), (0, 0.099, 0)],
            velocity=[(0, 0, 0), (0.3, 0, 0)],
            size=[(0.1,) * 3] * 2,
            late=[1, 0],
        )
        for frame in range(6):
            if frame == 5:
                before = grains.gather()
            grains.contact(200, where=column("late") <= float(frame > 4))
            grains.move()
            world.step()
        later = grains.gather()
    again = motes.World(seed=1, dt=1e-3, progress="off")
    alone = again.system("grains", attributes={"late": 1})
    with again:
        alone.emit(
            position=before.position,
            velocity=before.velocity,
            rotational_velocity=before.rotational_velocity,
            size=before.size,
            late=before.late,
        )
        alone.contact(200, where=column("late") == 1)
        alone.move()
        again.step()
        arrived = alone.gather()
    assert before.contacts[1] == later.contacts[0] == 1
    np.testing.assert_array_equal(later.velocity[0], arrived.velocity[0])
    assert later.velocity[0, 0] != 0


@pytest.mark.parametrize("skin", ["0.005", "0.3"])
def test_to_choose_all_changes_no_bit(skin: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("MOTES_SKIN", skin)
    rng = np.random.default_rng(6)
    start = {
        "position": rng.uniform(0, 0.6, (600, 3)),
        "velocity": rng.normal(0, 1, (600, 3)),
        "size": np.repeat(rng.uniform(0.03, 0.1, (600, 1)), 3, axis=1),
    }
    digests = []
    for where in (None, column("mass") > 0):
        periodic = {"x": (0, 0.6), "z": (0, 0.6)}
        with motes.World(seed=1, dt=0.02, substeps=20, periodic=periodic, progress="off") as world:
            grains = world.system("grains")
            grains.emit(**start)
            for _ in world.frames(5):
                grains.contact(2000, friction=0.6, rolling_friction=0.1, where=where)
                grains.move()
                world.step()
                digests.append(world.digest())
    assert digests[:5] == digests[5:]
    assert len(set(digests)) == 5
