"""contact(other=...): grains of two systems, spheres and clumps, touch as those of one do."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from standing import alike

import motes
from motes.errors import ArgumentError
from motes.expressions import column

BED = """
import numpy as np
import motes
from motes.expressions import column
from motes.shapes import Plane, Sphere

axes, periodic, shared = {0!r}, {1!r}, {2!r}
rng = np.random.default_rng(5)
places = np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), -1).reshape(-1, 3) * 0.24 - 0.36
world = motes.World(
    seed=1, dt=0.02, substeps=25, progress="off", roles="shared", space=(-0.6, 0.6), periodic=periodic,
    balancer=motes.balance.PrefixCuts(), combine="one_by_one",
)
first = world.system("first", axis=axes)
second, third = (
    world.system(name, domains_of=first) if shared else world.system(name, axis="y")
    for name in ("second", "third")
)
first.clumps([(0, 0, 0, 0.06), (0.08, 0, 0, 0.05), (0.02, 0.07, 0, 0.05)], density=1000)
second.clumps([(-0.05, 0, 0, 0.06), (0.05, 0, 0, 0.06)], density=2000)
third.configure(size=motes.Uniform(0.08, 0.14), mass=motes.Uniform(0.5, 2))
slope, bowl = Plane((0, -0.5, 0), (0.1, 1, 0)), Sphere((0, 0, 0), 0.65)
with world:
    for frame in world.frames(6):
        for number, system in enumerate(world.systems):
            if frame == 0:
                own = places[number::3]
                turned = rng.normal(size=(len(own), 4)).round(3)
                spun = dict(orientation=turned) if system is not third else dict()
                system.emit(position=own, velocity=rng.uniform(-1, 1, own.shape), **spun)
            if frame == 3:
                system.source(Sphere((0, 0.4, 0), 0.05), rate=100)
            system.gravity((0.0, -9.81, 0.0))
            slippery = motes.Wall(friction=0.1 * number, stiffness=1500)
            system.contact(2000, friction=0.6, rolling_friction=0.05, walls=[(slope, slippery), bowl])
        first.contact(2200, friction=0.3, other=second)
        third.contact(1800, restitution=0.2, rolling_friction=0.1, other=first)
        second.contact(2500, other=third, where=column("position").x > -0.3)
        for system in world.systems:
            if frame == 4:
                system.sink(Sphere((0.3, -0.3, 0), 0.15))
            system.move()
        world.step()
        digest = world.digest()
        pressed = [*world.force(slope), *world.force(bowl)]
        if "manager" in world.role:
            print(digest, *(numbers.tolist() for numbers in pressed), flush=True)
    touching = [system.total(column("contacts")) for system in world.systems]
    if "manager" in world.role:
        print(min(touching) > 0 and sum(touching) > 15, all(numbers.any() for numbers in pressed))
