"""A barrel of fuel blows up: python -m motes run -n 4 examples/explosion.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Cylinder, Plane, Sphere

args = motes.script.options(__doc__, space="-12,12", systems=3, particles=16000, frames=144, size="960x540")

ground = Plane((0, 0, 0), (0, 1, 0))
heart = (0, 1.2, 0)
barrels = [(-5.5, -2.5), (-4.6, -3.2), (5.2, -3), (6.6, 1.2)]
walls = [
    Box((-13, 0, -9), (-7.5, 5, -8)),
    Box((6.5, 0, -10), (14, 3.4, -9)),
    Box((-7.5, 0, -9), (6.5, 1.4, -8.4)),
]
dirt = np.random.default_rng(2).integers(130, 255, (64, 64, 1)).repeat(3, 2).astype(np.uint8)
solids = [motes.Solid(ground, (0.2, 0.15, 0.1), image=dirt, scale=6)]
solids += [motes.Solid(wall, (0.3, 0.2, 0.14), image=dirt, scale=4) for wall in walls]
solids += [motes.Solid(Cylinder((x, 0, z), (x, 1.4, z), 0.5), (0.3, 0.06, 0.03)) for x, z in barrels]
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((0, 2.4, 25), (0, 6.3, 0), fov_deg=42),
    background=motes.Gradient((0.3, 0.2, 0.16), (0.04, 0.07, 0.18), (0.1, 0.08, 0.06)),
    fog=((0.26, 0.18, 0.15), 150),
    objects=solids,
    sun=(-0.75, 0.4, 0.4),
    exposure=1.4,
    shutter=0.5,
    bloom=0.2,
)
world = motes.World(**args.world, substeps=2, renderer=renderer)

# Smoke is born dark within the fire, and becomes visible when the fire burns out. Both move in the same air.
clouds, fires = [], []
for i in range(args.systems):
    puff = motes.Sprite(pixels=None, blend="alpha", softness=0.5, lit=True, shadow=0.6)
    for name, sprite, crowd in (("cloud", puff, clouds), ("fire", motes.Sprite(pixels=None), fires)):
        gas = world.system(f"{name} {i}", capacity=args.particles, sprite=sprite)
        gas.configure(lifetime=motes.Uniform(1.6, 6), color=(0.3, 0.26, 0.23))
        gas.configure(velocity=Sphere((0, 5 + 5 * i, 0), 15 - 3 * i))
        crowd.append(gas)
    fires[-1].configure(lifetime=motes.Uniform(0.6, 2.2))
sparks = world.system("sparks", sprite=motes.Sprite(pixels=None))
sparks.configure(velocity=Sphere((0, 7, 0), 26), lifetime=motes.Uniform(0.5, 2.4), size=0.09)
debris = world.system("debris", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))
debris.configure(velocity=Sphere((0, 11, 0), 12), color=(0.05, 0.04, 0.04))
debris.configure(size=motes.Uniform((0.08,) * 3, (0.3,) * 3))
puff = motes.Sprite(pixels=None, blend="alpha", softness=0.3, lit=True, shadow=0.5)
trails = world.system("trails", sprite=puff)
trails.configure(
    lifetime=motes.Uniform(0.8, 1.8), velocity=Sphere((0, 0.5, 0), 0.4), color=(0.35, 0.31, 0.28)
)

every, fuse = 144, 6  # frames
with world, motes.Movie(f"{args.out}/explosion.mp4") as movie:
    for frame in world.frames(args.frames):
        age = (frame % every - fuse) * world.dt
        if age == 0:
            for gas in (*clouds, *fires):
                gas.burst(Sphere(heart, 1), count=args.particles)
            sparks.burst(Sphere(heart, 0.8), count=args.particles // 3)
            debris.burst(Sphere(heart, 0.8), count=70)
        flash = 500 * max(0, 1 - age / 1.6) ** 2 if age >= 0 else 0
        renderer.lights = [motes.Light((0, 2.5 + 3 * max(age, 0), 0), (1, 0.45, 0.12), power=flash)]
        for i, gas in enumerate((*clouds, *fires)):
            # Air slows the gas down, and lifts it while it is hot.
            gas.wind((0.4, 2.2 + 0.8 * (i % args.systems), 0), drag=2.6)
            gas.curl_noise(16, scale=2.4, octaves=4, speed=0.5)
            gas.bounce(ground, restitution=0.1, friction=0.1)
        for cloud in clouds:
            cloud.alpha_over_life([(0, 0), (0.1, 0.7), (0.3, 0.6), (0.6, 0.25), (1, 0)])
            cloud.size_over_life([(0, 0.3), (0.1, 0.6), (1, 2)])
        for fire in fires:
            fire.color_over_life(
                [(0, (9, 6, 2.4)), (0.2, (7, 2.4, 0.4)), (0.6, (3, 0.5, 0.04)), (1, (0.6, 0.04, 0))]
            )
            fire.alpha_over_life([(0, 0.06), (0.3, 0.045), (1, 0)])
            fire.size_over_life([(0, 0.3), (0.3, 0.8), (1, 1.2)])
        debris.trail(trails, every=world.dt, where=column("age") < 1.6)
        trails.size_over_life([(0, 0.12), (1, 0.9)])
        trails.alpha_over_life([(0, 0.5), (0.4, 0.22), (1, 0)])
        sparks.wind((0, 0, 0), drag=1.1)
        sparks.color_over_life([(0, (4, 2, 0.7)), (0.5, (2, 0.6, 0.08)), (1, (0.3, 0.03, 0))])
        for system in (sparks, debris):
            system.gravity((0, -9.81, 0))
            system.bounce(ground, restitution=0.35, friction=0.35)
        for system in (*clouds, *fires, sparks, trails, debris):
            if system is not debris:
                system.kill_expired()
            system.move()
        motes.script.end_frame(world, movie, args)
