"""Conditions, computed attributes, secondary births and callbacks in one scene; one line per frame."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Plane, Sphere

world = motes.World(seed=3, space=(-5, 5), progress="off", roles="shared", substeps=2)
rockets = world.system("rockets", attributes={"heat": 1.0, "aim": (1, 0, 0)})
sparks = world.system("sparks", capacity=3000)


def slow_down(particles):
    """Slow down each particle by itself."""
    particles.velocity[:, 0] *= np.float32(0.99)


with world:
    for frame in world.frames(12):
        if frame == 0:
            rockets.configure(velocity=Sphere((0, 8, 0), 3), lifetime=motes.Uniform(0.1, 0.4))
            rockets.burst(Box((-5, 0, 0), (5, 1, 1)), count=60)
        sparks.configure(velocity=Sphere((0, 0, 0), 4), lifetime=motes.Uniform(0.1, 0.3))
        rockets.set(heat=column("age") * 2 + column("position").y, aim=column("velocity") * 0.5 + (0, 1, 0))
        rockets.spawn(into=sparks, on="death", count=30, inherit_velocity=0.5)
        rockets.spawn(into=sparks, on="birth", count=2, where=column("position").x > 0)
        sparks.spawn(into=rockets, on="collision", count=1, where=column("velocity").length() > 4)
        rockets.source((0, 0, 0), rate=100)
        rockets.damping((0, 0, 0), where=Box((-1, 0, 0), (1, 9, 1)) & ~Sphere((0, 3, 0), 1))
        rockets.random_acceleration(Sphere((0, 0, 0), 30), where=column("heat") < 1.5)
        if frame == 4:
            with rockets.local() as particles:
                particles.velocity[:] *= np.float32(1.5)
        sparks.callback(slow_down, where=Sphere((0, 2, 0), 3) | (column("age") < 0.1))
        for system in (rockets, sparks):
            system.gravity((0, -9.81, 0))
            system.bounce(Plane((0, 0, 0), (0, 1, 0)), restitution=0.5)
            system.kill_expired()
            system.move()
        sparks.callback(slow_down)
        world.step()
        world.say(f"{frame} {world.digest()} {rockets.count} {sparks.count} {sparks.dropped}")
