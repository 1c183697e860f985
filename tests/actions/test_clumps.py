"""Clumps: rigid groups of spheres that move, collide, touch walls and migrate."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from standing import alike, assert_goes_on

import motes
from motes.errors import ArgumentError
from motes.shapes import Plane

DUMBBELL = [(-0.5, 0, 0, 0.25), (0.5, 0, 0, 0.25)]
BRICK = [(x, y, z, 0.3) for x in (-0.6, 0, 0.6) for y in (-0.25, 0.25) for z in (-0.1, 0.1)]

BED = """
import numpy as np
import motes
from motes.expressions import column
from motes.shapes import Box, Plane

axes, periodic = {0!r}, {1!r}
rng = np.random.default_rng(5)
places = np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), -1).reshape(-1, 3) * 0.24 - 0.36
turns = rng.normal(size=(64, 4)).round(3)
world = motes.World(
    seed=1, dt=0.02, substeps=25, progress="off", roles="shared", space=(-0.6, 0.6), periodic=periodic,
    balancer=motes.balance.PrefixCuts(),
    renderer=motes.Renderer(64, 48, camera=motes.Camera((0, 0, 4), (0, 0, 0))),
)
grains = world.system("grains", axis=axes, sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))
grains.clumps([(0, 0, 0, 0.06), (0.08, 0, 0, 0.05), (0.02, 0.07, 0, 0.05)], density=1000)
with world:
    for frame in world.frames(6):
        if frame == 0:
            grains.emit(
                position=places, velocity=rng.uniform(-1, 1, places.shape), orientation=turns,
                spin=rng.uniform(-5, 5, places.shape),
                size=np.repeat(rng.uniform(0.7, 1.2, (64, 1)), 3, axis=1),
            )
        grains.gravity((0.0, -9.81, 0.0))
        grains.contact(2000, friction=0.6, rolling_friction=0.05, walls=[Plane((0, -0.5, 0), (0.1, 1, 0))])
        if frame == 4:
            grains.sink(Box((-0.1, -1, -1), (0, 1, 1)))
        grains.move()
        picture = world.render()
        digest = world.digest()
        if "manager" in world.role:
            print(digest, flush=True)
    touching = grains.total(column("contacts"))
    if "manager" in world.role:
        print(touching > 10, grains.count < 64)
