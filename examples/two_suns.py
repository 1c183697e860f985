"""Dust orbits two suns: python -m motes run -n 4 examples/two_suns.py."""

import numpy as np

import motes
from motes.expressions import clamp, column, mix
from motes.shapes import Sphere

args = motes.script.options(__doc__, space="-4,4", systems=2, particles=90_000, frames=192, size="960x540")

suns = [(-1.5, 0, 0), (1.5, 0, 0)]
pull, soft = 7.0, 0.06  # m3/s2, m2
solids = [
    motes.Solid(Sphere(sun, 0.13), tone, light=7)
    for sun, tone in zip(suns, ((1, 0.5, 0.15), (0.35, 0.6, 1)), strict=True)
]
camera = motes.Camera((0, 3.3, 5.6), (0, -0.25, 0), fov_deg=36)
renderer = motes.Renderer(
    *args.size,
    camera=camera,
    background=(0.002, 0.002, 0.005),
    objects=solids,
    sun=(0, 0, 0),
    bloom=0.3,
    shutter=0.4,
)
world = motes.World(**args.world, dt=1 / 48, substeps=2, renderer=renderer)

# Two flat rings, one around each sun. Each sun tears away the outer dust of the other's ring.
dice = np.random.default_rng(args.seed)
rings = []
for sun, way in zip(suns, (1, -1), strict=True):
    r = np.sqrt(dice.uniform(0.35**2, 1.75**2, args.particles))
    angle = dice.uniform(0, 2 * np.pi, args.particles)
    out = np.stack([np.cos(angle), dice.normal(0, 0.02, args.particles), np.sin(angle)], axis=1)
    across = way * np.stack([-np.sin(angle), 0 * angle, np.cos(angle)], axis=1)
    speed = np.sqrt(pull * r / (r * r + soft))
    rings.append((np.add(sun, r[:, None] * out).round(4), (speed[:, None] * across).round(4)))

dusts = []
for i in range(args.systems):
    dust = world.system(f"dust {i}", sprite=motes.Sprite(pixels=None))
    dust.configure(size=motes.Uniform((0.006,) * 3, (0.016,) * 3), alpha=min(1, 60_000 / args.particles))
    dusts.append(dust)

speed = column("velocity").length()
with world, motes.Movie(f"{args.out}/two_suns.mp4") as movie:
    for frame in world.frames(args.frames):
        for i, dust in enumerate(dusts):
            if frame == 0:
                position, velocity = rings[i % 2]
                dust.emit(position=position, velocity=velocity)
            for sun in suns:
                dust.orbit_point(sun, magnitude=pull, epsilon=soft)
                dust.sink(Sphere(sun, 0.15))
            # Falling dust is hot, climbing dust is cold; each ring has its own colours.
            slow, fast = [((0.45, 0.06, 0.10), (1.5, 0.75, 0.25)), ((0.03, 0.10, 0.5), (0.35, 0.9, 1.4))][
                i % 2
            ]
            dust.set(color=mix(slow, fast, clamp((speed - 1) / 5, 0, 1)))
            dust.move()
        motes.script.end_frame(world, movie, args)
