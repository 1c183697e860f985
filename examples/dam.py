"""A dam breaks, and its water meets a pillar: python -m motes run -n 4 examples/dam.py."""

import numpy as np

import motes
from motes import column
from motes.shapes import Box, Plane

args = motes.script.options(__doc__, space="0,2.4", systems=1, particles=20000, frames=96, size="960x540")

# A basin, a column of water at its left end, and a pillar in its way. Metres.
deep, wide, long = 0.7, 0.6, 2.4
spacing = (0.6 * deep * wide / args.particles) ** (1 / 3)
basin = Box((0, 0, 0), (long, 9, wide))
pillar = Box((1.35, -1, 0.2), (1.5, 0.55, 0.4))
floor = motes.Solid(Plane((0, -0.6 * spacing, 0), (0, 1, 0)), (0.11, 0.1, 0.09))
camera = motes.Camera((2.1, 1.35, 2.9), (1.24, 0.3, 0.25), fov_deg=33)
renderer = motes.Renderer(
    *args.size,
    camera=camera,
    background=(0.34, 0.38, 0.42),
    objects=[floor, motes.Solid(pillar, (0.45, 0.3, 0.18))],
    sun=(-0.4, 0.8, 0.5),
)
world = motes.World(**args.world, substeps=16, dt=1 / 48, renderer=renderer)
water = world.system("water", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))

counts = [max(1, round(side / spacing)) for side in (0.6, deep, wide)]
x, y, z = (grid.ravel() for grid in np.mgrid[: counts[0], : counts[1], : counts[2]])
place = (np.stack([x, y, z], axis=1) + 0.5) * spacing
place += np.random.default_rng(args.seed).uniform(-0.02, 0.02, place.shape) * spacing

with world, motes.Movie(f"{args.out}/dam.mp4", fps=48) as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            water.configure(mass=1000 * spacing**3, size=1.3 * spacing)
            water.emit(position=place.round(5))
        water.gravity((0, -9.81, 0))
        water.fluid(radius=2 * spacing, rest_density=1000)
        for solid in (basin, pillar):
            water.bounce(solid, restitution=0, friction=0)
        water.move()
        # What is fast is white, as foam is.
        speed = column("velocity").length() / 2.5
        water.set(color=speed * speed * (0.7, 0.8, 0.8) + (0.02, 0.1, 0.22))
        motes.script.end_frame(world, movie, args)
