"""World.force: the forces of grains on walls, and their torques; coefficients of each wall."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_meshes import block
from standing import alike, on_ranks

import motes
from motes.errors import ArgumentError, MotesError
from motes.expressions import column
from motes.shapes import Blob, Box, Cylinder, Mesh, Plane, Sphere

G = 9.81
FLOOR = Plane((0, 0, 0), (0, 1, 0))


def settled(
    walls: Any, *, grains: int = 60, frames: int = 120, seed: int = 1
) -> tuple[motes.World, motes.System]:
    """Let grains fall into a vessel of 1 m x 1 m until they rest; return the open world and the system."""
    rng = np.random.default_rng(seed)
    world = motes.World(seed=1, dt=0.05, substeps=100, progress="off").open()
    system = world.system("bed")
    x, y, z = (g.ravel()[:grains] for g in np.mgrid[:4, :8, :4])
    for frame in world.frames(frames):
        if frame == 0:
            at = np.stack([x, y, z], axis=1) * 0.24 + 0.13 + rng.uniform(-0.005, 0.005, (len(x), 3))
            system.emit(position=at, size=rng.uniform(0.16, 0.2, (len(x), 1)) * (1, 1, 1))
        system.gravity((0, -G, 0))
        system.contact(20000, restitution=0.1, friction=0.5, rolling_friction=0.2, walls=walls)
        system.move()
        world.step()
    return world, system


def test_the_floor_carries_the_weight_of_a_bed_and_the_sides_balance():
    sides = [
        Plane((0, 0, 0), (1, 0, 0)),
        Plane((1, 0, 0), (-1, 0, 0)),
        Plane((0, 0, 0), (0, 0, 1)),
        Plane((0, 0, 1), (0, 0, -1)),
    ]
    world, bed = settled([FLOOR, *((side, motes.Wall(friction=0, rolling_friction=0)) for side in sides)])
    weight = G * float(bed.total(column("mass")))
    floor = world.force(FLOOR)
    assert floor.force[1] == pytest.approx(-weight, rel=1e-3)
    pressed = np.array([world.force(side).force for side in sides])
    assert pressed[0, 0] < -1 and pressed[1, 0] > 1 and pressed[2, 2] < -1 and pressed[3, 2] > 1
    np.testing.assert_allclose(pressed.sum(axis=0) + floor.force, (0, -weight, 0), atol=2e-3 * weight)
    np.testing.assert_allclose(pressed[:, 1], 0, atol=1e-6 * weight)  # frictionless
    # The weight acts at the centre of mass; torques are about each plane's point.
    p = bed.gather()
    middle = (p.position * p.mass[:, None]).sum(axis=0) / p.mass.sum()
    torque = sum(
        world.force(side).torque + np.cross(side.point, force)
        for side, force in zip(sides, pressed, strict=True)
    )
    wanted = np.cross(middle, (0, -weight, 0))
    np.testing.assert_allclose(torque + floor.torque, wanted, atol=3e-3 * weight)
    world.close()


def test_rough_sides_carry_a_part_of_the_bed_as_janssen_says():
    vessel = [Plane((0, 0, 0), (1, 0, 0)), Plane((1, 0, 0), (-1, 0, 0))]
    rough = [(side, motes.Wall(friction=1)) for side in vessel]
    ends = [(Plane((0, 0, z), (0, 0, 1)), motes.Wall(friction=0, rolling_friction=0)) for z in (0, 1)]
    world, bed = settled([(FLOOR, motes.Wall(friction=0.1)), *rough, *ends], grains=96)
    weight = G * float(bed.total(column("mass")))
    carried = -sum(world.force(side).force[1] for side in vessel)
    assert carried > 0.02 * weight
    assert carried - world.force(FLOOR).force[1] == pytest.approx(weight, rel=5e-3)
    world.close()


def test_a_sphere_that_hangs_in_a_pipe_presses_both_sides():
    """Frictionless, in a V of two planes: each carries weight / (2 sin(45 deg)) along its normal."""
    world = motes.World(seed=1, dt=0.05, substeps=200, progress="off")
    ball = world.system("ball")
    planes = [Plane((0, 0, 0), (1, 1, 0)), Plane((0, 0, 0), (-1, 1, 0))]
    with world:
        for frame in world.frames(60):
            if frame == 0:
                ball.emit(position=[(0, 0.5 * 2**0.5, 0)], mass=[2.0])
            ball.gravity((0, -G, 0))
            ball.contact(1e4, restitution=0.1, friction=0, walls=planes)
            ball.move()
            world.step()
        for plane, x in zip(planes, (-1, 1), strict=True):
            force, torque = world.force(plane)
            np.testing.assert_allclose(force, (x * G, -G, 0), atol=2e-3 * G)
            np.testing.assert_allclose(torque, np.cross(ball.gather().position[0], force), atol=1e-3)


@pytest.mark.parametrize("kind", ["vessel", "drum", "union"])
def test_forces_and_torques_are_opposite_to_what_grains_gain(kind: str):
    """Grains that slide and roll at their walls: Newton's third law for forces and torques, step by step."""
    center = np.array((0.3, -0.2, 0.1))
    cube = Mesh(*block((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)), resolution=64)
    world = motes.World(seed=1, dt=0.001, progress="off")
    system = world.system("grains")
    rng = np.random.default_rng(1)
    pressed = 0
    with world:
        for frame in world.frames(120):
            if frame == 0:
                at, size = center + rng.uniform(-0.35, 0.35, (40, 3)), np.full((40, 3), 0.2)
                speed, spin = rng.uniform(-6, 6, (40, 3)), rng.uniform(-20, 20, (40, 3))
                system.emit(position=at, velocity=speed, rotational_velocity=spin, size=size)
                system.move()
                world.step()
                continue
            wall, origin = Cylinder(tuple(center), tuple(center + (0, 0, 0.5)), 0.55), center
            if kind == "drum":
                there = center + (0.002 * frame, 0, 0)
                before = cube.at(there, axis=(0, 0, 1), angle_deg=2 * frame)
                turned = {"axis": (0, 0, 1), "angle_deg": 2 * frame + 2}
                wall, origin = cube.at(there + (0.002, 0, 0), **turned, moving_from=before), there
            if kind == "union":
                wall = Sphere(tuple(center), 0.6) | Plane((0.7, 0, 0), (1, 0, 0))
            then = system.gather()
            system.contact(3000, friction=0.5, rolling_friction=0.2, walls=[(wall, motes.Wall(friction=0.9))])
            system.move()
            world.step()
            now = system.gather()
            gained = (now.velocity.astype(float) - then.velocity) / world.dt
            turned_by = (
                0.4 * 0.1**2 * (now.rotational_velocity.astype(float) - then.rotational_velocity) / world.dt
            )
            moment = (np.cross(then.position - origin, gained) + turned_by).sum(axis=0)
            found = world.force(wall)
            np.testing.assert_allclose(found.force, -gained.sum(axis=0), atol=0.05)
            np.testing.assert_allclose(found.torque, -moment, atol=0.02)
            pressed += bool(np.abs(found.force).max() > 50 and np.abs(found.torque).max() > 5)
    assert pressed > 20


