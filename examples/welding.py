"""Sparks fly from a welder's arc and bounce: python -m motes run -n 4 examples/welding.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Cone, Cylinder, Plane, Sphere, Union

args = motes.script.options(__doc__, space="-2,2", systems=2, particles=6000, frames=120, size="960x540")

# Two girders on trestles, and a seam between them. Metres.
floor = Plane((0, 0, 0), (0, 1, 0))
girder = Union(
    Box((-1.7, 1.0, -0.2), (1.7, 1.05, 0.2)),
    Box((-1.7, 0.75, -0.03), (1.7, 1.0, 0.03)),
    Box((-1.7, 0.7, -0.2), (1.7, 0.75, 0.2)),
)
legs = Union(
    *(
        Cylinder((x + dx, 0, dz), (x, 0.7, 0), 0.035)
        for x in (-1.1, 1.1)
        for dx, dz in ((-0.2, 0.3), (0.2, 0.3), (0, -0.4))
    )
)
post = Box((-0.16, 1.05, -0.1), (-0.06, 2.6, 0.1))
drum = Cylinder((1.9, 0, -1.3), (1.9, 0.95, -1.3), 0.32)
wall = Box((-6, 0, -3.2), (6, 4, -3))
rng = np.random.default_rng(3)
brick = np.full((32, 32, 1), 235) - 110 * ((np.mgrid[:32, :32][0] % 8 == 0)[:, :, None])
brick[:, :, 0] -= (
    110 * ((np.mgrid[:32, :32][1] + 8 * (np.mgrid[:32, :32][0] // 8 % 2)) % 16 == 0) * (brick[:, :, 0] > 200)
)
brick = (brick + rng.integers(-18, 18, (32, 32, 1))).clip(0, 255).repeat(3, 2).astype(np.uint8)
stained = rng.integers(110, 255, (64, 64, 1)).repeat(3, 2).astype(np.uint8)
solids = [motes.Solid(floor, (0.17, 0.16, 0.16), image=stained, scale=4)]
solids += [motes.Solid(wall, (0.3, 0.15, 0.11), image=brick, scale=1.2)]
solids += [motes.Solid(Union(girder, post), (0.3, 0.31, 0.34)), motes.Solid(legs, (0.5, 0.32, 0.04))]
solids += [motes.Solid(drum, (0.06, 0.16, 0.42))]
window = motes.Light((-4, 3.6, 2.5), (0.35, 0.5, 1), 4)  # evening light
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((1.1, 1.3, 4.6), (0.1, 1.0, 0), fov_deg=34),
    background=motes.Gradient((0.02, 0.025, 0.04), (0.03, 0.04, 0.07), (0.01, 0.01, 0.01)),
    sun=(0, 0, 0),
    shutter=0.6,
    bloom=0.2,
)
world = motes.World(**args.world, substeps=4, renderer=renderer)

showers = []
for i in range(args.systems):
    sparks = world.system(f"sparks {i}", capacity=args.particles, sprite=motes.Sprite(pixels=None))
    sparks.configure(lifetime=motes.Uniform(0.3, 1.7), size=motes.Uniform((0.007,) * 3, (0.014,) * 3))
    showers.append(sparks)
crackle = world.system("crackle", sprite=motes.Sprite(pixels=None))
crackle.configure(
    lifetime=motes.Uniform(0.05, 0.16), size=0.006, velocity=Sphere((0, 0, 0), 1.6), color=(9, 1.6, 0.2)
)
puff = motes.Sprite(pixels=None, blend="alpha", softness=0.05, lit=True, shadow=0.3)
smoke = world.system("smoke", sprite=puff)
smoke.configure(lifetime=motes.Uniform(1.2, 2.8), velocity=Sphere((0, 0.5, 0), 0.15), color=(0.5, 0.5, 0.5))

with world, motes.Movie(f"{args.out}/welding.mp4") as movie:
    for frame in world.frames(args.frames):
        arc = (0.06 + 0.0006 * (frame % 120), 1.06, 0.06)
        flicker = 0.7 + 0.3 * (frame * 7 % 5) / 4
        lamp = motes.Light((arc[0], 1.14, 0.16), (0.6, 0.75, 1), power=1.3 * flicker)
        renderer.lights = [window, lamp, motes.Light((0.1, 0.35, 1), (1, 0.4, 0.1), power=0.25 * flicker)]
        glow = motes.Solid(Sphere(arc, 0.02), (0.75, 0.85, 1), light=25 * flicker)
        renderer.objects = [
            *solids,
            glow,
            motes.Solid(Cylinder(arc, (0.55, 1.5, 0.4), 0.008), (0.1, 0.1, 0.1)),
        ]
        for i, sparks in enumerate(showers):
            burst = 0.35 + 1.1 * ((frame + 4 * i) * 5 % 11) / 10  # the arc flickers
            sparks.configure(velocity=Cone((0, 0, 0), (1.2 - 1.9 * i, 2.2, 4.2), 3.6))
            sparks.source(Sphere((arc[0], 1.08, 0.08), 0.012), rate=args.particles * burst, jitter=True)
            sparks.color_over_life(
                [(0, (9, 2.2, 0.5)), (0.15, (7, 0.7, 0.05)), (0.6, (6, 0.28, 0.005)), (1, (2, 0.03, 0))]
            )
            sparks.spawn(crackle, on="death", count=3, where=column("size").x > 0.0095)
            sparks.gravity((0, -9.81, 0))
            sparks.wind((0, 0, 0), drag=0.9)
            for shape in (floor, girder, drum):
                sparks.bounce(shape, restitution=0.45, friction=0.25)
            sparks.kill_expired()
            sparks.move()
        smoke.source(Sphere(arc, 0.03), rate=260, jitter=True)
        smoke.curl_noise(1.1, scale=0.3, octaves=3, speed=0.6)
        smoke.wind((0.05, 0.55, 0), drag=1.2)
        smoke.size_over_life([(0, 0.03), (1, 0.35)])
        smoke.alpha_over_life([(0, 0), (0.1, 0.14), (0.4, 0.07), (1, 0)])
        for system in (smoke, crackle):
            system.kill_expired()
            system.move()
        motes.script.end_frame(world, movie, args)
