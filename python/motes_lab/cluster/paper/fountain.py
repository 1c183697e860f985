"""The paper's fountains (5.2): one system each, side by side in a part of the space."""

import numpy as np

import motes
from motes.shapes import Plane, Sphere

args = motes.script.options(
    __doc__,
    particles=2000,
    frames=40,
    size="64x36",
    space="0,100",
    first=30.0,
    step=3.0,
    spread=2.0,
    faintest=1.0,
)
gravity, up, life = np.array([0, -9.81, 0]), 16.0, 200 / 60  # m/s^2, m/s, s
camera = motes.Camera((50, 10, 80), (50, 10, 0), fov_deg=75)
renderer = motes.Renderer(*args.size, camera=camera, path="gather")
world = motes.World(seed=args.seed, dt=1 / 90, space=args.space, renderer=renderer, log=args.log)
fountains = [
    (world.system(f"fountain {i}", capacity=args.particles), np.array([args.first + i * args.step, 0.1, 0]))
    for i in range(args.systems)
]
draw = np.random.default_rng(1)

with world:
    for frame in world.frames(args.frames):
        for water, nozzle in fountains:
            if args.faintest < 1:  # each drop's look travels with it, as in the paper
                water.configure(alpha=motes.Uniform(args.faintest, 1))
            if frame == 0:  # the water is in the air from the start
                ball = draw.normal(size=(args.particles, 3))
                ball *= (draw.random((args.particles, 1)) ** (1 / 3)) / np.linalg.norm(
                    ball, axis=1, keepdims=True
                )
                left, age = ball * args.spread + (0, up, 0), draw.random((args.particles, 1)) * life
                here = nozzle + left * age + gravity * age**2 / 2
                here[:, 1] = np.maximum(here[:, 1], 0.1)
                water.emit(position=here, velocity=left + gravity * age, age=age[:, 0])
            water.configure(velocity=Sphere((0, up, 0), args.spread))
            water.source(Sphere(nozzle, 0.05), rate=args.particles / life)
            water.gravity(gravity)
            water.random_acceleration(Sphere((0, 0, 0), 0.5))
            water.bounce(Plane((0, 0, 0), (0, 1, 0)), restitution=0.3, friction=0.2)
            water.kill_old(life)
            water.move()
        world.render()