def test_the_torque_of_a_turning_drum_lifts_its_grains():
    """In steady flow the drum's torque holds the bed's centre of mass aside of its axis."""
    world = motes.World(seed=1, dt=0.02, substeps=60, progress="off")
    grains = world.system("grains")
    turn = np.arange(48) * 2 * np.pi / 48
    ring = np.stack([0.5 * np.cos(turn), 0.5 * np.sin(turn)], axis=1)
    ends = [np.column_stack([ring, np.full(48, z)]) for z in (-0.1, 0.1)]
    near, after = np.arange(48), np.roll(np.arange(48), -1)
    sides = np.stack([near, after, after + 48], 1), np.stack([near, after + 48, near + 48], 1)
    lids = np.stack([0 * near + 96, after, near], 1), np.stack([0 * near + 97, near + 48, after + 48], 1)
    points = np.concatenate([*ends, [(0, 0, -0.1), (0, 0, 0.1)]])
    drum = Mesh(points, np.concatenate([*sides, *lids]), resolution=96)
    x, y, z = (g.ravel() for g in np.mgrid[-6:7, -7:0, 0:3])
    places = np.stack([x * 0.055, y * 0.055 - 0.02, z * 0.062 - 0.062], axis=1)
    places = places[np.hypot(places[:, 0], places[:, 1]) < 0.45]
    found = []
    with world:
        for frame in world.frames(100):
            if frame == 0:
                grains.emit(position=places, size=np.full(places.shape, 0.05), mass=np.full(len(places), 0.1))
            before = drum.at(axis=(0, 0, 1), angle_deg=2 * frame)
            here = drum.at(axis=(0, 0, 1), angle_deg=2 * (frame + 1), moving_from=before)
            grains.gravity((0, -G, 0))
            grains.contact(1000, restitution=0.2, friction=0.7, rolling_friction=0.1, walls=here)
            grains.move()
            world.step()
            if frame >= 59:
                p = grains.gather()
                x, y = p.position[:, 0].astype(float), p.position[:, 1].astype(float)
                own = 0.4 * 0.025**2 * p.rotational_velocity[:, 2].astype(float)
                momentum = 0.1 * float((x * p.velocity[:, 1] - y * p.velocity[:, 0] + own).sum())
                found.append((*world.force(drum).torque, -G * 0.1 * float(x.sum()), momentum))
    torque, weight = np.mean(found[1:], axis=0)[2:4]
    gained = (found[-1][4] - found[0][4]) / (40 * world.dt)
    assert weight < -0.1 * G * 0.1 * len(places) * 0.1  # the bed is aside
    assert torque == pytest.approx(weight - gained, rel=0.03)


