"""Ribbons of light that wind around each other: python -m motes run -n 4 examples/light/ribbons.py."""

import motes
from motes import column
from motes.shapes import Plane, Sphere

args = motes.script.options(__doc__, space="-3,3", systems=1, particles=90, frames=144, size="960x540")

floor = motes.Solid(Plane((0, -1.6, 0), (0, 1, 0)), (0.035, 0.04, 0.06))
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((0, 0.9, 7.2), (0, 0.1, 0), fov_deg=36),
    background=motes.Gradient((0.03, 0.03, 0.07), (0.004, 0.004, 0.015), (0.01, 0.01, 0.02)),
    objects=[floor],
    lights=[motes.Light((0, 0.4, 0), (1, 0.6, 0.9), 0.5)],
    sun=(0, 0, 0),
    bloom=0.12,
)
world = motes.World(**args.world, renderer=renderer)
glow = world.system("glow", sprite=motes.Sprite("ribbon", width=0.075, length=1.6))
silk = world.system("silk", sprite=motes.Sprite("ribbon", width=0.22, length=2.2, blend="alpha", lit=True))
COLORS = ("#ff5a36", "#ffb347", "#5ad1ff", "#9d6bff", "#ff6fb5")

with world, motes.Movie(f"{args.out}/ribbons.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            for number, color in enumerate(COLORS):
                glow.configure(color=color, velocity=Sphere((0, 0, 0), 1.5))
                glow.burst(Sphere((0, 0, 0), 1.6), count=args.particles // len(COLORS) + (number == 0))
            silk.configure(color="#dfe6ff", velocity=Sphere((0, 0, 0), 1))
            silk.burst(Sphere((0, 0, 0), 2), count=max(1, args.particles // 8))
        for system, pull in ((glow, 2.6), (silk, 1.3)):
            around = (column("position") * (1, 1.6, 1)) * -pull
            system.set(velocity=column("velocity") + around * world.dt)
            system.curl_noise(5.5, scale=1.1, octaves=2, speed=0.25)
            system.wind((0, 0, 0), drag=0.8)
            system.move()
        motes.script.end_frame(world, movie, args)
