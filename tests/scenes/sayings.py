"""All features of recorded scenes in a small one; `--digest` prints the same as `motes_replay --digest`.

With `--read` it also reads particles, and its calls depend on them.
"""

from __future__ import annotations

import sys

import numpy as np

import motes
from motes import shapes
from motes.expressions import column

FRAMES = 7
digest, read = "--digest" in sys.argv, "--read" in sys.argv
camera = motes.Camera((0, 2, 9), (0, 1, 0))
renderer = motes.Renderer(96, 64, camera=camera, objects=[shapes.Plane((0, 0, 0), (0, 1, 0))])
world = motes.World(seed=77, dt=1 / 20, substeps=2, space="fit", renderer=renderer, progress="off")
sparks = world.system("sparks", attributes={"heat": 0.25, "wind": (0, 0, 0)}, capacity=600)
smoke = world.system("smoke", axis="y", space=(0, 3), sprite=motes.Sprite("point"))


def say(frame: int) -> None:
    """Make the calls of one frame."""
    sparks.configure(
        velocity=shapes.Sphere((0, 4, 0), 2), lifetime=motes.Uniform(0.1, 0.6), heat=motes.Normal(0, 1)
    )
    sparks.source(shapes.Disc((0, 0.1, 0), (0, 1, 0), 1.5), rate=2000, jitter=True)
    sparks.emit(position=[(0.1 * frame, 1, 0), (-1, 1, 0.5)], wind=[(1, 0, 0), (0, 0, 1)])
    sparks.gravity((0, -9.8, 0), where=column("age") > 0.05)
    sparks.wind((2, 0, 0), drag=0.5, where=shapes.Sphere((0, 1, 0), 1) | ~shapes.Box((-2, 0, -2), (2, 2, 2)))
    sparks.set(heat=column("heat") * 0.9 + column("age"))
    sparks.color_over_life([(0, (1, 1, 0.5)), (0.4, (1, 0.3, 0)), (1, (0.1, 0, 0))])
    sparks.bounce(shapes.Plane((0, 0, 0), (0, 1, 0)), restitution=0.5)
    sparks.spawn(into=smoke, on="death", count=2, inherit_velocity=0.3, where=column("position").x > -0.5)
    sparks.spawn(into=sparks, on="collision", count=1)
    sparks.restore(0.5, where=column("heat") > 1.5)
    sparks.move()
    sparks.kill_expired()
    smoke.configure(alpha=motes.Uniform(0.1, 0.4), size=0.5)
    smoke.vortex((0, 0, 0), axis=(0, 1, 0), tightness=1, max_radius=3, in_speed=1, up_speed=2, around_speed=1)
    smoke.alpha_over_life([(0, 1), (1, 0)])
    smoke.move()
    smoke.kill_old(0.4)


def look(frame: int) -> None:
    """Make calls that depend on the particles."""
    with smoke.local() as here:  # splits the list
        highest = float(here.position[:, 1].max()) if len(here) else 0.0
    assert np.isfinite(highest)
    smoke.gravity((0, -0.5, 0))
    if sparks.count > 150:
        sparks.burst((0, 2, 0), count=sparks.count % 7)
    if frame == 5:
        assert len(world.systems[2].total(column("velocity_b"))) == 3  # its particles have it from here on
    if frame == 5 and world.digest() > "8":
        smoke.random_velocity(shapes.Sphere((0, 0, 0), 1))


def rename(frame: int) -> None:
    """Change what may change between frames: camera, sprites, the number of systems."""
    camera.position = (0.2 * frame, 2, 9)
    if frame == 3:
        smoke.sprite = motes.Sprite("disc", pixels=7)
        world.system("late", space="fit").configure(color=(0, 1, 0))
    if frame > 3:
        world.systems[2].source(shapes.Box((-1, 0, -1), (1, 2, 1)), rate=500)
        world.systems[2].random_acceleration(shapes.Sphere((0, 0, 0), 9))
        world.systems[2].move()


with world:
    for number in world.frames(FRAMES):
        say(number)
        rename(number)
        if read:
            look(number)
        picture = world.step() if number == 4 else world.render()
        if digest:
            motes.script.print_digest(world, picture)
