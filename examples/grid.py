"""Waves run through a grid of balls: python -m motes run -n 4 examples/grid.py."""

import numpy as np

import motes
from motes.expressions import column, exp, mix, noise, sin, smoothstep, sqrt, time
from motes.shapes import Plane

args = motes.script.options(__doc__, space="-6,6", systems=1, particles=9216, frames=144, size="960x540")

# A square of balls in the plane, moved up and down by two sources of waves.
side = max(2, int(args.particles**0.5))
gap = 11.5 / side
x, z = (axis.ravel() for axis in np.meshgrid(*[(np.arange(side) - (side - 1) / 2) * gap] * 2))
rest = np.stack([x, 0 * x, z], axis=1).round(4)

ground = Plane((0, -1.6, 0), (0, 1, 0))
camera = motes.Camera((6.8, 5.6, 9.4), (0.2, -0.55, 0.3), fov_deg=34)
renderer = motes.Renderer(
    *args.size,
    camera=camera,
    background=(0.03, 0.035, 0.05),
    objects=[motes.Solid(ground, (0.03, 0.035, 0.05))],
    sun=(-0.5, 0.65, 0.35),
)
world = motes.World(**args.world, renderer=renderer)
balls = world.system("balls", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))

home = column("position_b")
height = 0.0
for a, b, pitch in ((-2.4, 1.6, 2.9), (2.8, -1.2, 2.3)):
    far = sqrt((home.x - a) * (home.x - a) + (home.z - b) * (home.z - b))
    height = height + 0.75 * sin(pitch * far - 3.6 * time()) * exp(-0.22 * far)
height = height + 0.45 * noise(home * (0.35, 0, 0.35), 0.25 * time())

with world, motes.Movie(f"{args.out}/grid.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            balls.emit(position=rest)
        balls.set(position=home * (1, 0, 1) + height * (0, 1, 0))
        level = column("position").y
        low = mix((0.02, 0.03, 0.25), (0.0, 0.42, 0.55), smoothstep(-0.8, 0, level))
        balls.set(color=mix(low, (1, 0.45, 0.12), smoothstep(0.05, 0.8, level)))
        balls.set(size=gap * (0.72 + 0.32 * level) * (1, 1, 1))
        balls.move()
        motes.script.end_frame(world, movie, args)
