"""A tornado passes a farm: python -m motes run -n 4 examples/tornado.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Cylinder, Plane, Rectangle, Sphere, Triangle, Union

args = motes.script.options(__doc__, space="-8,8", systems=3, particles=9000, frames=192, size="960x540")

# The farm, in metres: a barn with its gable and roof, a fence of posts and two rails before it.
rng = np.random.default_rng(3)
ground = Plane((0, 0, 0), (0, 1, 0))
barn = Box((6, 0, -5), (12, 2.6, -1)) | Triangle((6, 2.6, -5), (6, 2.6, -1), (6, 4.4, -3))
roof = Union(*(Rectangle((5.7, 4.5, -3), (6.6, 0, 0), (0, -2.2, z)) for z in (-2.4, 2.4)))
door = Box((8.2, 0, -1), (9.8, 1.9, -0.97))
posts = [Cylinder((x, 0, 8), (x, 0.9, 8), 0.06) for x in range(-14, 16, 2)]
rails = [Cylinder((-15, y, 8), (15, y, 8), 0.035) for y in (0.4, 0.75)]
straw = rng.integers(90, 255, (128, 128, 1)).repeat(3, 2).astype(np.uint8)
planks = rng.integers(150, 255, (1, 16, 1)).repeat(16, 0).repeat(3, 2).astype(np.uint8)
solids = [
    motes.Solid(ground, (0.34, 0.27, 0.11), image=straw, scale=9),
    motes.Solid(barn, (0.42, 0.07, 0.04), image=planks, scale=3),
    motes.Solid(roof, (0.16, 0.15, 0.16), image=planks, scale=2, roughness=0.5),
    motes.Solid(door, (0.5, 0.45, 0.4)),
    motes.Solid(Union(*posts, *rails), (0.34, 0.3, 0.25)),
]
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((3, 1.7, 27), (1.5, 8, 0), fov_deg=44),
    background=motes.Gradient((0.5, 0.42, 0.3), (0.06, 0.08, 0.1), (0.1, 0.08, 0.05)),
    fog=((0.4, 0.34, 0.25), 300),
    objects=solids,
    sun=(-0.85, 0.3, 0.45),  # the sun shines in below the cloud
    sun_color=(1, 0.84, 0.6),
    sun_power=1.2,
    exposure=1.1,
    shutter=0.4,
)
world = motes.World(**args.world, substeps=2, renderer=renderer)


def billow(pixels=64):
    """Draw a clump of vapour, ragged at its edge, as RGBA."""
    y, x = np.mgrid[1 : -1 : pixels * 1j, -1 : 1 : pixels * 1j]
    light, cover = np.zeros((2, pixels, pixels))
    for _ in range(60):
        (right, up), wide = rng.normal(0, 0.3, 2), rng.uniform(0.08, 0.28)
        ball = (1 - np.hypot(x - right, y - up) / wide).clip(0)
        light += (rng.uniform(0.7, 1) - light) * (2 * ball).clip(0, 1)
        cover = np.maximum(cover, 2.5 * ball * (1 - np.hypot(x, y)).clip(0))
    return (np.dstack([light, light, light, cover]).clip(0, 1) * 255).astype(np.uint8)


billows = [billow() for _ in range(6)]
puff = motes.Sprite("image", None, "alpha", image=billows, softness=0.6, lit=True, shadow=0.35)
cloud = world.system("cloud", sprite=puff)
cloud.configure(color=(0.3, 0.31, 0.34), alpha=0.6, size=motes.Uniform(4, 9), up=Sphere((0, 0, 0), 1))
debris = world.system("debris", sprite=motes.Sprite("sphere", None, "opaque", lit=True, shadow=1))
debris.configure(mass=motes.Uniform(1, 3), lifetime=motes.Uniform(3, 6), size=motes.Uniform(0.05, 0.22))
debris.configure(color=(0.16, 0.1, 0.06))
funnel = [world.system(f"funnel {i}", sprite=puff) for i in range(args.systems)]
for i, dust in enumerate(funnel):
    dust.configure(mass=motes.Uniform(0.9, 1.3), lifetime=motes.Uniform(1, 3.5), up=Sphere((0, 0, 0), 1))
    dust.configure(color=((0.3, 0.28, 0.27), (0.32, 0.27, 0.22), (0.4, 0.29, 0.18))[i % 3])

speeds = {"in_speed": 30, "up_speed": 330, "around_speed": 500}
with world, motes.Movie(f"{args.out}/tornado.mp4") as movie:
    for frame in world.frames(args.frames):
        # The foot moves along a curve, and the funnel leans in its direction. Round: sines differ in their
        # last bit between machines, and all ranks must record the same numbers.
        turn = 0.7 * world.time
        path = np.array([4 * np.sin(turn) - 2, 1.5 * np.cos(2 * turn), 3 * np.cos(turn)])
        x, z, lean = path.round(4).tolist()
        if frame == 0:  # the cloud's base, lowest above the funnel
            for r in range(4, 76, 4):
                deck = Cylinder((0, 19 + r / 12, -14), (0, 20 + r / 7, -14), r, r - 4)
                cloud.burst(deck, count=args.particles * r // 4000)
        for i, system in enumerate([*funnel, debris]):
            rate = 150 if system is debris else args.particles / 3
            system.source(Sphere((x, 0.3, z), 0.8 + 0.5 * i), rate=rate, jitter=True)
            system.gravity((0, -1, 0))
            system.vortex((x, -4, z), (lean, 24, 0), 1.6, max_radius=7, **speeds)
            system.curl_noise(12, scale=2, octaves=3, speed=1)
            system.bounce(ground, restitution=0.2)
            system.kill_expired()
        for dust in funnel:
            dust.alpha_over_life([(0, 0), (0.1, 0.3), (0.6, 0.22), (1, 0)])
            dust.set(size=0.5 + 0.14 * column("position").y)
        cloud.set(velocity=column("position").z * (0.08, 0, 0) - column("position").x * (0, 0, 0.08))  # turns
        for system in (*funnel, debris, cloud):
            system.move()
        motes.script.end_frame(world, movie, args)
