"""contact(walls=...): forces at walls of any shape, memory of contacts, moving walls."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_meshes import block
from numpy.typing import NDArray
from standing import alike, assert_goes_on

import motes
from motes.errors import ArgumentError
from motes.expressions import column
from motes.shapes import (
    Blob,
    Box,
    Cone,
    Cylinder,
    Disc,
    Line,
    Mesh,
    Plane,
    Point,
    Rectangle,
    Shape,
    Sphere,
    Triangle,
    Union,
)

GROUND = Plane((0, 0, 0), (0, 1, 0))
RADIUS = 0.1


def rolling(
    walls: Any, state: dict[str, Any], *, frames: int, gravity: Any = (0, -9.81, 0), **contact: Any
) -> motes.Particles:
    """Run balls of 1 kg and 10 cm radius against walls, 200 sub-steps per 1/24 s; return the balls."""
    balls = len(state["position"])
    world = motes.World(seed=1, substeps=200, progress="off")
    system = world.system("balls")
    contact = {"stiffness": 1e4, "friction": 0.5, "radius": RADIUS} | contact
    with world:
        for frame in world.frames(frames):
            if frame == 0:
                system.emit(mass=np.ones(balls), **state)
            system.gravity(gravity)
            system.contact(walls=walls(frame) if callable(walls) else walls, **contact)
            system.move()
            world.step()
        return system.gather()


def moved(shape: Shape, x: float) -> Shape:
    """Shift a shape along x: all its vectors are positions, except those in `sizes`."""
    sizes = {"normal", "u", "v"}
    places = {
        name: (value[0] + x, *value[1:]) if isinstance(value, tuple) and name not in sizes else value
        for name, value in shape._items().items()
    }
    return type(shape)(**places)


GROUNDS = {
    "plane": GROUND,
    "plane upside down": Plane((0, 0, 0), (0, -1, 0)),
    "plane in a union": Sphere((5, 0, 0), 1) | GROUND,
    "rectangle": Rectangle((-1, 0, -1), (2, 0, 0), (0, 0, 2)),
    "triangle": Triangle((-2, 0, -2), (2, 0, -2), (0, 0, 3)),
    "disc": Disc((0, 0, 0), (0, 1, 0), 1),
    "on a box": Box((-1, -1, -1), (1, 0, 1)),
    "in a box": Box((-1, 0, -1), (1, 3, 1)),
    "on a cylinder": Cylinder((0, -2, 0), (0, 0, 0), 1),
    "in a cylinder": Cylinder((0, 3, 0), (0, 0, 0), 1),
    "in a lying pipe": Cylinder((0, 1, -1), (0, 1, 1), 1, 1),
    "in a bore": Cylinder((0, 1, -1), (0, 1, 1), 1.2, 1),
    "on a cone": Cone((0, -2, 0), (0, 0, 0), 1),
    "in a cone": Cone((0, 3, 0), (0, 0, 0), 3),
    "on a sphere": Sphere((0, -1, 0), 1),
    "in a sphere": Sphere((0, 2, 0), 2),
    "in a shell": Sphere((0, 2, 0), 3, 2),
}


def test_every_shape_carries_a_ball_by_its_spring():
    place = {name: 8.0 * k for k, name in enumerate(GROUNDS) if "plane" not in name}
    bodies = [moved(GROUNDS[name], x) for name, x in place.items()]
    start = {"position": [(x, 0.1, 0) for x in place.values()]}
    last = rolling(bodies, start, frames=20)
    for name, y in zip(place, last.position[:, 1], strict=True):
        assert y == pytest.approx(RADIUS - 9.81 / 1e4, abs=2e-5), name
    for name in set(GROUNDS) - set(place):
        last = rolling([GROUNDS[name]], {"position": [(0, 0.1, 0)]}, frames=20)
        assert last.position[0, 1] == pytest.approx(RADIUS - 9.81 / 1e4, abs=2e-5), name


def test_edges_and_corners_hold_too():
    """A corner pushes a ball straight away, whatever shape the corner belongs to."""
    corner = (-1, -1, -1), (0, 0, 0)
    way = np.array((1, 1, 1)) / math.sqrt(3)
    for box in (Box(*corner), Mesh(*block(*corner), resolution=64)):
        last = rolling(
            [box],
            {"position": [0.12 * way], "velocity": [-1 * way]},
            frames=2,
            gravity=(0, 0, 0),
            restitution=1,
        )
        tolerance = 0.02 if isinstance(box, Box) else 0.2  # the distance field's grid rounds corners off
        np.testing.assert_allclose(last.velocity[0], way, atol=tolerance)
    inside = rolling(
        [Box(*corner)],
        {"position": [(-0.12, -0.12, -0.12)], "velocity": [(1, 1, 1)]},
        frames=2,
        gravity=(0, 0, 0),
        restitution=1,
        friction=0,
    )
    np.testing.assert_allclose(inside.velocity[0], (-1, -1, -1), atol=0.02)  # hits three faces at once


@pytest.mark.parametrize("restitution", [0.1, 0.5, 1])
def test_head_on_a_wall(restitution: float):
    start = {"position": [(0, 0.2, 0)], "velocity": [(0, -2, 0)]}
    last = rolling([GROUND], start, frames=4, gravity=(0, 0, 0), restitution=restitution)
    assert last.velocity[0, 1] == pytest.approx(2 * restitution, abs=0.02)


@pytest.mark.parametrize("angle_deg", [20, 45, 60])
def test_oblique_impacts_slide_as_coulomb_says(angle_deg: float):
    """A ball that never rolls loses friction (1 + restitution) v_n; its spin is 5/2 of that per radius."""
    normal, along = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    start = {"position": [(0, 0.2, 0)], "velocity": [(along, -normal, 0)]}
    friction, restitution = 0.05, 0.8
    last = rolling([GROUND], start, frames=6, gravity=(0, 0, 0), friction=friction, restitution=restitution)
    lost = friction * (1 + restitution) * normal
    assert along - lost > 2.5 * lost  # it never rolls
    assert last.velocity[0, 0] == pytest.approx(along - lost, abs=0.005)
    assert last.rotational_velocity[0, 2] * RADIUS == pytest.approx(-2.5 * lost, abs=0.01)


@pytest.mark.parametrize(
    ("friction", "rolling_friction", "acceleration"),
    [
        (0.5, 0.5, 0),  # stays at rest: rolling_friction is above tan 20 degrees
        (0.5, 0, 5 / 7 * math.sin(math.radians(20))),  # rolls like a solid sphere
        (0, 0, math.sin(math.radians(20))),  # slips
        (0.12, 0, 5 / 7 * math.sin(math.radians(20))),  # rolls: friction is above 2/7 tan 20 degrees = 0.104
        (0.08, 0, math.sin(math.radians(20)) - 0.08 * math.cos(math.radians(20))),  # slips and rotates
    ],
)
def test_a_ball_on_a_slope(friction: float, rolling_friction: float, acceleration: float):
    """The slope is an oblique plane, or a rotated mesh."""
    a = math.radians(20)
    normal = np.array((math.sin(a), math.cos(a), 0))
    slopes = (
        Plane((0, 0, 0), tuple(normal)),
        Mesh(*block((-8, -1, -2), (8, 0, 2)), resolution=64).at((0, 0, 0), axis=(0, 0, 1), angle_deg=-20),
    )
    for slope in slopes:
        last = rolling(
            [slope],
            {"position": [0.0995 * normal]},
            frames=24,
            friction=friction,
            rolling_friction=rolling_friction,
            restitution=0.2,
        )
        way = float(last.position[0] @ (math.cos(a), -math.sin(a), 0))
        if acceleration == 0:
            assert abs(way) < 3e-3
        else:
            assert way == pytest.approx(0.5 * 9.81 * acceleration, rel=0.02)


def test_energy_at_a_wall_is_kept_without_friction_and_never_grows():
    start = {"position": [(0, 0.5, 0), (1, 0.5, 0)], "velocity": [(0.3, 0, 0)] * 2}
    height = 9.81 * 0.5 + 0.5 * 0.3**2

    def energy(p: motes.Particles) -> NDArray[np.float64]:
        v, y = p.velocity.astype(float), p.position[:, 1].astype(float)
        spring = 0.5 * 1e4 * np.maximum(RADIUS - y, 0) ** 2
        spin = 0.5 * 0.4 * RADIUS**2 * (p.rotational_velocity.astype(float) ** 2).sum(axis=1)
        return 0.5 * (v**2).sum(axis=1) + 9.81 * y + spring + spin

    smooth = energy(rolling([GROUND], start, frames=48, restitution=1, friction=0))
    rough = energy(rolling([GROUND], start, frames=48, restitution=1, friction=0.5))
    assert smooth == pytest.approx([height] * 2, rel=0.01)
    assert (rough < height).all() and (rough > 0.9 * height).all()


def test_a_belt_takes_its_load_along_and_a_turning_disc_spins_it():
    belt = Mesh(*block((-5, -1, -1), (5, 0, 1)), resolution=40)

    def running(frame: int) -> list[Shape]:  # at 2 m/s
        return [belt.at(((frame + 1) / 12, 0, 0), moving_from=belt.at((frame / 12, 0, 0)))]

    last = rolling(running, {"position": [(0, 0.099, 0)]}, frames=24, restitution=0.1)
    # The ball rolls on the belt: it moves at 2/7 of the belt's speed, and spins at the other 5/7.
    assert last.velocity[0, 0] == pytest.approx(2 * 2 / 7, rel=0.02)
    assert last.rotational_velocity[0, 2] * RADIUS == pytest.approx(2 * 5 / 7, rel=0.02)

    def turning(frame: int) -> list[Shape]:  # a quarter turn per second about the y axis
        return [belt.at(angle_deg=(frame + 1) * 90 / 24, moving_from=belt.at(angle_deg=frame * 90 / 24))]

    last = rolling(turning, {"position": [(0.5, 0.099, 0)]}, frames=12, rolling_friction=0.5, restitution=0.1)
    # The ball rests on the disc and goes around with it.
    spin = np.array((0, math.pi / 2, 0))
    np.testing.assert_allclose(last.velocity[0], np.cross(spin, last.position[0]) * (1, 0, 1), atol=0.02)


def test_who_turns_with_a_wall_is_not_braked_by_it():
    wheel = Mesh(*block((-2, -1, -1), (2, 0, 1)), resolution=40)
    omega = math.radians(9) * 24

    def turning(frame: int) -> list[Shape]:
        before = wheel.at(axis=(0, 0, 1), angle_deg=9 * frame)
        return [wheel.at(axis=(0, 0, 1), angle_deg=9 * (frame + 1), moving_from=before)]

    start = {
        "position": [(0, 0.0995, 0)],
        "velocity": [(-0.1 * omega, 0, 0)],
        "rotational_velocity": [(0, 0, omega)],
    }
    last = rolling(turning, start, frames=1, gravity=(0, 0, 0), rolling_friction=0.5)
    assert last.velocity[0, 1] > 0.005  # the wall has pushed it
    np.testing.assert_allclose(last.rotational_velocity[0], (0, 0, omega), rtol=0.01, atol=1e-3)


def test_a_wall_that_comes_pushes_at_its_speed():
    ram = Mesh(*block((-1, -1, -1), (0, 1, 1)), resolution=40)

    def coming(frame: int) -> list[Shape]:
        return [ram.at(((frame + 1) / 24, 0, 0), moving_from=ram.at((frame / 24, 0, 0)))]

    last = rolling(coming, {"position": [(0.15, 0, 0)]}, frames=6, gravity=(0, 0, 0), restitution=1)
    assert last.velocity[0, 0] == pytest.approx(2, rel=0.01)


HEAP = """
import numpy as np, motes
from motes.expressions import column
from motes.shapes import Box, Cone, Cylinder, Mesh, Plane, Sphere
rng = np.random.default_rng(2)
paddle = Mesh({corners}, {sides}, resolution=32)
world = motes.World(seed=1, substeps=12, progress="off", **{options})
grains = world.system("grains")
with world:
    size = rng.uniform(0.08, 0.16, 300)
    grains.emit(position=rng.uniform(-0.8, 0.8, (300, 3)), velocity=rng.uniform(-3, 3, (300, 3)),
                size=size[:, None] * (1, 1, 1), mass=size**3 * 1000)
    for frame in world.frames(12):
        walls = [Box((-1, -1, -1), (1, 1, 1)), Plane((0, -0.9, 0), (0.1, 1, 0)),
                 Sphere((0.5, 0, 0), 0.3) | Cone((0, 0.5, 0), (0, -0.5, 0), 0.3),
                 paddle.at(angle_deg=(frame + 1) * 9, moving_from=paddle.at(angle_deg=frame * 9))]
        grains.gravity((0, -9.81, 0))
        grains.contact(500, friction=0.6, rolling_friction=0.05, walls=walls)
        pipe = Cylinder((0, 0, -1), (0, 0, 1), 0.8, 0.8)
        grains.contact(100, radius=0.02, walls=pipe, where=column("mass") > 1)
        grains.move()
        world.step()
        digest = world.digest()
        if "manager" in world.role:
            print(digest, flush=True)
