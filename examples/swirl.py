"""Streams swirl about an axis: python -m motes run -n 4 examples/swirl.py."""

import colorsys

import numpy as np

import motes
from motes.shapes import Disc, Sphere

args = motes.script.options(__doc__, space="-3,3", systems=6, particles=30_000, frames=168, size="960x540")

camera = motes.Camera((1.5, 3.9, 8.9), (0, 1.75, 0), fov_deg=38)
pedestal = Disc((0, -0.02, 0), (0, 1, 0), 3.2, 2.9)
renderer = motes.Renderer(
    *args.size,
    camera=camera,
    background=(0.003, 0.003, 0.008),
    objects=[motes.Solid(pedestal, (0.25, 0.28, 0.4), light=0.15)],
    sun=(0, 0, 0),
    bloom=0.25,
    shutter=0.5,
)
world = motes.World(**args.world, substeps=4, renderer=renderer)

# Each stream enters at the rim, at right angles to the radius. The axis pulls, so it circles while it rises.
life, streams = 4.2, []
for i in range(args.systems):
    angle = 2 * np.pi * i / args.systems
    out = np.array([np.cos(angle), 0, np.sin(angle)])
    across = np.array([-np.sin(angle), 0, np.cos(angle)])
    stream = world.system(f"stream {i}", capacity=args.particles, sprite=motes.Sprite(pixels=None))
    color = colorsys.hsv_to_rgb((0.53 + 0.45 * i / args.systems) % 1, 0.8, 1)
    stream.configure(lifetime=life, size=motes.Uniform((0.008,) * 3, (0.02,) * 3), color=color)
    stream.configure(velocity=Sphere((3.5 * across + (0, 0.3, 0)).round(4), 0.03))
    streams.append((stream, Sphere((2.6 * out + (0, 0.05, 0)).round(4), 0.07)))

light = min(1, 40_000 / args.particles)
with world, motes.Movie(f"{args.out}/swirl.mp4") as movie:
    for _ in world.frames(args.frames):
        for stream, mouth in streams:
            stream.source(mouth, rate=0.98 * args.particles / life, jitter=True)
            stream.orbit_line((0, 0, 0), axis=(0, 1, 0), magnitude=36, epsilon=0.25)
            stream.gravity((0, 0.28, 0))
            stream.damping((0.88, 1, 0.88))
            stream.random_acceleration(Sphere((0, 0, 0), 0.2))
            stream.alpha_over_life([(0, 0), (0.06, light), (0.6, 0.8 * light), (1, 0)])
            stream.kill_expired()
            stream.move()
        motes.script.end_frame(world, movie, args)
