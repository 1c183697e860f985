"""Fountains dance at night: python -m motes run -n 4 examples/fountain.py."""

import colorsys

import numpy as np

import motes
from motes.shapes import Plane, Sphere

args = motes.script.options(__doc__, space="-16,16")
gravity = np.array([0, -9.81, 0])  # m/s^2
life, spread = 2.3, 1.1  # s in the air; spread of velocities, m/s
# Leave room in the capacity, since the source emits a whole number per frame.
drops = args.particles * 47 / 48
batches = 96


def jet(x, time):
    """Return the velocity of water from the nozzle at x, m/s: a wave runs along the row of fountains."""
    phase = 2 * np.pi * (time / 4 - x / 16)
    # Round: sines differ in their last bit between machines, and all ranks must record the same numbers.
    return np.array([1.5 * np.sin(phase), 9.5 + 1.2 * np.cos(2 * phase), 0]).round(4)


# The fountains stand in a row along x, each on a ball in the pool.
parts = [(i + 0.5) / args.systems for i in range(args.systems)]
pool = Plane((0, 0, 0), (0, 1, 0))
balls = [Sphere((26 * part - 13, 0.35, 0), 0.6) for part in parts]
nozzles = [np.array([26 * part - 13, 0.95, 0]) for part in parts]

solids = [motes.Solid(pool, (0.01, 0.018, 0.026))]
solids += [motes.Solid(ball, (0.09, 0.085, 0.08)) for ball in balls]
camera = motes.Camera((-14.5, 1.5, 18.5), (-1.9, 4.2, 0), fov_deg=35)
renderer = motes.Renderer(*args.size, camera=camera, background=(0.002, 0.003, 0.008), objects=solids)
world = motes.World(**args.world, renderer=renderer)

fountains = []
for part, ball, nozzle in zip(parts, balls, nozzles, strict=True):
    water = world.system(f"at {part:.3f}", capacity=args.particles, sprite=motes.Sprite(height=0.0056))
    water.configure(color=colorsys.hsv_to_rgb(0.47 + 0.55 * part, 0.7, 1), alpha=motes.Normal(0.01, 0.02))
    fountains.append((water, ball, nozzle))


def fill_the_air(water, nozzle):
    """Start the film with running fountains: put each drop where it is at its age."""
    for k in range(batches):
        age = (k + 0.5) * life / batches
        start = jet(nozzle[0], -age)  # its velocity when it left the nozzle
        place = nozzle + start * age + gravity * age * age / 2
        water.configure(age=motes.Uniform(age - life / 2 / batches, age + life / 2 / batches))
        water.configure(velocity=Sphere(start + gravity * age, spread))
        water.burst(Sphere(place, 0.1 + spread * age), count=args.particles * 47 // 48 // batches)
    water.configure(age=0)


with world, motes.Movie(f"{args.out}/fountain.mp4") as movie:
    for frame in world.frames(args.frames):
        for water, ball, nozzle in fountains:
            if frame == 0:
                fill_the_air(water, nozzle)
            water.configure(velocity=Sphere(jet(nozzle[0], world.time), spread))
            water.source(Sphere(nozzle, 0.1), rate=drops / life, jitter=True)
            water.gravity(gravity)
            water.random_acceleration(Sphere((0, 0, 0), 4))
            water.bounce(pool, restitution=0.3, friction=0.2)
            water.bounce(ball, restitution=0.3, friction=0.2)
            water.kill_old(life)
            water.move()
        motes.script.end_frame(world, movie, args)
