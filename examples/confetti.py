"""Confetti over a stage: python -m motes run -n 4 examples/confetti.py."""

import colorsys

import numpy as np

import motes
from motes.shapes import Box, Cone, Cylinder, Plane, Sphere

args = motes.script.options(__doc__, space="-6,6", systems=7, particles=900, frames=144, size="960x540")

floor = Plane((0, 0, 0), (0, 1, 0))
steps = [Cylinder((0, 0, 0), (0, high, 0), radius) for high, radius in ((0.25, 2.6), (0.5, 1.9), (0.75, 1.2))]
cup = [
    Cylinder((0, 0.75, 0), (0, 0.85, 0), 0.3),
    Cylinder((0, 0.85, 0), (0, 1.15, 0), 0.06),
    Cone((0, 0.95, 0), (0, 1.75, 0), 0.42),
    *(Sphere((x, 1.45, 0), 0.13) for x in (-0.46, 0.46)),
]
curtain = [Cylinder((x, 0, -4.2), (x, 9, -4.2), 0.42) for x in np.arange(-10, 10.1, 0.62).round(2)]
guns = [((-4.6, 0.4, 1.2), (0.42, 1, -0.16)), ((4.6, 0.4, 1.2), (-0.42, 1, -0.16))]
solids = [motes.Solid(floor, (0.10, 0.055, 0.03))]
solids += [motes.Solid(fold, (0.16, 0.012, 0.022)) for fold in curtain]
solids += [motes.Solid(step, (0.5, 0.5, 0.55)) for step in steps]
solids += [motes.Solid(part, (0.75, 0.5, 0.08)) for part in cup]
solids += [
    motes.Solid(Cylinder(foot, np.add(foot, np.multiply(0.9, aim)).round(3), 0.16), (0.1, 0.1, 0.12))
    for foot, aim in guns
]
lights = [motes.Light((-5, 7, 5), (1, 0.8, 0.6), 60), motes.Light((5, 7, 4), (0.55, 0.7, 1), 55)]
lights += [motes.Light((0, 6, -3), (1, 0.45, 0.3), 14)]  # from behind
camera = motes.Camera((0, 1.7, 9.5), (0, 2.35, 0), fov_deg=36, focus=9.2, aperture=0.12)
renderer = motes.Renderer(
    *args.size,
    camera=camera,
    background=motes.Gradient((0.03, 0.015, 0.02), (0.01, 0.01, 0.02)),
    objects=solids,
    lights=lights,
    sun=(0, 0, 0),
    exposure=1.1,
    shutter=0.3,
)
world = motes.World(**args.world, renderer=renderer)

paper = np.full((8, 16, 4), 255, np.uint8)  # slips twice as long as wide, lit by the side that they show
slips = []
for i in range(args.systems):
    card = motes.Sprite("image", image=paper, facing="orientation", blend="alpha", lit=True, shadow=0.5)
    slip = world.system(f"slips {i}", sprite=card)
    tone = colorsys.hsv_to_rgb(i / args.systems, 0.9, 0.95) if i % 4 < 3 else (0.95, 0.8, 0.35)
    slip.configure(size=motes.Uniform(0.09, 0.15), color=tone, lifetime=motes.Uniform(7, 9))
    slip.configure(orientation="random", spin=Sphere((0, 0, 0), 12, 4))
    slips.append(slip)

flying = ~Box((-99, -1, -99), (99, 0.03, 99))
with world, motes.Movie(f"{args.out}/confetti.mp4") as movie:
    for frame in world.frames(args.frames):
        for slip in slips:
            if frame % 72 in (2, 3, 4):  # both guns fire for an eighth of a second
                for foot, aim in guns:
                    slip.configure(velocity=Cone((0, 0, 0), np.multiply(21, aim).round(3), 9))
                    slip.burst(Sphere(np.add(foot, aim).round(3), 0.15), count=args.particles // 12)
            slip.configure(velocity=(0, -0.8, 0))
            slip.source(Box((-6, 6.3, -3), (6, 6.8, 4)), rate=args.particles / 9, jitter=True)
            slip.gravity((0, -9.8, 0), where=flying)
            slip.wind((0, 0, 0), drag=5)  # a slip of paper sinks at 2 m/s
            slip.curl_noise(11, scale=0.9, octaves=2, speed=0.6, where=flying)
            for solid in (floor, *steps):
                slip.bounce(solid, restitution=0, friction=0.9)
            slip.set(velocity=(0, 0, 0), spin=(0, 0, 0), where=~flying)
            slip.align(to=(0, 1, 0), rate=9, where=~flying)
            slip.kill_expired()
            slip.move()
        motes.script.end_frame(world, movie, args)
