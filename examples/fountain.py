"""Fountains dance at night: python -m motes run -n 4 examples/fountain.py."""

import colorsys

import numpy as np

import motes
from motes.shapes import Plane, Sphere

args = motes.script.options(__doc__, space="-16,16")
gravity, life, spread = np.array([0, -9.81, 0]), 2.3, 1.1  # m/s^2, s, m/s


def jet(x, time):
    """Velocity of the water that leaves the nozzle at x: a wave runs along the row."""
    turn = 2 * np.pi * (time / 4 - x / 16)
    # Rounded: sines differ in their last bit between machines, and all ranks must say the same.
    return np.array([1.5 * np.sin(turn), 9.5 + 1.2 * np.cos(2 * turn), 0]).round(4)


row = [(i + 0.5) / args.systems for i in range(args.systems)]
pool, balls = Plane((0, 0, 0), (0, 1, 0)), [Sphere((26 * part - 13, 0.35, 0), 0.6) for part in row]
solids = [
    motes.Solid(pool, (0.01, 0.018, 0.026)),
    *(motes.Solid(ball, (0.09, 0.085, 0.08)) for ball in balls),
]
camera = motes.Camera((-14.5, 1.5, 18.5), (-1.9, 4.2, 0), fov_deg=35)
renderer = motes.Renderer(*args.size, camera=camera, background=(0.002, 0.003, 0.008), objects=solids)
world = motes.World(seed=args.seed, space=args.space, balancer=args.balancer, renderer=renderer, log=args.log)
fountains = []
for part, ball in zip(row, balls, strict=True):
    water = world.system(f"at {part:.3f}", capacity=args.particles, sprite=motes.Sprite("disc", pixels=4))
    water.configure(color=colorsys.hsv_to_rgb(0.47 + 0.55 * part, 0.7, 1), alpha=motes.Normal(0.01, 0.02))
    fountains.append((water, ball, np.array([26 * part - 13, 0.95, 0])))

with world, motes.Movie(f"{args.out}/fountain.mp4") as movie:
    for frame in world.frames(args.frames):
        for water, ball, nozzle in fountains:
            for k in range(96 if frame == 0 else 0):  # the water is in the air from the start
                age = (k + 0.5) * life / 96
                left = jet(nozzle[0], -age)
                water.configure(age=motes.Uniform(age - life / 192, age + life / 192))
                water.configure(velocity=Sphere(left + gravity * age, spread))
                here = nozzle + left * age + gravity * age * age / 2
                water.burst(Sphere(here, 0.1 + spread * age), count=args.particles * 47 // 48 // 96)
            water.configure(age=0, velocity=Sphere(jet(nozzle[0], world.time), spread))
            water.source(Sphere(nozzle, 0.1), rate=args.particles * 47 / 48 / life, jitter=True)
            water.gravity(gravity)
            water.random_acceleration(Sphere((0, 0, 0), 4))
            water.bounce(pool, restitution=0.3, friction=0.2)
            water.bounce(ball, restitution=0.3, friction=0.2)
            water.kill_old(life)
            water.move()
        motes.script.end_frame(world, movie, args)
