"""A rocket lifts off; sun and flame light its smoke: python -m motes run -n 4 examples/light/launch.py."""

import numpy as np

import motes
from motes.shapes import Box, Cone, Cylinder, Disc, Plane, Sphere, Union

args = motes.script.options(__doc__, space="-20,20", systems=2, particles=9000, frames=144, size="960x540")

ground, rng = Plane((0, 0, 0), (0, 1, 0)), np.random.default_rng(5)
earth = rng.integers(150, 255, (64, 64, 1)).repeat(3, 2).astype(np.uint8)
tower = [Box((3.4 + x, 0, -1.4 + z), (3.7 + x, 17, -1.1 + z)) for x in (0, 1.5) for z in (0, 1.5)]
tower += [Box((3.4, y, -1.4), (5.2, y + 0.2, 0.4)) for y in range(1, 17, 2)]
pad = [motes.Solid(ground, (0.2, 0.17, 0.12), image=earth, scale=9)]
pad += [motes.Solid(Cylinder((0, 0, 0), (0, 1.2, 0), 3), (0.3, 0.3, 0.3))]
pad += [motes.Solid(Union(*tower), (0.35, 0.09, 0.05))]


def puff(rng, pixels=64):
    """Draw a billow of smoke from many balls, lit from the upper left, as RGBA."""
    y, x = np.mgrid[1 : -1 : pixels * 1j, -1 : 1 : pixels * 1j]
    light, cover = np.zeros((2, pixels, pixels))
    for _ in range(40):
        (right, up), wide = rng.uniform(-0.55, 0.55, 2), rng.uniform(0.16, 0.36)
        u, v = (x - right) / wide, (y - up) / wide
        inside = (1 - u * u - v * v).clip(0)
        shade = 0.72 - 0.2 * u + 0.24 * v + 0.1 * (up - right)
        light += (shade - light) * (3 * inside).clip(0, 1)
        cover = np.maximum(cover, 1.6 * inside)
    return (np.dstack([light, light, light, cover]).clip(0, 1) * 255).astype(np.uint8)


def rocket(y):
    """Build the rocket whose nozzle is at this height, m."""
    top, stripe = (0, y + 9, 0), Cylinder((0, y + 6.2, 0), (0, y + 7, 0), 0.77)
    white = Union(Cylinder((0, y + 0.6, 0), top, 0.75), Cone((0, y + 12, 0), top, 0.75))
    red = Union(stripe, Box((-1.5, y, -0.07), (1.5, y + 1.8, 0.07)))
    black = Cone((0, y + 1.2, 0), (0, y, 0), 0.5)
    return [motes.Solid(*part) for part in ((white, "#e8e6e0"), (red, "#c03018"), (black, "#303034"))]


renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((-6, 3.2, 44), (0, 10.5, 0), fov_deg=36),
    background=motes.Gradient((0.55, 0.3, 0.17), (0.05, 0.11, 0.3), (0.16, 0.1, 0.07)),
    fog=((0.5, 0.28, 0.17), 300),
    sun=(-0.8, 0.35, 0.3),
    exposure=1.35,
    shutter=0.5,
    bloom=0.2,
)
world = motes.World(**args.world, substeps=2, renderer=renderer)

clouds, puffs = [], [puff(rng) for _ in range(4)]
for i in range(args.systems):
    sprite = motes.Sprite("image", None, "alpha", softness=0.8, image=puffs, lit=True, shadow=0.5)
    cloud = world.system(f"cloud {i}", capacity=args.particles, sprite=sprite)
    cloud.configure(lifetime=motes.Uniform(3, 7), color=(0.8, 0.76, 0.72))
    clouds.append(cloud)
flame = world.system("flame", sprite=motes.Sprite(pixels=None))
flame.configure(velocity=Sphere((0, -26, 0), 3), lifetime=motes.Uniform(0.15, 0.42))
sparks = world.system("sparks", sprite=motes.Sprite(pixels=None))
sparks.configure(velocity=Sphere((0, -18, 0), 14), color=(5, 1.6, 0.3))
sparks.configure(lifetime=motes.Uniform(0.3, 1.2), size=0.07)
fire = [(0, (7, 4.5, 2)), (0.25, (5, 1.8, 0.3)), (0.7, (2, 0.35, 0.03)), (1, (0.3, 0.02, 0))]

with world, motes.Movie(f"{args.out}/launch.mp4") as movie:
    for frame in world.frames(args.frames):
        # The nozzle's height, now and at the frame's end; it stays in place for the first 0.6 s.
        last, now = (1.3 + 1.5 * max(0, world.time + ahead - 0.6) ** 2 for ahead in (0, world.dt))
        renderer.objects = [*pad, *rocket(now)]
        power = 44 + 3 * (frame * 7 % 5)  # it flickers
        renderer.lights = [motes.Light((0, max(now - 2.5, 0.6), 0), (1, 0.42, 0.11), power)]
        nozzle, before = (Disc((0, y, 0), (0, 1, 0), 0.45) for y in (now, last))
        flame.source(nozzle, rate=args.particles / 2, jitter=True, moving_from=before)
        sparks.source(nozzle, rate=args.particles / 30, jitter=True, moving_from=before)
        for i, cloud in enumerate(clouds):
            side = 1 - 2 * (i % 2)  # the pad deflects the jet to the left and right
            cloud.configure(velocity=Box((24 * side - 9, 0, -4), (24 * side + 9, 9, 4)))
            cloud.source(Sphere((3 * side, 0.8, 0), 0.8), args.particles / (4 + (now / 6) ** 2), jitter=True)
            cloud.configure(velocity=Sphere((0, -9, 0), 3))
            wake, wake_before = (Disc((0, max(y - 9, 0.6), 0), (0, 1, 0), 0.6) for y in (now, last))
            cloud.source(wake, rate=args.particles / 26, jitter=True, moving_from=wake_before)
            cloud.size_over_life([(0, 0.6), (0.1, 1.5), (0.4, 2.8), (1, 5)])
            cloud.alpha_over_life([(0, 0.8), (0.3, 0.7), (0.7, 0.3), (1, 0)])
            cloud.wind((0.6, 0.6, 0), drag=1.5)
            cloud.curl_noise(9, scale=5, octaves=3, speed=0.4)
            cloud.bounce(ground, restitution=0.3, friction=0.05)
        flame.color_over_life(fire)
        flame.size_over_life([(0, 0.7), (0.4, 1.1), (1, 1.9)])
        flame.alpha_over_life([(0, 0.4), (0.6, 0.2), (1, 0)])
        sparks.gravity((0, -9.8, 0))
        for system in (flame, sparks):
            system.curl_noise(40, scale=1.5, octaves=2, speed=2)
            system.bounce(ground, restitution=0.25, friction=0)
        for system in (*clouds, flame, sparks):
            system.kill_expired()
            system.move()
        motes.script.end_frame(world, movie, args)
