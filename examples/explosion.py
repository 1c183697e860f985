"""A barrel of fuel blows up: python -m motes run -n 4 examples/explosion.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Cylinder, Plane, Sphere, Union

args = motes.script.options(__doc__, space="-12,12", systems=2, particles=9000, frames=144, size="960x540")

rng = np.random.default_rng(2)
ground, heart = Plane((0, 0, 0), (0, 1, 0)), (0, 1.2, 0)
walls = Box((-13, 0, -9), (-7.5, 5, -8)) | Box((6.5, 0, -10), (14, 3.4, -9))
dirt = rng.integers(130, 255, (64, 64, 1)).repeat(3, 2).astype(np.uint8)
solids = [motes.Solid(ground, (0.2, 0.15, 0.1), image=dirt, scale=6)]
solids += [motes.Solid(walls, (0.3, 0.2, 0.14), image=dirt, scale=4)]
drums = [Cylinder((x, 0, z), (x, 1.4, z), 0.5) for x, z in ((-5.5, -2.5), (-4.6, -3.2), (6.6, 1.2))]
solids += [motes.Solid(Union(*drums), (0.3, 0.06, 0.03), roughness=0.4)]
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((0, 2.4, 25), (0, 6.3, 0), fov_deg=42),
    background=motes.Gradient((0.3, 0.2, 0.16), (0.04, 0.07, 0.18), (0.1, 0.08, 0.06)),
    objects=solids,
    sun=(-0.75, 0.4, 0.4),
    sun_color=(1, 0.85, 0.7),
    sun_power=1.3,
    exposure=1.3,
    shutter=0.5,
    bloom=0.15,
)
world = motes.World(**args.world, substeps=2, renderer=renderer)


def billow(pixels=64):
    """Draw a clump of smoke, ragged at its edge, as RGBA."""
    y, x = np.mgrid[1 : -1 : pixels * 1j, -1 : 1 : pixels * 1j]
    light, cover = np.zeros((2, pixels, pixels))
    for _ in range(60):
        (right, up), wide = rng.normal(0, 0.3, 2), rng.uniform(0.08, 0.28)
        ball = (1 - np.hypot(x - right, y - up) / wide).clip(0)
        light += (rng.uniform(0.45, 1) - light) * (2 * ball).clip(0, 1)
        cover = np.maximum(cover, 2.5 * ball * (1 - np.hypot(x, y)).clip(0))
    return (np.dstack([light, light, light, cover]).clip(0, 1) * 255).astype(np.uint8)


# Smoke is born dark within the fire, and becomes visible when the fire burns out. Both move in the same air.
billows = [billow() for _ in range(6)]
smoke = motes.Sprite("image", None, "alpha", image=billows, softness=0.5, lit=True, shadow=0.7)
fire = motes.Sprite("image", None, "add", image=billows, softness=0.3)
gases = []
for i in range(args.systems):
    for name, sprite, life in (("cloud", smoke, (2, 6)), ("fire", fire, (0.5, 1.9))):
        gas = world.system(f"{name} {i}", capacity=args.particles, sprite=sprite)
        gas.configure(lifetime=motes.Uniform(*life), color=(0.26, 0.23, 0.21), up=Sphere((0, 0, 0), 1))
        gas.configure(velocity=Sphere((0, 6 + 6 * i, 0), 17 - 4 * i))
        gases.append(gas)
sparks = world.system("sparks", sprite=motes.Sprite(pixels=None))
sparks.configure(velocity=Sphere((0, 8, 0), 26), lifetime=motes.Uniform(0.4, 2.2), size=0.07)
debris = world.system("debris", sprite=motes.Sprite("sphere", None, "opaque", lit=True, shadow=1))
debris.configure(velocity=Sphere((0, 11, 0), 12), color="#3c3836", size=motes.Uniform(0.08, 0.35), lifetime=5)
trails = world.system("trails", sprite=motes.Sprite(pixels=None, blend="alpha", lit=True, shadow=0.5))
trails.configure(lifetime=motes.Uniform(0.8, 2), velocity=Sphere((0, 0.5, 0), 0.5), color=(0.4, 0.35, 0.3))

every, fuse = 144, 6  # frames
with world, motes.Movie(f"{args.out}/explosion.mp4") as movie:
    for frame in world.frames(args.frames):
        age = (frame % every - fuse) * world.dt
        if age == 0:
            for gas in gases:
                gas.burst(Sphere(heart, 1), count=args.particles)
            sparks.burst(Sphere(heart, 0.8), count=args.particles // 3)
            debris.burst(Sphere(heart, 0.8), count=90)
        flash = 500 * max(0, 1 - age / 1.6) ** 2 if age >= 0 else 0
        renderer.lights = [motes.Light((0, 2.5 + 3 * max(age, 0), 0), (1, 0.45, 0.12), flash, radius=1.5)]
        for i, gas in enumerate(gases):
            gas.wind((0.4, 2 + 1.6 * (i // 2), 0), drag=2.6)  # hot gas rises
            gas.curl_noise(18, scale=2.6, octaves=4, speed=0.5)
            gas.bounce(ground, restitution=0.1, friction=0.1)
        for cloud in gases[::2]:
            cloud.alpha_over_life([(0, 0), (0.06, 0.8), (0.3, 0.7), (0.6, 0.3), (1, 0)])
            cloud.size_over_life([(0, 0.6), (0.1, 1.3), (1, 3.6)])
        for flame in gases[1::2]:
            flame.color_over_life(
                [(0, (9, 6, 2.4)), (0.15, (7, 2.4, 0.4)), (0.5, (4, 0.6, 0)), (1, (1, 0, 0))]
            )
            flame.alpha_over_life([(0, 0.08), (0.3, 0.07), (1, 0)])
            flame.size_over_life([(0, 0.6), (0.3, 1.3), (1, 1.8)])
        debris.trail(trails, every=world.dt, where=column("age") < 1.6)
        trails.size_over_life([(0, 0.12), (1, 0.9)])
        trails.alpha_over_life([(0, 0.5), (0.4, 0.22), (1, 0)])
        sparks.wind((0, 0, 0), drag=1.1)
        sparks.color_over_life([(0, (4, 2, 0.7)), (0.5, (2, 0.6, 0.08)), (1, (0.3, 0.03, 0))])
        for system in (sparks, debris):
            system.gravity((0, -9.81, 0))
            system.bounce(ground, restitution=0.35, friction=0.35)
        for system in (*gases, sparks, trails, debris):
            system.kill_expired()
            system.move()
        motes.script.end_frame(world, movie, args)
