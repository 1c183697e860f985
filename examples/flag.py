"""A flag flies in a wind that grows until it tears: python -m motes run -n 4 examples/flag.py."""

import motes
from motes.shapes import Box, Cylinder, Plane, Sphere

args = motes.script.options(__doc__, space="-0.2,3.2", systems=1, particles=6000, frames=192, size="960x540")

rows = max(4, round((args.particles / 1.5) ** 0.5))
columns = max(6, args.particles // rows)
height, width = 1.8, 2.7  # metres
pole = Cylinder((-0.05, -3.5, 0), (-0.05, 1.2, 0), 0.045)
solids = [motes.Solid(Plane((0, -3.5, 0), (0, 1, 0)), (0.09, 0.12, 0.05))]
solids += [motes.Solid(pole, (0.25, 0.24, 0.22))]
solids += [motes.Solid(Sphere((-0.05, 1.22, 0), 0.09), (0.6, 0.4, 0.08))]
camera = motes.Camera((2.6, -1.2, 5.2), (1.15, -0.15, 0), fov_deg=36)
renderer = motes.Renderer(
    *args.size, camera=camera, background=(0.24, 0.4, 0.62), objects=solids, sun=(0.5, 0.7, 0.6)
)
# Ties pull once per sub-step: the more sub-steps, the stiffer the cloth.
world = motes.World(**args.world, substeps=30, renderer=renderer)
flag = world.system("flag", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))

stripe = height / 3
tones = [(0.78, 0.2, 0.02), (0.85, 0.8, 0.7), (0.02, 0.22, 0.24)]

with world, motes.Movie(f"{args.out}/flag.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            flag.configure(size=1.5 * height / rows)
            pins = [(row, 0) for row in range(0, rows, 3)]
            ties = flag.cloth(rows, columns, (0, 1, 0), (0, -height, 0), (width, 0, 0.05), pinned=pins)
            for number, tone in enumerate(tones):
                top = 1 - number * stripe
                flag.set(color=tone, where=Box((-1, top - stripe - 0.001, -9), (9, top + 0.001, 9)))
        storm = min(1, frame / (0.8 * args.frames))
        flag.gravity((0, -9.81, 0))
        flag.wind((9 + 12 * storm, storm, 1.5), drag=1.2)
        flag.curl_noise(9 + 45 * storm, scale=1.1, octaves=2, speed=3)
        flag.tie(ties, bend=1e-4, damping=3, break_at=1.9)
        flag.move()
        motes.script.end_frame(world, movie, args)