def test_clumps_and_spheres_of_several_systems_add_up():
    world = motes.World(seed=1, dt=0.05, substeps=200, progress="off")
    spheres, clumps, more = (world.system(name) for name in ("spheres", "clumps", "more"))
    clumps.clumps([(-0.2, 0, 0, 0.2), (0.2, 0, 0, 0.2)])
    slow = {"restitution": 0.1, "rolling_friction": 0.1}
    lonely = Plane((0, -9, 0), (0, 1, 0))
    with world:
        for frame in world.frames(50):
            if frame == 0:
                spheres.emit(position=[(0, 0.5, 0), (2, 0.5, 0)], mass=[1.0, 2.0])
                clumps.emit(position=[(5, 0.2, 0)], mass=[4.0])
                more.emit(position=[(8, 0.5, 0)], mass=[8.0])
            for system in (spheres, clumps, more):
                system.gravity((0, -G, 0))
                system.contact(2e4, **slow, walls=[Plane((0, 0, 0), (0, 1, 0)), lonely])
                system.move()
            world.step()
            if frame == 0:
                assert world.force(FLOOR).force.shape == world.force(FLOOR).torque.shape == (3,)
        np.testing.assert_allclose(world.force(FLOOR).force, (0, -15 * G, 0), atol=15 * G * 1e-3)
        np.testing.assert_allclose(
            world.force(FLOOR).torque, (0, 0, -G * (4 + 20 + 64)), rtol=1e-3, atol=1e-2
        )
        assert not np.any(world.force(lonely))
    assert world.force(FLOOR).force[1] < -100  # still known after the run


def test_a_mesh_is_recognised_where_it_is_or_if_no_other_wall_has_it():
    cube = Mesh(*block((-1, -1, -1), (1, 0, 1)), resolution=32)
    left, right = cube.at((-2, 0, 0)), cube.at((2, 0, 0), moving_from=cube.at((1.999, 0, 0)))
    world = motes.World(seed=1, dt=0.001, progress="off")
    system = world.system("s")
    with world:
        system.emit(position=[(-2, 0.45, 0), (2, 0.3, 0)])
        system.contact(1000, walls=[left, right])
        world.step()
        assert 0 > world.force(left).force[1] > world.force(right).force[1]
        assert world.force(cube.at((2, 0, 0))).force[1] == world.force(right).force[1]
        with pytest.raises(ArgumentError, match="wall"):
            world.force(cube)
        system.contact(1000, walls=right)
        world.step()
        assert world.force(cube).force[1] == world.force(right).force[1] < 0
        other = Mesh(*block((-1, -1, -1), (1, 0, 1.5)), resolution=32)
        with pytest.raises(ArgumentError, match="wall"):
            world.force(other)