"""


@pytest.mark.parametrize(("axes", "periodic"), [("x", None), ("xz", {"x": (-0.6, 0.6), "z": (-0.6, 0.6)})])
def test_clumps_meet_alike_on_any_ranks(axes: str, periodic: Any):
    lines = alike(BED.format(axes, periodic), ranks=(1, 2, 3, 5))
    assert len(set(lines)) == 7
    assert lines[-1] == "True True"


def moments(p: motes.Particles, template: Any, dt: float) -> tuple[NDArray[Any], NDArray[Any], float]:
    """Return momentum, angular momentum about the origin, and energy; spins lag by half a step."""
    v, w = p.velocity.astype(float), p.spin.astype(float)
    back = np.eye(3) - np.cross(np.eye(3)[None], 0.5 * dt * w[:, None, :])
    axes = np.linalg.qr(back @ turns(p))[0]
    inertia = p.mass[:, None, None] * (axes @ template.inertia @ axes.transpose(0, 2, 1))
    own = np.einsum("nij,nj->ni", inertia, w)
    mass = p.mass[:, None].astype(float)
    turning = (np.cross(p.position, mass * v) + own).sum(axis=0)
    return (mass * v).sum(axis=0), turning, float(0.5 * (mass * v * v).sum() + 0.5 * (w * own).sum())


def turns(p: motes.Particles) -> NDArray[Any]:
    x, y, z, w = p.orientation.astype(float).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)


def test_a_clump_that_nothing_touches_keeps_energy_and_angular_momentum():
    """A rotation about the intermediate axis flips over and over (Dzhanibekov)."""
    world = motes.World(seed=1, dt=0.02, substeps=10, progress="off")
    s = world.system("s")
    template = s.clumps(BRICK, density=10)
    turned = []
    with world:
        for frame in world.frames(200):
            if frame == 0:
                s.emit(position=[(0, 0, 0)], spin=[(0.2, 4, 0.1)])
            s.contact(1000)
            s.move()
            world.step()
            p = s.gather()
            _, turning, energy = moments(p, template, world.dt / 10)
            if frame == 0:
                first, worth = turning, energy
            turned.append(float(turns(p)[0, 1, 1]))
            np.testing.assert_allclose(turning, first, atol=1e-4 * np.linalg.norm(first))
            assert energy == pytest.approx(worth, rel=1e-4)
    assert min(turned) < -0.9
    assert p.contacts[0] == 0  # spheres of the same clump do not touch


def test_clumps_that_meet_keep_momentum_and_angular_momentum():
    world = motes.World(seed=1, dt=0.01, substeps=50, progress="off")
    s = world.system("s")
    template = s.clumps(DUMBBELL, density=10)
    with world:
        for frame in world.frames(60):
            if frame == 0:
                s.emit(
                    position=[(0, 0, 0), (0.3, 1.2, 0.1)],
                    velocity=[(0, 2, 0), (0, -2, 0)],
                    spin=[(0, 0, 0), (0, 1, 2)],
                    orientation=[(0, 0, 0, 1), (0, 0.3, 0.6, 0.7)],
                )
            s.contact(2000, restitution=1, friction=0)
            s.move()
            world.step()
            if frame == 0:
                before = moments(s.gather(), template, world.dt / 50)
        after = moments(s.gather(), template, world.dt / 50)
        assert s.gather().velocity[0, 1] < 1.5  # they have collided
    np.testing.assert_allclose(after[0], before[0], atol=1e-4)
    np.testing.assert_allclose(after[1], before[1], atol=1e-3)
    assert after[2] == pytest.approx(before[2], rel=0.02)


def test_a_clump_of_one_sphere_moves_as_a_sphere():
    slope = Plane((0, 0, 0), (0.3, 1, 0))
    found = []
    for clumped in (False, True):
        world = motes.World(seed=1, dt=0.01, substeps=40, progress="off")
        s = world.system("s")
        if clumped:
            s.clumps([(1, 2, 3, 0.1)])
        else:
            s.configure(size=0.2)
        s.configure(mass=0.5)
        with world:
            for frame in world.frames(50):
                if frame == 0:
                    s.emit(position=[(0, 0.12, 0), (0.19, 0.15, 0.02)])
                s.gravity((0, -9.81, 0))
                s.contact(5000, friction=0.4, rolling_friction=0.01, walls=[slope])
                s.move()
                world.step()
            p = s.gather()
            found.append((p.position, p.velocity, p.spin if clumped else p.rotational_velocity))
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, atol=2e-3)


def test_a_dumbbell_across_a_slope_rolls_as_its_moment_says():
    """With its axis across the slope, the acceleration is g sin(angle) / (1 + I / (m r^2))."""
    angle, radius = 0.2, 0.25
    world = motes.World(seed=1, dt=0.01, substeps=40, progress="off")
    s = world.system("s")
    template = s.clumps([(0, 0, -0.5, radius), (0, 0, 0.5, radius)], density=10)
    down = np.array([np.cos(angle), -np.sin(angle), 0])
    normal = np.array([np.sin(angle), np.cos(angle), 0])
    with world:
        for frame in world.frames(50):
            if frame == 0:
                s.emit(position=[radius * 0.999 * normal])
            s.gravity((0, -9.81, 0))
            s.contact(20000, restitution=0.1, friction=0.8, walls=[Plane((0, 0, 0), tuple(normal))])
            s.move()
            world.step()
        p = s.gather()
    rate = 9.81 * np.sin(angle) / (1 + template.inertia[2, 2] / radius**2)
    assert float(p.velocity[0] @ down) == pytest.approx(rate * 0.5, rel=0.01)
    assert float(p.spin[0, 2]) == pytest.approx(-rate * 0.5 / radius, rel=0.01)
    assert p.contacts[0] == 0  # walls do not count as contacts


def test_the_template_says_volume_centre_and_inertia():
    ball = motes.World(progress="off").system("s").clumps([(3, 0, 0, 0.5)])
    assert ball.volume == pytest.approx(np.pi / 6)
    assert ball.center == (3, 0, 0)
    np.testing.assert_allclose(ball.inertia, np.eye(3) * 0.4 * 0.25, atol=1e-12)
    apart = motes.World(progress="off").system("s").clumps([(0, 0, 0, 0.5), (0, 2, 0, 0.25)])
    assert apart.center[1] == pytest.approx(2 / 9)
    # A sphere inside another adds nothing.
    union = motes.World(progress="off").system("s").clumps([(0, 0, 0, 0.5), (0.1, 0.1, 0, 0.2)])
    assert union.volume == pytest.approx(np.pi / 6, rel=2e-4)
    np.testing.assert_allclose(union.inertia, np.eye(3) * 0.1, atol=1e-4)
    # Two overlapping spheres: a cap is cut off each.
    overlapping = motes.World(progress="off").system("s").clumps([(0, 0, 0, 1), (1, 1, 0, 1)])
    h = 1 - np.sqrt(0.5)
    assert overlapping.volume == pytest.approx(2 * (4 / 3 * np.pi - np.pi * h * h * (3 - h) / 3), rel=2e-4)
    np.testing.assert_allclose(overlapping.center, (0.5, 0.5, 0), atol=1e-4)


@pytest.mark.parametrize(
    "template",
    [
        [],
        [(0, 0, 0)],
        [(0, 0, 0, 0)],
        [(0, 0, 0, -1)],
        [(0, 0, np.nan, 1)],
        [(0, 0, 0, np.inf)],
        [(0, 0, 0, 1), (0, 0, 1e5, 1)],
        [(i, 0, 0, 1) for i in range(65)],
        "spheres",
        None,
    ],
)
def test_templates_that_are_none_are_refused(template: Any):
    with pytest.raises(ArgumentError, match="template"):
        motes.World(progress="off").system("s").clumps(template)


def test_what_clumps_cannot_do_is_refused():
    world = motes.World(progress="off")
    s, other = world.system("s"), world.system("other")
    s.clumps(DUMBBELL)
    with pytest.raises(ArgumentError, match="density"):
        s.clumps(DUMBBELL, density=0)
    with pytest.raises(ArgumentError, match="position"):
        s.clumps(DUMBBELL, velocity=[(0, 0, 0)])
    with world:
        with pytest.raises(ArgumentError, match="radius"):
            s.contact(100, radius=0.1)
        s.contact(100)
        with pytest.raises(ArgumentError, match="contact"):
            s.contact(100)
        s.clumps(DUMBBELL, position=[(0, 0, 0)])
        other.burst((0, 0, 0))
        with pytest.raises(ArgumentError, match="template"):
            s.clumps(BRICK)
        with pytest.raises(ArgumentError, match="template"):
            other.clumps(BRICK)
        world.step()
        assert s.count == 1


RESUMED = """
import os, sys, motes
kept = motes.Checkpoint(sys.argv[1], every=2)
world = motes.World(seed=1, dt=0.01, substeps=20, progress="off", checkpoint=kept)
s = world.system("s")
with world:
    for frame in world.frames(8):
        if frame == int(os.environ.get("KILL", -1)):
            os._exit(9)
        if frame == 0:
            s.clumps([(0, 0, 0, 0.2), (0.3, 0, 0, 0.15)], density=100, position=[(0, 0, 0), (0.1, 0.3, 0)])
        if frame == 6:
            s.emit(position=[(0, 0.8, 0)])
        s.gravity((0, -9.81, 0))
        s.contact(5000, friction=0.9, walls=[motes.shapes.Plane((0, -0.2, 0), (0.1, 1, 0))])
        s.move()
        world.step()
    digest = world.digest()
    if "manager" in world.role:
        print("digest", digest)
"""


def test_a_run_goes_on_with_its_clumps(tmp_path: Path):
    assert_goes_on(RESUMED, tmp_path)


def test_each_sphere_of_a_clump_is_drawn():
    pictures = []
    for clumped in (False, True):
        camera = motes.Camera((0, 0, 5), (0, 0, 0), fov_deg=40)
        world = motes.World(
            seed=1, progress="off", renderer=motes.Renderer(80, 60, camera=camera, background=(0, 0, 0))
        )
        s = world.system("s", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))
        with world:
            if clumped:
                s.clumps(DUMBBELL, position=[(0, 0, 0)], orientation=[(0, 0, 0.7071068, 0.7071068)])
            else:
                s.emit(position=[(0, -0.5, 0), (0, 0.5, 0)], size=[(0.5, 0.5, 0.5)] * 2)
            pictures.append(world.render().pixels.copy())
    assert (pictures[0] != pictures[1]).mean() < 0.01
    assert (pictures[1][..., :3].max(axis=2) > 60).sum() > 80
