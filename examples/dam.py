"""A dam breaks, and its water meets a pillar: python -m motes run -n 4 examples/dam.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Plane

args = motes.script.options(__doc__, space="0,2.4", systems=1, particles=20000, frames=96, size="960x540")

# A basin, a column of water at its left end, and a pillar in its way. Metres.
deep, wide, long = 0.7, 0.6, 2.4
spacing = (0.6 * deep * wide / args.particles) ** (1 / 3)
basin = Box((0, 0, 0), (long, 9, wide))
pillar = Box((1.35, -1, 0.2), (1.5, 0.55, 0.4))
edge = -0.6 * spacing
tiles = np.where((np.mgrid[:64, :64] % 16 == 0).any(0), 120, 255)[:, :, None].repeat(3, 2).astype(np.uint8)
solids = [
    motes.Solid(Plane((0, edge - 0.05, 0), (0, 1, 0)), (0.42, 0.4, 0.36), image=tiles, scale=1.2),
    motes.Solid(
        Box((edge - 0.06, edge - 0.05, edge - 0.06), (long - edge + 0.06, edge, wide - edge)),
        (0.5, 0.52, 0.52),
    ),
    motes.Solid(Box((edge - 0.06, edge, edge - 0.06), (long - edge + 0.06, 0.8, edge)), (0.6, 0.56, 0.48)),
    motes.Solid(Box((edge - 0.06, edge, edge), (edge, 0.8, wide - edge)), (0.6, 0.56, 0.48)),
    motes.Solid(Box((long - edge, edge, edge), (long - edge + 0.06, 0.8, wide - edge)), (0.6, 0.56, 0.48)),
    motes.Solid(pillar, (0.65, 0.24, 0.1)),
]
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((1.9, 1.15, 2.6), (1.22, 0.24, 0.25), fov_deg=36),
    background=motes.Gradient((0.65, 0.62, 0.58), (0.22, 0.36, 0.6), (0.3, 0.28, 0.25)),
    objects=solids,
    sun=(-0.45, 0.75, 0.6),
    shutter=0.3,
)
world = motes.World(**args.world, substeps=16, dt=1 / 48, renderer=renderer)
skin = motes.Sprite("surface", radius=0.85 * spacing, foam=4)
water = world.system("water", sprite=skin)
spray = world.system(
    "spray", sprite=motes.Sprite(pixels=None, blend="alpha", softness=0.02, lit=True, shadow=0.3)
)
spray.configure(lifetime=motes.Uniform(0.08, 0.3), size=1.1 * spacing, color=(0.95, 0.97, 1))

counts = [max(1, round(side / spacing)) for side in (0.6, deep, wide)]
x, y, z = (grid.ravel() for grid in np.mgrid[: counts[0], : counts[1], : counts[2]])
place = (np.stack([x, y, z], axis=1) + 0.5) * spacing
place += np.random.default_rng(args.seed).uniform(-0.02, 0.02, place.shape) * spacing

with world, motes.Movie(f"{args.out}/dam.mp4", fps=48) as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            water.configure(mass=1000 * spacing**3, color=(0.08, 0.36, 0.42), alpha=0.5)
            water.emit(position=place.round(5))
        water.gravity((0, -9.81, 0))
        water.fluid(radius=2 * spacing, rest_density=1000)
        for solid in (basin, pillar):
            water.bounce(solid, restitution=0, friction=0)
        water.move()
        speed = column("velocity").length()  # fast water throws spray
        water.spawn(
            spray,
            on="frame",
            count=1,
            inherit_velocity=0.9,
            where=(speed > 3) & (column("position").y > 0.1),
        )
        spray.gravity((0, -9.81, 0))
        spray.wind((0, 0, 0), drag=1.5)
        spray.alpha_over_life([(0, 0.4), (1, 0)])
        spray.size_over_life([(0, 1.2 * spacing), (1, 2.6 * spacing)])
        spray.kill_expired()
        spray.move()
        motes.script.end_frame(world, movie, args)
