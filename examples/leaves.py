"""Leaves fall from a maple in autumn: python -m motes run -n 4 examples/leaves.py."""

import numpy as np

import motes
from motes.shapes import Box, Cylinder, Plane, Sphere

args = motes.script.options(__doc__, space="-6,6", systems=5, particles=1600, frames=240, size="960x540")


def leaf(pixels=128):
    """Draw a leaf with a stalk and veins, as RGBA."""
    y, x = np.mgrid[-1 : 1 : pixels * 1j, -1 : 1 : pixels * 1j]
    along = (y + 1) / 2  # 0 at the tip, 1 at the end of the stalk
    half = 0.6 * np.sin(np.pi * np.minimum(along / 0.9, 1) ** 0.8) ** 1.1 * (1 + 0.1 * np.sin(40 * along))
    blade, stalk = np.abs(x) < half, (np.abs(x) < 0.03) & (along > 0.85)
    rib = np.abs((along + 0.5 * np.abs(x)) * 8 % 1 - 0.5) > 0.45
    light = (1 - 0.3 * np.abs(x)) * np.where(rib | (np.abs(x) < 0.025), 0.75, 1)
    return (np.dstack([light, light, light, blade | stalk]) * 255).astype(np.uint8)


ground = Plane((0, 0, 0), (0, 1, 0))
trunk = Cylinder((2.4, 0, -1.4), (2.2, 6, -1.6), 0.34)
stones = [Sphere((x, 0.02, z), r) for x, z, r in ((-1.6, 0.6, 0.22), (-1.25, 0.45, 0.15), (0.9, 1.4, 0.18))]
hedge = Box((-9, 0, -5.4), (9, 0.9, -4.6))

solids = [motes.Solid(ground, (0.16, 0.19, 0.07)), motes.Solid(trunk, (0.11, 0.075, 0.05))]
solids += [motes.Solid(stone, (0.25, 0.24, 0.22)) for stone in stones]
solids += [motes.Solid(hedge, (0.04, 0.075, 0.025))]
camera = motes.Camera((-0.4, 1.25, 6.2), (0, 1.35, 0), fov_deg=34)
renderer = motes.Renderer(
    *args.size,
    camera=camera,
    background=(0.52, 0.66, 0.85),
    objects=solids,
    sun=(-0.5, 0.7, 0.45),
    exposure=1.1,
    shutter=0.4,
)
world = motes.World(**args.world, renderer=renderer)

picture = leaf()
tones = [(0.75, 0.06, 0.02), (0.85, 0.24, 0.02), (0.9, 0.45, 0.03), (0.65, 0.13, 0.02), (0.8, 0.6, 0.08)]
foliage = []
for i in range(args.systems):
    sprite = motes.Sprite("image", pixels=None, blend="alpha", image=picture)
    leaves = world.system(f"leaves {i}", capacity=args.particles, sprite=sprite)
    leaves.configure(
        color=tones[i % len(tones)], up=Sphere((0, 0, 0), 1), size=motes.Uniform((0.07,) * 3, (0.13,) * 3)
    )
    leaves.configure(rotational_velocity=Sphere((0, 0, 0), 3))
    foliage.append(leaves)

crown = Box((-5, 2.6, -4), (5, 4.2, 3.2))
with world, motes.Movie(f"{args.out}/leaves.mp4") as movie:
    for frame in world.frames(args.frames):
        for leaves in foliage:
            if frame == 0:  # many lie already, and some are on their way
                leaves.burst(Box((-6, 0.01, -4.4), (6, 0.02, 4)), count=args.particles * 5 // 8)
                leaves.burst(Box((-5, 0.1, -4), (5, 4, 3.2)), count=args.particles // 16)
            leaves.source(crown, rate=args.particles / 50, jitter=True)
            leaves.gravity((0, -9.8, 0), where=Box((-99, 0.03, -99), (99, 99, 99)))
            leaves.wind((0.35, -0.1, 0.05), drag=11)  # a leaf sinks at a little less than 1 m/s
            leaves.curl_noise(9, scale=1.1, octaves=2, speed=0.4, where=Box((-99, 0.2, -99), (99, 99, 99)))
            for solid in (ground, trunk, *stones):
                leaves.bounce(solid, restitution=0, friction=0.9)
            still = Box((-99, -1, -99), (99, 0.04, 99))
            leaves.set(velocity=(0, 0, 0), rotational_velocity=(0, 0, 0), where=still)
            leaves.move()
        motes.script.end_frame(world, movie, args)
