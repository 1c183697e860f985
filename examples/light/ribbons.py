"""Ribbons of light in a slow whirl, and two of silk: python -m motes run -n 4 examples/light/ribbons.py."""

import motes
from motes import column
from motes.expressions import cross
from motes.shapes import Plane, Sphere

args = motes.script.options(__doc__, space="-3,3", systems=1, particles=160, frames=144, size="960x540")

renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((0, 1.3, 7), (0, 0.05, 0), fov_deg=36),
    background=motes.Gradient((0.02, 0.025, 0.06), (0.002, 0.002, 0.012), (0.006, 0.006, 0.012)),
    objects=[motes.Solid(Plane((0, -1.7, 0), (0, 1, 0)), (0.05, 0.055, 0.08))],
    sun=(0.4, 0.9, 0.5),
    bloom=0.15,
)
world = motes.World(**args.world, renderer=renderer)
glow = world.system("glow", sprite=motes.Sprite("ribbon", width=0.035, length=1.4))
silk = world.system("silk", sprite=motes.Sprite("ribbon", width=0.16, length=2, blend="alpha", lit=True))
COLORS = ("#ff5a36", "#ffb347", "#5ad1ff", "#9d6bff")

with world, motes.Movie(f"{args.out}/ribbons.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            for color in COLORS:
                glow.configure(color=color, alpha=0.7)
                glow.burst(Sphere((0, 0, 0), 1.5), count=args.particles // len(COLORS))
            silk.configure(color=(0.9, 0.85, 1))
            silk.burst(Sphere((0, 0, 0), 1), count=2)
        for system, push in ((glow, 7.5), (silk, 5)):
            # Around the middle, and back to it; neighbours have the same noise and flow side by side.
            place = column("position")
            around = cross((0, 3.2, 0), place) - place * (2.4, 5, 2.4)
            system.set(velocity=column("velocity") + around * world.dt)
            system.curl_noise(push, scale=1.5, octaves=1, speed=0.35)
            system.wind((0, 0, 0), drag=2)
            system.move()
        motes.script.end_frame(world, movie, args)