def test_which_walls_have_forces():
    world = motes.World(seed=1, dt=0.001, progress="off")
    system = world.system("s")
    with pytest.raises(MotesError, match="with world"):
        world.force(FLOOR)
    with world:
        for wrong in (None, 1, "floor", (FLOOR, motes.Wall()), motes.Wall()):
            with pytest.raises(ArgumentError, match="wall"):
                world.force(wrong)
        with pytest.raises(ArgumentError, match="wall"):
            world.force(FLOOR)  # no frame has run
        system.emit(position=[(0, 0.4, 0)])
        system.contact(1000, walls=FLOOR)
        world.step()
        assert world.force(Plane((0, -0.0, 0), (0, 1, 0))).force[1] < 0
        with pytest.raises(ArgumentError, match="wall"):
            world.force(Plane((0, 0, 0), (0, -1, 0)))
        found = world.force(FLOOR)
        with pytest.raises(ValueError, match="read-only"):
            found.force[0] = 1
        world.digest()
        np.testing.assert_array_equal(world.force(FLOOR).force, found.force)
        system.contact(1000)
        world.step()
        with pytest.raises(ArgumentError, match="wall"):
            world.force(FLOOR)


def test_each_wall_has_its_own_coefficients():
    """Balls fall on walls of different restitution and slide on walls of different friction."""
    world = motes.World(seed=1, dt=0.01, substeps=200, progress="off")
    balls = world.system("balls")
    walls = [
        (Box((-1, -1, -1), (1, 0, 1)), motes.Wall(restitution=0.1)),
        (Box((2, -1, -1), (4, 0, 1)), motes.Wall(stiffness=4e4, restitution=0.9)),
        Box((5, -1, -1), (7, 0, 1)),
        (Mesh(*block((8, -1, -1), (10, 0, 1)), resolution=64), motes.Wall(friction=0)),
        (Box((11, -1, -1), (30, 0, 1)), motes.Wall(friction=0.1)),
        (Box((31, -1, -1), (49, 0, 1)), motes.Wall(rolling_friction=0.3, friction=1)),
    ]
    with world:
        for frame in world.frames(40):
            if frame == 0:
                x = np.array([0, 3, 6, 8.5, 12, 32])
                drops = np.where(x < 8, 0.6, 0.4999)
                balls.emit(position=np.stack([x, drops, 0 * x], axis=1))
                balls.set(velocity=(0, -2, 0), where=column("position").x < 8)
                balls.set(velocity=(3, 0, 0), where=column("position").x > 8)
            balls.gravity((0, -G, 0), where=column("position").x > 8)
            balls.contact(1e4, restitution=0.5, friction=0.4, walls=walls)
            balls.move()
            world.step()
        p = balls.gather()
    np.testing.assert_allclose(p.velocity[:3, 1], (0.2, 1.8, 1), atol=0.04)
    assert p.velocity[3, 0] == pytest.approx(3, abs=1e-3) and p.rotational_velocity[3].any() == 0
    assert p.velocity[4, 0] == pytest.approx(3 - 0.1 * G * 0.4, abs=0.03)
    assert p.velocity[5, 0] < 2 and p.rotational_velocity[5, 2] < -1


def test_walls_that_are_not_understood_are_refused():
    world = motes.World(progress="off")
    system = world.system("s")
    wall = motes.Wall(friction=0.1)
    with world:
        for wrong in (
            wall,
            [wall],
            [(FLOOR, wall, wall)],
            [(FLOOR, 0.1)],
            [(wall, FLOOR)],
            [(FLOOR,)],
            [(FLOOR, None)],
            ["floor"],
            {"a": FLOOR},
            0.5,
        ):
            with pytest.raises(ArgumentError, match="walls"):
                system.contact(100, walls=wrong)
        with pytest.raises(ArgumentError, match="walls"):
            system.contact(100, walls=[(Blob((0, 0, 0), 1), wall)])
        system.contact(100, walls=(FLOOR, wall))  # one pair
        system.contact(100, walls=[[FLOOR, wall], FLOOR])
        assert system.recorded[0].walls == ((FLOOR, wall),)
        assert system.recorded[1].walls == ((FLOOR, wall), FLOOR)
    for name, values in {
        "stiffness": (0, -1, 1e31, "1", float("nan"), True),
        "restitution": (-0.1, 1.1, float("inf")),
        "friction": (-1, float("nan")),
        "rolling_friction": (-1, [1]),
    }.items():
        for value in values:
            with pytest.raises(ArgumentError, match=name):
                motes.Wall(**{name: value})
    with pytest.raises(TypeError, match="friction"):
        motes.Wall(frition=1)
    assert motes.Wall(friction=1) == motes.Wall(friction=1.0) != motes.Wall()
    assert repr(motes.Wall(friction=0.1)) == "Wall(friction=0.1)"


