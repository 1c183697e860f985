"""Contacts have no scale of their own: in other units of length, mass and time they have the scaled bits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from made_meshes import block
from numpy.typing import NDArray

import motes
from motes.errors import ArgumentError
from motes.shapes import Box, Cone, Cylinder, Disc, Mesh, Plane, Rectangle, Sphere, Triangle

G = 9.81
CLUMP = [(0, 0, 0, 0.06), (0.08, 0, 0, 0.05), (0.02, 0.07, 0, 0.05)]


class Units:
    """Powers of two by which lengths, masses and times of a scene are multiplied."""

    def __init__(self, length: int, mass: int, time: int) -> None:
        self.m, self.kg, self.s = 2.0**length, 2.0**mass, 2.0**time
        self.newton = self.m * self.kg / self.s**2


def heap(units: Units, flat: bool = True) -> list[NDArray[Any]]:
    """Let spheres and clumps fall on walls of all kinds; return their state and forces in scene units.

    `flat`: also on rectangles and triangles, which cannot be smaller than a micrometre.
    """
    m, kg, s = units.m, units.kg, units.s
    rng = np.random.default_rng(5)
    places = np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), -1).reshape(-1, 3) * 0.17 - 0.25
    speeds, spins = rng.uniform(-1, 1, places.shape), rng.uniform(-5, 5, places.shape)
    world = motes.World(seed=1, dt=0.02 * s, substeps=25, progress="off")
    balls, clumps = world.system("balls"), world.system("clumps")
    clumps.clumps(np.array(CLUMP) * m)

    def at(*point: float) -> tuple[float, ...]:
        return tuple(x * m for x in point)

    slab = np.array(block((-1, -0.7, -1), (1, -0.4, 1))[0]) * m
    stiff = 2000 * kg / s**2
    rough = motes.Wall(friction=0.9, stiffness=2 * stiff, rolling_friction=0.1)
    mesh = Mesh(slab, block((0, 0, 0), (1, 1, 1))[1], resolution=32)
    walls = [
        (mesh.at(at(0, 0, 0), moving_from=mesh.at(at(0.02, 0, 0))), rough),
        Sphere(at(0, 0, 0), 0.6 * m),
        Box(at(-0.55, -0.7, -0.55), at(0.55, 0.7, 0.55)),
        Plane(at(0, -0.45, 0), (0.2, 1, 0)),
        Cylinder(at(0, -0.4, -1), at(0, -0.4, 1), 0.2 * m),
        Cone(at(0.1, -0.3, 0), at(0.1, -0.9, 0), 0.3 * m),
        Disc(at(-0.2, -0.4, -0.2), (0, 1, 0.3), 0.2 * m),
    ]
    if flat:
        walls += [
            Rectangle(at(0.2, -0.35, 0.1), at(0.2, 0, 0), at(0, 0, 0.2)),
            Triangle(at(-0.4, -0.3, 0.1), at(-0.1, -0.35, 0.1), at(-0.2, -0.3, 0.4)),
        ]
    with world:
        for frame in world.frames(5):
            if frame == 0:
                own = {
                    "mass": rng.uniform(0.5, 2, 32) * kg,
                    "size": rng.uniform(0.1, 0.16, (32, 1)) * m * (1, 1, 1),
                }
                at_rest = {"velocity": speeds[::2] * m / s, "rotational_velocity": spins[::2] / s}
                balls.emit(position=places[::2] * m, **own, **at_rest)
                moving = {"velocity": speeds[1::2] * m / s, "spin": spins[1::2] / s}
                clumps.emit(position=places[1::2] * m, mass=np.full(32, 1.5) * kg, **moving)
            for system in (balls, clumps):
                system.gravity((0, -G * m / s**2, 0))
                system.contact(stiff, friction=0.5, rolling_friction=0.05, walls=walls)
            balls.contact(1.5 * stiff, restitution=0.3, friction=0.4, other=clumps)
            for system in (balls, clumps):
                system.move()
            world.step()
        found = []
        for system, turns in ((balls, "rotational_velocity"), (clumps, "spin")):
            p = system.gather()
            assert (p.contacts > 0).sum() > 10
            found += [p.position / m, p.velocity / (m / s), getattr(p, turns) * s, p.orientation, p.contacts]
        forces = [
            world.force(wall if isinstance(wall, motes.shapes.Shape) else wall[0]) for wall in walls[:7]
        ]
        assert forces[0].force.any() and sum(bool(force.force.any()) for force in forces) >= 5
        pressed = [force.force / units.newton for force in forces]
        pressed += [force.torque / (units.newton * m) for force in forces]
        found += pressed if units.m > 1e-6 else [np.float32(numbers) for numbers in pressed]
    return found


PLAIN = {flat: heap(Units(0, 0, 0), flat) for flat in (False, True)}


@pytest.mark.parametrize(
    ("length", "mass", "time"),
    [
        (-27, -78, -12),  # grains of a nanometre
        (-27, -78, -9),
        (23, 69, 10),  # of a thousand kilometres
        (23, 69, -2),
        (0, -80, 0),
        (0, 70, 0),
        (-17, -50, -10),  # powder
        (5, -20, 3),
    ],
)
def test_a_scene_in_other_units_has_the_scaled_bits(length: int, mass: int, time: int):
    flat = length > -20
    for one, other in zip(heap(Units(length, mass, time), flat), PLAIN[flat], strict=True):
        # The forces of a nanometre's grains reach the end of float32's range, and lose bits there.
        if one.dtype != other.dtype:
            np.testing.assert_allclose(one, other, rtol=1e-5, atol=1e-5)
        else:
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("wall", [False, True])
@pytest.mark.parametrize("diameter", [1e-9, 1e-6, 5e-6, 8e-6, 1e-4, 1.0, 1e3, 1e6])
def test_grains_of_any_size_rebound(wall: bool, diameter: float):
    mass, speed = 2500 * np.pi / 6 * diameter**3, 1e-3 * diameter
    stiffness = mass * np.pi**2 / 2  # they touch for a second
    world = motes.World(seed=1, dt=1, substeps=50, progress="off")
    powder = world.system("powder")
    ways = np.array([(1.0, 0, 0)] if wall else [(-1.0, 0, 0), (1.0, 0, 0)])
    with world:
        for frame in world.frames(8):
            if frame == 0:
                at = ways * (0.5 * diameter + 0.5 * speed)
                powder.emit(
                    position=at,
                    velocity=-speed * ways,
                    size=np.full(at.shape, diameter),
                    mass=np.full(len(at), mass),
                )
            powder.contact(
                stiffness, restitution=0.5, friction=0, walls=[Plane((0, 0, 0), (1, 0, 0))] if wall else ()
            )
            powder.move()
            world.step()
        p = powder.gather()
    np.testing.assert_allclose(p.velocity[:, 0] / speed, 0.5 * ways[:, 0], atol=0.02)


@pytest.mark.parametrize("mass", [0, -1])
def test_grains_without_a_positive_mass_touch_nothing(mass: float):
    world = motes.World(seed=1, dt=0.001, progress="off")
    system = world.system("s")
    with world:
        system.emit(position=[(0, 0, 0), (0.5, 0, 0)], mass=np.array([1, mass]))
        system.contact(100, walls=[Plane((0, 0.1, 0), (0, 1, 0))])
        world.step()
        p = system.gather()
    assert p.contacts.tolist() == [0, 0]
    assert p.velocity[0, 0] == 0 and p.velocity[1].tolist() == [0, 0, 0]
    assert abs(p.velocity[0, 1]) > 0


def test_what_no_scale_needs_is_refused():
    world = motes.World(progress="off")
    system = world.system("s")
    for stiffness in (0, 1e-31, 1e31, float("inf")):
        with pytest.raises(ArgumentError, match="stiffness"):
            motes.actions.Contact(stiffness=stiffness)
    for density in (1e-40, 1e38):
        with pytest.raises(ArgumentError, match="density"):
            system.clumps([(0, 0, 0, 0.1)], density=density)
    with pytest.raises(ArgumentError, match="template"):
        system.clumps([(0, 0, 0, 1e-13)])


@pytest.mark.parametrize("restitution", [1, 0.5])
@pytest.mark.parametrize("speed", [0.02, 0.1, 0.2, 0.5, 1, 2])  # diameters per sub-step
def test_fast_grains_gain_no_energy(speed: float, restitution: float):
    """Pairs that move far in a sub-step rebound or pass; springs would shoot them apart."""
    rng = np.random.default_rng(1)
    world = motes.World(seed=1, dt=40, substeps=40, progress="off")
    s = world.system("s")
    rows = 40.0 * np.arange(100)
    start, aside = 0.5 + rng.uniform(0.01, 1, 100) * speed, rng.uniform(0, 0.9, 100)
    places = [np.stack([-start, rows, 0 * rows], 1), np.stack([start, rows + aside, 0 * rows], 1)]
    with world:
        for frame in world.frames(2):
            if frame == 0:
                ways = np.repeat([(0.5 * speed, 0, 0), (-0.5 * speed, 0, 0)], 100, axis=0)
                s.emit(position=np.concatenate(places), velocity=ways)
            s.contact(0.5 * (np.pi / 5.1) ** 2, restitution=restitution, friction=0)
            s.move()
            world.step()
        kept = float((s.gather().velocity.astype(float) ** 2).sum() / (200 * (0.5 * speed) ** 2))
    if restitution < 1:
        assert kept < 0.9
    else:
        assert kept == pytest.approx(1, abs=1e-5 if speed >= 0.2 else 0.006)
