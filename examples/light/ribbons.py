"""Ribbons of light and bands of silk in a slow whirl: python -m motes run -n 4 examples/light/ribbons.py."""

import numpy as np

import motes
from motes.expressions import column, cross
from motes.shapes import Plane, Sphere

args = motes.script.options(__doc__, space="-3,3", systems=1, particles=120, frames=144, size="960x540")

floor = motes.Solid(Plane((0, -1.5, 0), (0, 1, 0)), (0.07, 0.075, 0.1))
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((0, 1, 6.2), (0, 0, 0), fov_deg=36),
    background=motes.Gradient((0.02, 0.025, 0.06), (0.002, 0.002, 0.012), (0.004, 0.004, 0.008)),
    objects=[floor],
    sun=(0, 0, 0),
    bloom=0.2,
)
world = motes.World(**args.world, renderer=renderer)
glow = world.system("glow", sprite=motes.Sprite("ribbon", width=0.035, length=1.5))
silk = world.system("silk", sprite=motes.Sprite("ribbon", width=0.07, length=2.2, blend="alpha", lit=True))
COLORS = ("#ff5a36", "#ffb347", "#5ad1ff", "#9d6bff")
# A band is many threads that are born and stay side by side; its colour changes across it.
across = np.linspace(-1, 1, max(2, args.particles // 2))[:, None]
BANDS = [
    ((1.1, 0.6, 0), (0.1, 0.5, 0.1), (0.75, 0.05, 0.12), (0.95, 0.45, 0.08)),
    ((-1.1, -0.5, 0), (0.1, -0.5, 0.1), (0.02, 0.4, 0.5), (0.25, 0.1, 0.75)),
]

with world, motes.Movie(f"{args.out}/ribbons.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            for color in COLORS:
                glow.configure(color=color, alpha=0.6)
                glow.burst(Sphere((0, 0, 0), 1.5), count=args.particles // len(COLORS))
            silk.configure(alpha=0.95)
            for middle, side, low, high in BANDS:
                tones = (1 - across) / 2 * low + (1 + across) / 2 * high
                silk.emit(position=(middle + across * side).round(4), color=tones.round(4))
        turn = 0.9 * world.time
        lamps = [((1.7 * np.cos(turn + k), 1 - k / 3, 1.7 * np.sin(turn + k)), k) for k in (0, 3)]
        renderer.lights = [
            motes.Light(np.round(at, 3), COLORS[k] if k else "#ff8040", power=1.2) for at, k in lamps
        ]
        renderer.lights += (motes.Light((0, 2.5, 4), (0.95, 0.95, 1), power=30),)
        for system, push, flat, wide in ((glow, 7.5, 5, 1.5), (silk, 5, 3, 2.8)):
            # Circle the middle and return to it; neighbours have the same noise, so they stay side by side.
            place = column("position")
            around = cross((0, 3.2, 0), place) - place * (2.4, flat, 2.4)
            system.set(velocity=column("velocity") + around * world.dt)
            system.curl_noise(push, scale=wide, octaves=1, speed=0.35)
            system.wind((0, 0, 0), drag=2)
            system.move()
        motes.script.end_frame(world, movie, args)