def test_the_log_has_a_row_for_each_frame_and_wall(tmp_path: Path):
    world = motes.World(seed=1, dt=0.001, substeps=4, progress="off", log=tmp_path / "log")
    a, b = world.system("a"), world.system("b")
    wall = Sphere((0, -1, 0), 1)
    wanted: list[Any] = []
    with world:
        for frame in world.frames(4):
            for system in (a, b):
                if frame == 0:
                    system.emit(position=[(0, 0.45, 0.1)])
                if frame < 3:
                    system.contact(
                        1000, walls=[FLOOR, wall] if system is a else [(wall, motes.Wall(friction=0))]
                    )
                system.move()
            world.step()
            shapes = () if frame == 3 else (FLOOR, wall)
            wanted += [(frame, n, type(s).__name__, *np.ravel(world.force(s))) for n, s in enumerate(shapes)]
    run = motes.open_run(tmp_path / "log")
    assert run.walls[["frame", "wall", "shape"]].to_numpy().tolist() == [list(row[:3]) for row in wanted]
    np.testing.assert_allclose(run.walls.iloc[:, 3:], [row[3:] for row in wanted], rtol=1e-8)
    rows = [json.loads(line) for line in (tmp_path / "log" / "walls.jsonl").read_text().splitlines()]
    assert len(rows) == 6 and rows[0]["force_y_n"] < -1


RESUMED = """
import os, sys, motes
from motes.shapes import Plane
floor = Plane((0, 0, 0), (0, 1, 0))
kept = motes.Checkpoint(sys.argv[1], every=1)
world = motes.World(seed=1, dt=0.01, substeps=20, progress="off", checkpoint=kept)
s, t = world.system("s"), world.system("t")
with world:
    for frame in world.frames(int(os.environ["FRAMES"])):
        if frame == 0:
            s.emit(position=[(0, 0.51, 0), (0.4, 1.4, 0)], velocity=[(1, -2, 0), (0, -2, 0)])
            t.emit(position=[(0.9, 0.5, 0.1)], rotational_velocity=[(3, 4, 5)])
        elif "manager" in world.role:
            print(frame, *(numbers.tolist() for numbers in world.force(floor)))  # of the last frame
        s.contact(2000, friction=0.4, walls=[floor])
        t.contact(2000, friction=0.4, walls=[floor])
        s.contact(1000, friction=0.7, other=t)
        for system in world.systems:
            system.gravity((0, -9.81, 0))
            system.move()
        world.step()
    digest = world.digest()
    if "manager" in world.role:
        print(digest)
"""


def test_forces_of_the_last_frame_outlive_a_restart(tmp_path: Path):
    def lines(ranks: int, folder: str, frames: int) -> list[str]:
        return on_ranks(ranks, RESUMED, tmp_path / folder, env={"FRAMES": str(frames)}).lines

    whole = lines(1, "whole", 6)
    assert len(set(whole)) == 6 and lines(1, "parts", 3)[:2] == whole[:2]
    assert lines(2, "parts", 6) == whole[2:]


EXTREMES = """
import numpy as np
import motes
from motes.shapes import Plane

floor = Plane((0, 0, 0), (0, 1, 0))
rng = np.random.default_rng(7)
n = 300
world = motes.World(seed=1, dt=0.5, progress="off", roles="shared", space=(-1, 1))
s = world.system("s")
with world:
    x = rng.uniform(-1, 1, n)
    mass = 10.0 ** rng.uniform(-9, 12, n)
    size = np.full((n, 3), 1e-3)
    s.emit(position=np.stack([x, rng.uniform(1e-4, 4e-4, n), 3.0 * np.arange(n)], 1), mass=mass, size=size)
    s.contact(1e13, friction=0, walls=floor)
    world.step()
    force, torque = world.force(floor)
    if "manager" in world.role:
        print([value.hex() for value in (*force.tolist(), *torque.tolist())])
"""


def test_nanonewtons_beside_giganewtons_are_exact_on_any_ranks():
    lines = alike(EXTREMES, ranks=(1, 2, 3, 5))
    assert float.fromhex(eval(lines[0])[1]) < -1e6
