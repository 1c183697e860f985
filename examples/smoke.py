"""Coloured smoke curls up around a ball: python -m motes run -n 4 examples/smoke.py."""

import numpy as np

import motes
from motes.shapes import Cylinder, Disc, Plane, Sphere

args = motes.script.options(
    __doc__, space="-1.6,1.6", systems=3, particles=30_000, frames=216, size="960x540"
)

ground = Plane((0, 0, 0), (0, 1, 0))
ball = Sphere((0.3, 1.75, 0), 0.42)  # hangs over the middle pot, in its smoke
mouths = [(-1.05, 0.22, 0.1), (0.2, 0.22, 0), (1.3, 0.22, -0.1)]
pots = [Cylinder((x, 0, z), (x, 0.3, z), 0.17, 0.13) for x, _, z in mouths]
colors = [(0.92, 0.06, 0.24), (0.95, 0.4, 0.04), (0.05, 0.36, 0.92)]
stone = np.random.default_rng(1).integers(190, 255, (64, 64, 1)).repeat(3, 2).astype(np.uint8)

solids = [motes.Solid(ground, (0.16, 0.15, 0.15), image=stone, scale=2, roughness=0.5)]
solids += [motes.Solid(ball, (0.5, 0.5, 0.52), roughness=0.15)]
solids += [motes.Solid(pot, (0.6, 0.34, 0.13), roughness=0.3, metal=1) for pot in pots]
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((-0.4, 1.15, 6.4), (0.05, 1.62, 0), fov_deg=32),
    background=motes.Gradient((0.05, 0.055, 0.075), (0.01, 0.012, 0.02), (0.03, 0.03, 0.03)),
    objects=solids,
    lights=[motes.Light((2.6, 3.2, -3), (0.75, 0.85, 1), power=9, radius=0.3)],  # an edge from behind
    sun=(-0.8, 0.75, 0.55),
    sun_color=(1, 0.9, 0.76),
    sun_power=2,
    sun_size=3,
    occlusion=1,
    exposure=1.3,
)
world = motes.World(**args.world, renderer=renderer)

# Each puff takes light away from those behind it, so that the plumes have a bright and a dark side.
plumes = []
for i in range(args.systems):
    puff = motes.Sprite(pixels=None, blend="alpha", softness=0.1, lit=True, shadow=0.4)
    smoke = world.system(f"smoke {i}", capacity=args.particles, sprite=puff)
    smoke.configure(velocity=Sphere((0, 1.4, 0), 0.08), lifetime=motes.Uniform(3, 5.5), color=colors[i % 3])
    plumes.append((smoke, Disc(mouths[i % 3], (0, 1, 0), 0.1)))

with world, motes.Movie(f"{args.out}/smoke.mp4") as movie:
    for _ in world.frames(args.frames):
        for smoke, mouth in plumes:
            smoke.source(mouth, rate=args.particles / 4.5, jitter=True)
            smoke.wind((0, 0.75, 0), drag=1.1)  # warm air carries it up
            smoke.curl_noise(1.35, scale=0.6, octaves=4, speed=0.2)
            smoke.bounce(ball, restitution=0.1)
            smoke.alpha_over_life([(0, 0), (0.03, 0.35), (0.4, 0.16), (1, 0)])
            smoke.size_over_life([(0, 0.05), (0.3, 0.11), (1, 0.32)])
            smoke.kill_expired()
            smoke.move()
        motes.script.end_frame(world, movie, args)
