"""A waterfall breaks on rocks and raises mist: python -m motes run -n 4 examples/waterfall.py."""

import numpy as np

import motes
from motes.expressions import column, cos
from motes.shapes import Box, Plane, Rectangle, Sphere, Union

args = motes.script.options(__doc__, space="-3,3", systems=4, particles=40_000, frames=144, size="960x540")
rng = np.random.default_rng(7)
lip, half = 9.0, 1.9


def cliff(across=120, high=90):
    """Make a rough wall of rock with ledges, and a notch where the river flows over."""
    x, y = np.meshgrid(np.linspace(-16, 16, across), np.linspace(-1, 12, high), indexing="ij")
    z = -1.2 - 0.12 * y
    for octave in range(5):  # layers are wider than high
        step = 2.0**-octave
        nodes = rng.uniform(-1, 1, (int(12 / step) + 2, int(10 / step) + 2))
        u, v = (x + 16) / 32 * (nodes.shape[0] - 2), (y + 1) / 13 * (nodes.shape[1] - 2)
        z += 0.75 * step * nodes[u.astype(int), v.astype(int)]
    z += 0.25 * np.minimum(np.abs(x), 6) - 0.5
    z[(np.abs(x) < half) & (y > lip)] = -7
    corner = np.arange(x.size).reshape(x.shape)
    p, q, r, s = (c.ravel() for c in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]))
    faces = np.concatenate([np.stack([p, q, r], 1), np.stack([p, r, s], 1)])
    return motes.Mesh(np.stack([x, y, z], 2).reshape(-1, 3).round(4), faces)


grain = rng.integers(120, 255, (64, 64, 1)).repeat(3, 2).astype(np.uint8)
spots = [(-1.0, 5.6, 0.45), (0.9, 4.3, 0.55), (-0.2, 2.4, 0.6), (1.5, 1.6, 0.5), (-1.7, 1.2, 0.55)]
rocks = [Sphere((x, y, -1), r) for x, y, r in spots]
boulders = [Sphere((x, -0.2, z), r) for x, z, r in ((-2.4, 1.6, 0.7), (2.3, 0.9, 0.8), (3.6, 2.6, 0.5))]
bed, pool = Plane((0, -1.2, 0), (0, 1, 0)), Plane((0, 0, 0), (0, 1, 0))
solids = [
    motes.Solid(bed, (0.1, 0.12, 0.09), image=grain, scale=2),
    motes.Solid(cliff(), (0.24, 0.22, 0.17), image=grain, scale=3),
    motes.Solid(Union(*rocks, *boulders), (0.12, 0.11, 0.1), image=grain, scale=1),
]
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((-3.2, 2.1, 14.5), (0, 4.2, 0), fov_deg=40),
    background=motes.Gradient((0.07, 0.1, 0.09), (0.9, 1, 1.1), (0.04, 0.05, 0.04)),
    objects=solids,
    sun=(0.6, 0.8, 0.45),
    sun_power=1.4,
    occlusion=1,
    shutter=0.5,
)
world = motes.World(**args.world, renderer=renderer)

lake = world.system("lake", sprite=motes.Sprite("surface", radius=0.09))
drop = motes.Sprite(pixels=None, blend="alpha", lit=True, shadow=0.1)
streams = []  # side by side, so each rank has a part of the fall
for i in range(args.systems):
    water = world.system(f"water {i}", capacity=args.particles, sprite=drop)
    water.configure(velocity=Box((-0.15, -0.4, 1.0), (0.15, 0.1, 1.5)), size=motes.Uniform(0.025, 0.075))
    water.configure(color=(0.9, 0.96, 1), alpha=motes.Uniform(0, 0.5), lifetime=1.6)
    wide = 2 * half / args.systems
    streams.append((water, Rectangle((i * wide - half, lip, -0.75), (wide, 0, 0), (0, 0.25, 0.1))))
spray = world.system("spray", sprite=motes.Sprite(pixels=None, blend="alpha", lit=True))
spray.configure(color=(0.95, 0.97, 1), lifetime=motes.Uniform(0.3, 0.9), size=motes.Uniform(0.02, 0.05))
mist = world.system("mist", sprite=motes.Sprite(pixels=None, blend="alpha", softness=0.8, lit=True))
mist.configure(lifetime=motes.Uniform(2, 4), velocity=Box((-1.6, 0.2, 0.2), (1.6, 1.6, 2.2)))
foam = world.system("foam", sprite=motes.Sprite(pixels=None, blend="alpha", softness=0.05, lit=True))
foam.configure(lifetime=motes.Uniform(1.5, 4), velocity=Box((-1, 0, 0.2), (1, 0, 1.4)))

place, time = column("position"), column("age")
with world, motes.Movie(f"{args.out}/waterfall.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            lake.configure(color=(0.1, 0.35, 0.36), alpha=0.5)
            x, z = np.mgrid[-11:11:0.14, -1:10:0.14].reshape(2, -1)
            lake.emit(position=np.stack([x, 0 * x - 0.08, z], 1).round(4))
        away = (place * (1, 0, 1)).length()  # waves run away from the foot of the fall
        lake.set(velocity=(0.35 * cos(3 * away - 6 * time) / (1 + 0.3 * away)) * (0, 1, 0))
        for water, edge in streams:
            water.source(edge, rate=args.particles / 1.6, jitter=True)
            water.gravity((0, -9.81, 0))
            water.curl_noise(5, scale=0.7, octaves=3, speed=2)
            water.bounce([*rocks, *boulders], restitution=0.3, friction=0.1, hits=True)
            water.spawn(spray, on="frame", count=1, inherit_velocity=-0.25, where=place.y < 0.3)
            water.sink(pool, inside=True)
        spray.gravity((0, -9.81, 0))
        foam.source(Box((-2, 0, -0.4), (2, 0.02, 0.9)), rate=1200, jitter=True)
        foam.wind((0, 0, 0.25), drag=0.6)
        foam.size_over_life([(0, 0.3), (1, 0.9)])
        foam.alpha_over_life([(0, 0), (0.1, 0.5), (1, 0)])
        mist.source(Box((-2.2, 0.1, 0), (2.2, 0.6, 1.2)), rate=260, jitter=True)
        mist.curl_noise(1.2, scale=1.5, octaves=2, speed=0.4)
        mist.wind((0.25, 0.1, 0.3), drag=0.9)
        mist.size_over_life([(0, 0.6), (1, 3.4)])
        mist.alpha_over_life([(0, 0), (0.15, 0.09), (0.5, 0.04), (1, 0)])
        for system in (spray, foam, mist):
            system.kill_expired()
        for system in (lake, spray, foam, mist, *(water for water, _ in streams)):
            system.move()
        motes.script.end_frame(world, movie, args)