"""
SPACES = [
    ("x", None, True),
    ("xz", {"x": (-0.6, 0.6), "z": (-0.6, 0.6)}, False),
    pytest.param("hilbert", None, False, marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("axes", "periodic", "shared"), SPACES)
def test_systems_touch_alike_on_any_ranks(axes: str, periodic: Any, shared: bool):
    lines = alike(BED.format(axes, periodic, shared), ranks=(1, 2, 3, 5))
    assert len(set(lines)) == 7
    assert lines[-1] == "True True"


def crystal(parts: int, template: Any) -> NDArray[Any]:
    """Let 64 grains of a lattice press each other, in one system or in two by turns; return their state."""
    rng = np.random.default_rng(2)
    cells = np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), -1).reshape(-1, 3)
    places = cells * 0.2 + rng.uniform(-0.005, 0.005, cells.shape)
    speed, spin = rng.uniform(-0.5, 0.5, cells.shape), rng.uniform(-9, 9, cells.shape)
    world = motes.World(seed=1, dt=0.02, substeps=40, progress="off")
    systems = [world.system(f"part {part}") for part in range(parts)]
    part_of = cells.sum(axis=1) % parts
    turns = "rotational_velocity" if template is None else "spin"
    with world:
        for frame in world.frames(3):
            for part, system in enumerate(systems if frame == 0 else ()):
                if template is not None:
                    system.clumps(template, density=500)
                else:
                    system.configure(size=0.2, mass=2)
                own = part_of == part
                system.emit(position=places[own], velocity=speed[own], **{turns: spin[own]})
            law = {"restitution": 0.4, "friction": 0.5, "rolling_friction": 0.05}
            systems[0].contact(3000, **law, other=systems[1] if parts == 2 else None)
            for system in systems:
                system.move()
            world.step()
        found = np.zeros((64, 10), np.float32)
        for part, system in enumerate(systems):
            p = system.gather()
            found[part_of == part] = np.column_stack([p.position, p.velocity, getattr(p, turns), p.contacts])
    return found


@pytest.mark.parametrize("template", [None, [(0, 0, 0, 0.1)], [(0, 0, 0, 0.1), (0.01, 0.005, 0, 0.09)]])
def test_two_systems_move_to_the_last_bit_as_one(template: Any):
    """Neighbours in the lattice are in different systems, so no grain touches one of its own."""
    whole = crystal(1, template)
    assert whole[:, 9].sum() > 64
    np.testing.assert_array_equal(crystal(2, template), whole)


def test_forces_on_both_systems_are_opposite_to_the_last_bit():
    """The masses are powers of two, so momentum is exact: what one system gains the other loses."""
    world = motes.World(seed=1, dt=0.01, substeps=20, progress="off")
    light, heavy = world.system("light"), world.system("heavy")
    starts = np.array([(0, 4.0 * k, 0.0) for k in range(50)])
    rng = np.random.default_rng(1)
    with world:
        for frame in world.frames(10):
            if frame == 0:
                at = starts + rng.uniform(-0.3, 0.3, starts.shape)
                light.emit(
                    position=at, mass=np.full(50, 0.5), rotational_velocity=rng.uniform(-9, 9, (50, 3))
                )
                spins = rng.uniform(-9, 9, (50, 3))
                heavy.emit(position=at + (1.05, 0, 0), mass=np.full(50, 4.0), rotational_velocity=spins)
                light.set(velocity=(1.0, 0.0, 0.0))
            light.contact(5000, friction=0.5, rolling_friction=0.1, other=heavy)
            for system in (light, heavy):
                system.move()
            world.step()
            one, other = light.gather(), heavy.gather()
            if frame == 0:
                first = one.velocity.astype(float) * 0.5 + other.velocity.astype(float) * 4
            now = one.velocity.astype(float) * 0.5 + other.velocity.astype(float) * 4
            # Adding a push to a velocity rounds; the pushes themselves are opposite.
            np.testing.assert_allclose(now, first, atol=3e-6)
    assert (one.velocity[:, 0] < 0.9).all()


def test_a_first_push_is_opposite_to_the_last_bit():
    for template in (None, [(0, 0, 0, 0.5)]):
        world = motes.World(seed=1, dt=2**-10, progress="off")
        one, other = world.system("one"), world.system("other")
        if template is not None:
            other.clumps(template)
        rng = np.random.default_rng(3)
        way = rng.normal(size=(200, 3))
        way /= np.linalg.norm(way, axis=1)[:, None]
        middle = np.array([(0, 4.0 * k, 0.0) for k in range(200)])
        with world:
            one.emit(position=middle, mass=np.full(200, 2.0))
            other.emit(position=middle + way * rng.uniform(0.1, 0.999, (200, 1)), mass=np.full(200, 0.25))
            one.contact(3000, friction=0.5, other=other)
            world.step()
            a, b = one.gather(), other.gather()
        assert (np.abs(a.velocity).max(axis=1) > 0).all()
        np.testing.assert_array_equal(a.velocity * np.float32(2), -b.velocity * np.float32(0.25))
        assert (a.contacts == 1).all() and (b.contacts == 1).all()


def test_grains_at_one_place_part_in_opposite_directions():
    world = motes.World(seed=1, dt=0.01, progress="off")
    one, other = world.system("one"), world.system("other")
    with world:
        for system in (one, other):
            system.emit(position=[(k, 0, 0) for k in range(0, 30, 3)])
        one.contact(100, other=other)
        world.step()
        a, b = one.gather().velocity, other.gather().velocity
    np.testing.assert_array_equal(a, -b)
    assert (np.abs(a).max(axis=1) > 0).all()


def balance_of(p: motes.Particles, template: Any, back: float) -> tuple[NDArray[Any], NDArray[Any], float]:
    """Return momentum, angular momentum about the origin, and energy; spins lag by `back` s."""
    v, w, mass = p.velocity.astype(float), p.spin.astype(float), p.mass.astype(float)[:, None]
    x, y, z, s = p.orientation.astype(float).T
    axes = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * s), 2 * (x * z + y * s)],
            [2 * (x * y + z * s), 1 - 2 * (x * x + z * z), 2 * (y * z - x * s)],
            [2 * (x * z - y * s), 2 * (y * z + x * s), 1 - 2 * (x * x + y * y)],
        ]
    ).transpose(2, 0, 1)
    axes = np.linalg.qr((np.eye(3) - np.cross(np.eye(3)[None], back * w[:, None, :])) @ axes)[0]
    own = np.einsum("nij,nj->ni", mass[:, :, None] * (axes @ template.inertia @ axes.transpose(0, 2, 1)), w)
    turning = (np.cross(p.position, mass * v) + own).sum(axis=0)
    return (mass * v).sum(axis=0), turning, float(0.5 * (mass * v * v).sum() + 0.5 * (w * own).sum())


@pytest.mark.parametrize("restitution", [1, 0.4])
def test_clumps_of_two_templates_keep_momentum_and_lose_no_angular_momentum(restitution: float):
    world = motes.World(seed=1, dt=0.01, substeps=60, progress="off")
    long, wide = world.system("long"), world.system("wide")
    templates = (
        long.clumps([(-0.5, 0, 0, 0.25), (0.5, 0, 0, 0.25)], density=10),
        wide.clumps([(0, 0, 0, 0.3), (0.4, 0, 0, 0.2), (0, 0.4, 0, 0.2)], density=20),
    )

    def sums() -> list[Any]:
        both = [
            balance_of(s.gather(), t, 0.5 * world.dt / 60)
            for s, t in zip((long, wide), templates, strict=True)
        ]
        return [a + b for a, b in zip(*both, strict=True)]

    with world:
        for frame in world.frames(70):
            if frame == 0:
                long.emit(position=[(0, 0, 0)], velocity=[(0, 2, 0)], spin=[(0, 1, 2)])
                wide.emit(position=[(0.3, 1.2, 0.1)], velocity=[(0, -2, 0)], orientation=[(0, 0.3, 0.6, 0.7)])
            long.contact(3000, restitution=restitution, friction=0 if restitution == 1 else 0.5, other=wide)
            for system in (long, wide):
                system.move()
            world.step()
            if frame == 0:
                before = sums()
        after = sums()
        assert long.gather().velocity[0, 1] < 1.5  # they have collided
    np.testing.assert_allclose(after[0], before[0], atol=1e-4)
    np.testing.assert_allclose(after[1], before[1], atol=1e-3 * np.linalg.norm(before[1]))
    if restitution == 1:
        assert after[2] == pytest.approx(before[2], rel=0.02)
    else:
        assert after[2] < before[2]


def test_each_pair_of_systems_has_its_own_restitution():
    world = motes.World(seed=1, dt=0.02, substeps=200, progress="off")
    a, b = world.system("a"), world.system("b")
    with world:
        for frame in world.frames(10):
            if frame == 0:
                a.emit(
                    position=[(-0.6, 0, 0), (0.6, 0, 0), (-0.6, 9, 0)],
                    velocity=[(5, 0, 0), (-5, 0, 0), (5, 0, 0)],
                )
                b.emit(position=[(0.6, 9, 0)], velocity=[(-5, 0, 0)])
            a.contact(1e5, restitution=0.2)
            a.contact(1e5, restitution=0.8, other=b)
            for system in (a, b):
                system.move()
            world.step()
        v = a.gather().velocity[:, 0]
    np.testing.assert_allclose(v, [-1, 1, -4], atol=0.05)


def test_contacts_of_all_calls_in_a_substep_add_up():
    world = motes.World(seed=1, dt=0.001, substeps=3, progress="off")
    a, b = world.system("a"), world.system("b")
    with world:
        for _ in world.frames(2):
            if world.frame == 0:
                a.emit(position=[(0, 0, 0), (0.9, 0, 0)])
                b.emit(position=[(0, 0.9, 0), (0, -0.9, 0), (5, 0, 0)])
            a.contact(10)
            a.contact(10, other=b)
            world.step()
            assert a.gather().contacts.tolist() == [3, 1]
            assert b.gather().contacts.tolist() == [1, 1, 0]


def test_contacts_of_calls_for_some_add_up():
    """Those whom an earlier call of the sub-step did not choose begin anew."""
    world = motes.World(seed=1, dt=0.001, substeps=2, progress="off")
    a, b = world.system("a"), world.system("b")
    with world:
        a.emit(position=[(0, 0, 0), (0.9, 0, 0)])
        b.emit(position=[(0, 0.9, 0), (0, -0.9, 0), (5, 0, 0)])
        for _ in range(2):
            a.contact(10, where=column("position").x < 0.5)
            a.contact(10, other=b)
            world.step()
            assert a.gather().contacts.tolist() == [3, 0]
            assert b.gather().contacts.tolist() == [1, 1, 0]


def test_where_selects_which_grains_of_the_caller_change():
    world = motes.World(seed=1, dt=0.001, progress="off")
    a, b = world.system("a"), world.system("b")
    with world:
        a.emit(position=[(0, 0, 0), (9, 0, 0)])
        b.emit(position=[(0.9, 0, 0), (9.9, 0, 0)])
        a.contact(10, other=b, where=column("position").x < 5)
        world.step()
        assert (a.gather().velocity[:, 0] < 0).tolist() == [True, False]
        assert (b.gather().velocity[:, 0] > 0).all()


def test_radii_of_both_systems_can_be_given():
    world = motes.World(seed=1, dt=0.001, progress="off")
    a, b = world.system("a"), world.system("b")
    a.configure(size=0.5)
    with world:
        a.emit(position=[(0, 0, 0), (9, 0, 0)])
        b.emit(position=[(0.6, 0, 0), (9.3, 0, 0)])
        for own, its, touches in (
            (0.1, 0.1, [0, 0]),
            (0.1, 0.25, [0, 1]),
            (0.3, 0.31, [1, 1]),
            (None, 0.1, [0, 1]),
        ):
            a.contact(10, radius=own, other=b, other_radius=its)
            world.step()
            assert a.gather().contacts.tolist() == touches
            assert b.gather().contacts.tolist() == touches


def test_what_contact_between_systems_cannot_do_is_refused():
    world, elsewhere = motes.World(progress="off"), motes.World(progress="off")
    a, b, c = world.system("a"), world.system("b"), elsewhere.system("c")
    b.clumps([(0, 0, 0, 0.1)])
    with world:
        for other in (a, c, "b", 1, world):
            with pytest.raises(ArgumentError, match="other"):
                a.contact(10, other=other)
        with pytest.raises(ArgumentError, match="other_radius"):
            a.contact(10, other_radius=0.1)
        for wrong in (0, -1, "1", float("nan")):
            with pytest.raises(ArgumentError, match="other_radius"):
                a.contact(10, other=b, other_radius=wrong)
        with pytest.raises(ArgumentError, match="other_radius.*clumps"):
            a.contact(10, other=b, other_radius=0.1)
        with pytest.raises(ArgumentError, match="radius.*clumps"):
            b.contact(10, other=a, radius=0.1)
        assert a.recorded == b.recorded == []
        a.contact(10, other=b)
        assert a.recorded == b.recorded
        world.step()
    near = motes.World(progress="off", periodic={"x": (0, 1)})
    a, b = near.system("a"), near.system("b")
    with near, pytest.raises(ArgumentError, match="radius"):
        a.contact(10, radius=0.3, other=b, other_radius=0.21)


def test_a_second_contact_does_not_turn_a_clump_again():
    """A rotation about the intermediate axis flips over and over, however many contacts a sub-step has."""
    brick = [(x, y, z, 0.3) for x in (-0.6, 0, 0.6) for y in (-0.25, 0.25) for z in (-0.1, 0.1)]
    found = []
    for others in range(3):
        world = motes.World(seed=1, dt=0.02, substeps=10, progress="off")
        s = world.system("s")
        rest = [world.system(f"other {number}") for number in range(others)]
        s.clumps(brick, density=10)
        ways = []
        with world:
            for frame in world.frames(200):
                if frame == 0:
                    s.emit(position=[(0, 0, 0)], spin=[(0.2, 4, 0.1)])
                    for other in rest:
                        other.emit(position=[(9, 9, 9)])
                s.contact(1000)
                for other in rest:
                    s.contact(1000, other=other)
                s.move()
                world.step()
                ways.append(s.gather().orientation[0])
        found.append(np.array(ways))
    turned = 1 - 2 * (found[0][:, 0] ** 2 + found[0][:, 2] ** 2)  # the y axis, along y
    assert turned.min() < -0.9
    for other in found[1:]:
        np.testing.assert_allclose(other, found[0], atol=2e-3)
