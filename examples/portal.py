"""A ring of sparks opens a portal: python -m motes run -n 4 examples/portal.py."""

import numpy as np

import motes
from motes.expressions import clamp, column, mix, noise, sqrt, time
from motes.shapes import Box, Disc, Plane, Sphere, Union

args = motes.script.options(__doc__, space="-3,3", systems=2, particles=9_000, frames=144, size="960x540")

floor = Plane((0, 0, 0), (0, 1, 0))
stones = [Box((x, 0, -2.4 - 0.1 * (x % 2)), (x + 0.96, 3.9, -2)) for x in range(-7, 7)]
steps = Union(Box((-1.7, 0, -0.7), (1.7, 0.12, 0.7)), Box((-1.3, 0.12, -0.5), (1.3, 0.24, 0.5)))
solids = [motes.Solid(floor, (0.09, 0.085, 0.08)), motes.Solid(steps, (0.12, 0.115, 0.11))]
solids += [motes.Solid(stone, (0.10, 0.09, 0.085)) for stone in stones]
middle, radius, arms = np.array([0, 1.72, 0]), 1.3, 7
camera = motes.Camera((1.3, 1.5, 6.6), (0, 1.55, 0), fov_deg=34)
renderer = motes.Renderer(
    *args.size, camera=camera, background=(0.002, 0.002, 0.004), sun=(0, 0, 0), bloom=0.3, shutter=0.6
)
world = motes.World(**args.world, substeps=3, renderer=renderer)

rings = []
for i in range(args.systems):
    sparks = world.system(f"sparks {i}", capacity=args.particles, sprite=motes.Sprite(pixels=None))
    sparks.configure(lifetime=motes.Uniform(0.08, 0.9), size=motes.Uniform((0.006,) * 3, (0.013,) * 3))
    rings.append(sparks)
veil = world.system("veil", sprite=motes.Sprite(pixels=None))
veil.configure(size=0.04)

place = column("position")
with world, motes.Movie(f"{args.out}/portal.mp4") as movie:
    for frame in world.frames(args.frames):
        open_ = min(1.0, 0.15 + world.time / 0.9)  # it opens in a second
        r = radius * open_
        turn = 5.2 * world.time
        for i, sparks in enumerate(rings):
            for arm in range(arms):
                angle = turn + 2 * np.pi * (arm + 0.5 * i) / arms
                out = np.array([np.cos(angle), np.sin(angle), 0])
                along = np.array([-np.sin(angle), np.cos(angle), 0])
                spot, before = (
                    middle + r * np.array([np.cos(a), np.sin(a), 0]) for a in (angle, angle - 5.2 * world.dt)
                )
                sparks.configure(velocity=Sphere((4.6 * along + 0.5 * out).round(4), 1.0))
                sparks.source(
                    Sphere(spot.round(4), 0.035),
                    rate=args.particles / arms / 0.5,
                    jitter=True,
                    moving_from=Sphere(before.round(4), 0.035),
                )
            sparks.gravity((0, -7, 0))
            sparks.wind((0, 0, 0), drag=2)
            for solid in (floor, steps):
                sparks.bounce(solid, restitution=0.4, friction=0.2)
            sparks.color_over_life(
                [(0, (6, 1.4, 0.2)), (0.2, (4.5, 0.45, 0.03)), (0.7, (3, 0.16, 0.005)), (1, (0.8, 0.03, 0))]
            )
            sparks.kill_expired()
            sparks.move()
        if frame == 0:
            veil.burst(Disc(middle, (0, 0, 1), radius), count=10 * args.particles)
        # Another sky behind the ring: clouds of blue and violet that drift.
        sky = clamp(
            0.55 + 1.1 * noise(place * (1.1, 1.6, 0) + time() * (0.25, 0, 0), 0.3 * time(), octaves=4), 0, 1
        )
        offset = place - tuple(middle)
        rim = sqrt(offset.x * offset.x + offset.y * offset.y) / r
        inside = clamp((1.0 - rim) * 12, 0, 1)
        veil.set(color=mix((0.002, 0.006, 0.06), (0.10, 0.16, 0.6), sky * sky), alpha=0.10 * inside)
        veil.move()
        flicker = 0.85 + 0.15 * (frame * 5 % 7) / 6
        renderer.lights = [
            motes.Light(middle + (x, y, 0.3), (1, 0.42, 0.1), power=0.35 * flicker * open_)
            for x, y in ((-1.2, 0), (1.2, 0), (0, -1.2), (0, 1.2))
        ]
        renderer.objects = solids
        motes.script.end_frame(world, movie, args)
