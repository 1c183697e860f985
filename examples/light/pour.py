"""Water is poured into a glass: python -m motes run -n 4 examples/light/pour.py."""

import numpy as np

import motes
from motes.shapes import Box, Cylinder, Disc, Plane

args = motes.script.options(
    __doc__, space="-0.05,0.05", systems=1, particles=9000, frames=240, size="960x540"
)

# A tumbler, in metres, and a jug's mouth above it. The film is in slow motion.
wide, high, floor = 0.034, 0.1, 0.008
outline = [(0.033, 0.0), (0.037, 0.003), (0.038, high), (wide + 0.001, high), (wide, floor + 0.002)]
outline = [(0.0, 0.0), *outline, (wide - 0.003, floor), (0.0, floor)]
angles = np.arange(96) * (2 * np.pi / 96)
points = [(r * np.cos(a), y, r * np.sin(a)) for a in angles for r, y in outline]
n = len(outline)
quads = [(i * n + k, (i + 1) % 96 * n + k) for i in range(96) for k in range(n - 1)]
tumbler = motes.Mesh(np.round(points, 6), [t for p, q in quads for t in ((p, q, p + 1), (q, q + 1, p + 1))])
inside = Cylinder((0, floor, 0), (0, 1, 0), wide)
spacing = (np.pi * wide**2 * 0.075 / args.particles) ** (1 / 3)

rng = np.random.default_rng(args.seed)
wood = rng.integers(150, 230, (1, 64, 1)) + rng.integers(-25, 25, (64, 64, 1))
wood = wood.repeat(3, 2).astype(np.uint8)
solids = [
    motes.Solid(Plane((0, 0, 0), (0, 1, 0)), (0.34, 0.2, 0.1), image=wood, scale=0.12, roughness=0.4),
    motes.Solid(Box((-0.3, 0, -0.2), (0.3, 0.05, -0.19)), (0.5, 0.12, 0.06)),
    motes.Solid(Cylinder((0.09, 0, -0.06), (0.09, 0.05, -0.06), 0.022), (0.9, 0.55, 0.1)),
    motes.Solid(tumbler, glass=1.5),
]
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((0.016, 0.11, 0.24), (0.008, 0.06, 0), fov_deg=32),
    background=motes.Gradient((0.66, 0.64, 0.6), (0.3, 0.4, 0.55), (0.18, 0.14, 0.1)),
    objects=solids,
    sun=(-0.6, 0.7, -0.35),
    sun_color=(1, 0.9, 0.75),
    sun_size=2,
    occlusion=1,
    exposure=1.15,
)
world = motes.World(**args.world, dt=1 / 96, substeps=12, renderer=renderer)
water = world.system("water", sprite=motes.Sprite("surface", radius=0.8 * spacing))
water.configure(mass=1000 * spacing**3, color=(0.35, 0.75, 0.85), alpha=0.06, velocity=(0, -0.7, 0))
mouth, pouring = Disc((0.008, 0.13, 0.004), (0, 1, 0), 0.007), 2  # s

with world, motes.Movie(f"{args.out}/pour.mp4") as movie:
    for _ in world.frames(args.frames):
        if world.time < pouring:
            water.source(mouth, rate=args.particles / pouring, jitter=True)
        water.gravity((0, -9.81, 0))
        water.fluid(radius=2 * spacing, rest_density=1000, cohesion=2)
        water.bounce(inside, restitution=0, friction=0)
        water.move()
        motes.script.end_frame(world, movie, args)
