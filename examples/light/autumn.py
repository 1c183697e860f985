"""Autumn leaves flutter to the ground before a low sun: python -m motes run -n 4 examples/light/autumn.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Cylinder, Plane, Sphere, Triangle

args = motes.script.options(__doc__, space="-3,3", systems=2, particles=2600, frames=144, size="960x540")
rng = np.random.default_rng(args.seed)

# The right halves of two leaves' outlines, from the stalk to the tip: x, y.
MAPLE = (
    ".02 -.6  .02 0  .3 -.2  .34 -.02  .66 .02  .5 .18  .85 .55  .5 .5  .28 .42  .34 .74  .2 .72  .01 1.05"
)
BEECH = ".04 -.45  .04 -.05  .22 .02  .38 .28  .37 .52  .22 .82  .01 1.1"


def leaf(half, curl):
    """Make a leaf from triangles around its middle, bent, and folded along its rib."""
    right = np.array(half.split(), float).reshape(-1, 2)
    x, y = np.concatenate([[(0, 0.15)], right, right[::-1] * (-1, 1)]).T
    z = curl * (0.5 * x * x + 0.35 * y * y) + 0.25 * np.abs(x)
    fan = [(0, k, k % (len(x) - 1) + 1) for k in range(1, len(x))]
    return motes.Mesh(np.stack([x, y - 0.2, z], axis=1).round(3) * 0.5, fan)


ground = Plane((0, 0, 0), (0, 1, 0))
soil = rng.integers(90, 255, (64, 64, 1)).repeat(3, 2).astype(np.uint8)
bark = (rng.integers(90, 200, (1, 48, 1)) + rng.integers(-50, 50, (24, 48, 1))).repeat(3, 2).astype(np.uint8)
trees = (
    "-1.2 -1.5 .2  1.75 -2.6 .27  .45 -5.5 .26  -3.4 -5.5 .3  4.4 -7 .35  -1 -9 .3  -6 -10 .4  2.4 -11 .35"
)
trees += "  7.5 -12 .4  -3.4 -14 .35  .9 -17 .35  -8 -15 .4  5.5 -17 .4"
solids = [motes.Solid(ground, (0.17, 0.1, 0.05), image=soil, scale=0.9)]
for x, z, wide in np.array(trees.split(), float).reshape(-1, 3):
    trunk = Cylinder((x, -0.1, z), (x + 0.4, 30, z), wide)
    solids.append(motes.Solid(trunk, (0.09, 0.06, 0.045), image=bark, scale=0.5))

# The sky is a picture: a glow around a visible sun that shines toward the camera.
sun = np.array([-0.17, 0.22, -0.96])
down, right = np.mgrid[0.5:128, 0.5:256] * np.pi / 128
sky = np.stack([-np.sin(down) * np.sin(right), np.cos(down), np.sin(down) * np.cos(right)], axis=2)
away = (1 - sky @ sun).clip(0)[:, :, None]
sky = np.array([0.55, 0.22, 0.05]) / (1 + 9 * away) + np.array([30, 13, 3]) / (1 + (900 * away) ** 2)
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((0.1, 0.42, 2.7), (0, 0.6, 0), fov_deg=36, focus=2.6, aperture=0.03),
    background=(sky + (0.3, 0.16, 0.065)).round(3),
    fog=((0.56, 0.29, 0.1), 26),
    objects=solids,
    lights=[motes.Light((3, 4, 6), (1, 0.75, 0.5), 6)],  # reflected light from the wood behind the camera
    sun=sun,
    exposure=1.5,
    shutter=0.25,
    bloom=0.15,
)
world = motes.World(**args.world, renderer=renderer)

foliage = []
for i in range(args.systems):
    form = leaf(MAPLE, 0.9) if i % 2 == 0 else leaf(BEECH, -0.7)
    sprite = motes.Sprite("mesh", mesh=form, blend="opaque", lit=True, shadow=0.8)
    leaves = world.system(f"leaves {i}", sprite=sprite, attributes={"landed": 0})
    red = (0.54, 0.02, 0.005) if i % 2 == 0 else (0.29, 0.12, 0.015)
    leaves.configure(color=Triangle(red, (0.87, 0.2, 0.01), (0.8, 0.42, 0.03)), orientation="random")
    leaves.configure(size=motes.Uniform(0.1, 0.19))
    foliage.append(leaves)


def glide(particles):
    """Slow leaves across their blades but not along them, so they flutter to and fro."""
    x, y, z, w = particles.orientation.T
    front = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    vx, vy, vz = particles.velocity.T
    particles.velocity -= 0.35 * ((front[0] * vx + front[1] * vy + front[2] * vz) * front).T


air = Box((-99, 0.05, -99), (99, 99, 99))
with world, motes.Movie(f"{args.out}/autumn.mp4") as movie:
    for frame in world.frames(args.frames):
        for leaves in foliage:
            if frame == 0:  # most already lie on the ground, more or less flat; some are falling
                leaves.configure(landed=1, spin=Sphere((0, 0, 0), 9))
                leaves.burst(Box((-3.4, 0.005, -5), (3.4, 0.045, 2.4)), count=args.particles * 3 // 4)
                leaves.align(to=(0, 1, 0))
                leaves.configure(landed=0, velocity=(0.2, -0.6, 0.1))
                leaves.burst(Box((-2.6, 0.1, -3), (1.6, 2.6, 1.8)), count=args.particles // 40)
            leaves.source(Box((-3, 2.7, -3), (1.6, 2.9, 2)), rate=args.particles / 60, jitter=True)
            leaves.gravity((0, -9.8, 0), where=air)
            leaves.callback(glide, where=air)
            leaves.wind((0.45, 0, 0.1), drag=5, where=air)
            leaves.curl_noise(4, scale=1, octaves=2, speed=0.4, where=air)
            leaves.bounce(ground, restitution=0, friction=1)
            leaves.set(velocity=(0, 0, 0), landed=column("landed") + 2 * world.dt, where=~air)
            leaves.align(to=(0, 1, 0), rate=4, where=~air & (column("landed") < 1))
            leaves.set(spin=(0, 0, 0), where=~air & (column("age") > 0))
            leaves.move()
        motes.script.end_frame(world, movie, args)
