"""Leaves fall from a maple in autumn: python -m motes run -n 4 examples/leaves.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Cylinder, Plane, Sphere, Triangle, Union

args = motes.script.options(__doc__, space="-6,6", systems=2, particles=4000, frames=240, size="960x540")


def leaf(lobes, sharp, pixels=64):
    """Draw a leaf with veins and a stalk, as RGBA; particles tint it."""
    y, x = np.mgrid[1 : -1 : pixels * 1j, -1 : 1 : pixels * 1j]
    angle, far = np.arctan2(x, y + 0.15), np.hypot(x, y + 0.15)
    lobe = np.abs(np.cos(lobes / 2 * angle))
    blade = far < (0.4 + 0.6 * lobe**sharp) * (1 - 0.14 * np.abs(angle))
    stalk = (np.abs(x) < 0.035) & (y < 0)
    light = np.where((lobe > 1 - 0.004 / np.maximum(far, 0.05) ** 2) | stalk, 0.72, 1 - 0.25 * far)
    return (np.dstack([light, light, light, blade | stalk]).clip(0, 1) * 255).astype(np.uint8)


ground = Plane((0, 0, 0), (0, 1, 0))
rng = np.random.default_rng(args.seed)
grass = rng.integers(110, 255, (64, 64, 1)).repeat(3, 2).astype(np.uint8)
bark = (rng.integers(120, 220, (1, 32, 1)) + rng.integers(-40, 35, (32, 32, 1))).repeat(3, 2).astype(np.uint8)
limbs = "0 -.1 0 .1 2.6 0 .24  .1 2.5 0 -1.3 4.4 .3 .12  .1 2.5 0 1.2 4.6 -.3 .13  .1 2.5 0 .2 5.2 .1 .14"
limbs += "  0 1.9 0 1.7 3.2 .7 .08  0 2.1 0 -1.6 3.2 -.6 .08"
tree = Union(*(Cylinder(a[:3], a[3:6], a[6]) for a in np.array(limbs.split(), float).reshape(-1, 7)))
balls = "-1.3 4.3 .3 1.25  1.3 4.4 -.3 1.3  .1 5.4 0 1.35  1.6 3.3 .6 .8  -1.6 3.2 -.6 .85  .1 4.1 .9 1"
crown = Union(*(Sphere(a[:3], a[3]) for a in np.array(balls.split(), float).reshape(-1, 4)))
stones = [Sphere((x, 0.02, z), r) for x, z, r in ((-2.6, 1.6, 0.3), (-2.15, 1.75, 0.18), (2.3, 2.4, 0.22))]
solids = [motes.Solid(ground, (0.24, 0.3, 0.03), image=grass, scale=2)]
solids += [motes.Solid(tree, (0.2, 0.13, 0.09), image=bark, scale=0.7)]
solids += [motes.Solid(stone, (0.3, 0.29, 0.27)) for stone in stones]
hills = (((-30, -19, -60), 26, (0.2, 0.12, 0.05)), ((25, -32, -75), 42, (0.17, 0.13, 0.06)))
solids += [motes.Solid(Sphere(at, wide), color) for at, wide, color in hills]
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((0.6, 1.6, 9.8), (1.1, 2.85, 0), fov_deg=36),
    background=motes.Gradient((0.5, 0.53, 0.55), (0.05, 0.16, 0.5), (0.16, 0.15, 0.08)),
    fog=((0.46, 0.47, 0.46), 400),
    objects=solids,
    sun=(-0.75, 0.55, 0.35),
    exposure=1.5,
    shutter=0.4,
)
world = motes.World(**args.world, renderer=renderer)

pictures = [leaf(5, 1.6), leaf(5, 1), leaf(3, 1.2), leaf(7, 1.4)]
card = motes.Sprite("image", image=pictures, facing="orientation", blend="alpha", lit=True, shadow=0.5)
foliage = []
for i in range(args.systems):
    leaves = world.system(f"leaves {i}", sprite=card, attributes={"loose": 1})
    red, gold = (
        ((0.69, 0.03, 0.01), (0.9, 0.58, 0.03)) if i % 2 == 0 else ((0.48, 0.01, 0.01), (0.87, 0.35, 0.01))
    )
    leaves.configure(color=Triangle(red, (0.85, 0.14, 0.01), gold))
    leaves.configure(orientation="random", size=motes.Uniform(0.14, 0.26))
    foliage.append(leaves)

loose = column("loose") > 0
beds = [Plane((0, 0.01, 0), (0, 1, 0)), *(Sphere(stone.center, stone.radius + 0.01) for stone in stones)]
with world, motes.Movie(f"{args.out}/leaves.mp4") as movie:
    for frame in world.frames(args.frames):
        for leaves in foliage:
            if frame == 0:  # most hang on the tree or lie on the ground; some are falling
                leaves.configure(loose=0)
                leaves.burst(crown, count=args.particles * 5 // 8)
                leaves.burst(Cylinder((0.6, 0.01, 0.3), (0.6, 0.03, 0.3), 4.5), count=args.particles // 4)
                leaves.align(to=(0, 1, 0), where=Box((-99, 0, -99), (99, 0.05, 99)))
                leaves.configure(loose=1, spin=Sphere((0, 0, 0), 6, 2))
                leaves.burst(Box((-2, 0.2, -2), (4, 4, 2.5)), count=args.particles // 50)
            leaves.source(crown, rate=args.particles / 40, jitter=True)
            leaves.gravity((0, -9.8, 0), where=loose)
            leaves.wind((0.7, -0.1, 0.1), drag=1.6 / column("size").x, where=loose)  # large ones sink faster
            leaves.curl_noise(9, scale=1.1, octaves=2, speed=0.4, where=loose)
            leaves.bounce(beds, restitution=0, friction=0.9, hits=True)
            leaves.rest(0.4, angle_deg=12)  # lies on grass and stones
            leaves.move()
        motes.script.end_frame(world, movie, args)