"""


def test_walls_give_the_same_bits_on_any_ranks_and_threads():
    corners, sides = (array.tolist() for array in block((-0.9, -0.1, -0.1), (0.9, 0.1, 0.1)))
    script = HEAP.replace("{corners}", str(corners)).replace("{sides}", str(sides))
    lines = alike(script.replace("{options}", "{}"), ranks=(1, 2, 4))
    assert len(set(lines)) == 12
    assert alike(script.replace("{options}", "{'threads': 3}"), ranks=(1,)) == lines


SLOPE = """
import math, os, sys, motes
from motes.shapes import Plane
world = motes.World(seed=1, substeps=50, progress="off", checkpoint=motes.Checkpoint(sys.argv[1], every=2))
balls = world.system("balls")
with world:
    for frame in world.frames(8):
        if frame == int(os.environ.get("KILL", -1)):
            os._exit(9)
        if frame == 0:
            balls.emit(position=[(0, 0.12, 0), (0.15, 0.1, 0)], size=[(0.2, 1, 1)] * 2)
        balls.gravity((0, -9.81, 0))
        balls.contact(1e4, friction=0.9, rolling_friction=0.2, walls=Plane((0, 0, 0), (0.3, 1, 0)))
        balls.move()
        world.step()
    digest = world.digest()
    if "manager" in world.role:
        print("digest", digest)
"""


def test_a_run_goes_on_with_what_grains_remember_of_walls(tmp_path: Path):
    assert_goes_on(SLOPE, tmp_path)


def test_walls_hold_those_that_are_chosen():
    start = {"position": [(0, 0.2, 0), (1, 0.2, 0)]}
    last = rolling([GROUND], start, frames=20, where=column("position").x > 0.5)
    assert last.position[0, 1] < -1
    assert last.position[1, 1] == pytest.approx(RADIUS, abs=2e-3)


def test_who_is_not_chosen_remembers_no_wall():
    """A ball that slid along a wall before it was chosen behaves like one that has just arrived."""
    start = {"position": [(0, 0.099, 0), (0, 0.2, -1)], "velocity": [(0.1, 0, 0), (0, 0, 0)]}
    free = {"gravity": (0, 0, 0), "frames": 2}
    # The first ball is chosen from its second frame on, the second ball always.
    chosen = column("age") - column("position").z > 1 / 24 - 1e-4
    later = rolling([GROUND], start, where=chosen, **free)
    comes = rolling(lambda frame: [GROUND if frame > 0 else Plane((0, -9, 0), (0, 1, 0))], start, **free)
    assert later.velocity[0, 0] < 0.09  # friction has slowed it
    np.testing.assert_array_equal(later.velocity, comes.velocity)


@pytest.mark.parametrize("wrong", [Point((0, 0, 0)), Line((0, 0, 0), (1, 0, 0)), Blob((0, 0, 0), 1)])
def test_walls_without_a_surface_are_refused(wrong: Shape):
    for walls in ([wrong], [GROUND, Union(Sphere((0, 0, 0), 1), wrong)]):
        with pytest.raises(ArgumentError, match=r"walls.* have surfaces"):
            motes.actions.Contact(stiffness=1, walls=walls)


@pytest.mark.parametrize("wrong", [1, [1], [(0, 0, 0)], "floor"])
def test_walls_that_are_no_shapes_are_refused(wrong: Any):
    with pytest.raises(ArgumentError, match="walls"):
        motes.actions.Contact(stiffness=1, walls=wrong)
