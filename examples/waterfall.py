"""A waterfall breaks on rocks and raises mist: python -m motes run -n 4 examples/waterfall.py."""

import numpy as np

import motes
from motes.shapes import Box, Plane, Rectangle, Sphere, Union

args = motes.script.options(__doc__, space="-3,3", systems=4, particles=60_000, frames=144, size="960x540")

# A cliff of stacked blocks with a notch at its upper edge, where the river flows over. Metres.
dice = np.random.default_rng(7)
lip, half = 9.0, 1.9
tones = [(0.11, 0.10, 0.085), (0.075, 0.075, 0.07), (0.06, 0.085, 0.045)]  # the last one: moss
blocks: list[list[Box]] = [[], [], []]
for x in np.arange(-15, 15, 1.5):
    level = -1.0
    while level < 10.5:
        high, back = dice.uniform(0.7, 2.2), dice.uniform(0.0, 1.1)
        top = min(level + high, lip - 0.1) if abs(x + 0.75) < half else level + high
        if top > level:
            blocks[dice.integers(3)].append(Box((x, level, -8), (x + 1.5, top, -0.6 - back)))
        level += high
spots = [(-1.0, 5.6, 0.45), (0.9, 4.3, 0.55), (-0.2, 2.4, 0.6), (1.5, 1.6, 0.5), (-1.7, 1.2, 0.55)]
rocks = [Sphere((x, y, -0.75), r) for x, y, r in spots]
boulders = [Sphere((x, -0.2, z), r) for x, z, r in ((-2.4, 1.6, 0.7), (2.3, 0.9, 0.8), (3.6, 2.6, 0.5))]
pool = Plane((0, 0, 0), (0, 1, 0))
solids = [
    motes.Solid(pool, (0.012, 0.05, 0.055)),
    *(motes.Solid(Union(*some), tone) for some, tone in zip(blocks, tones, strict=True)),
]
solids += [motes.Solid(rock, (0.03, 0.03, 0.03)) for rock in (*rocks, *boulders)]

camera = motes.Camera((-3.2, 2.1, 14.5), (0, 4.2, 0), fov_deg=40)
renderer = motes.Renderer(
    *args.size, camera=camera, background=(0.5, 0.66, 0.8), objects=solids, sun=(0.5, 0.8, 0.5), shutter=0.5
)
world = motes.World(**args.world, renderer=renderer)

streams = []  # side by side, so each rank has a part of the fall
for i in range(args.systems):
    water = world.system(f"water {i}", capacity=args.particles, sprite=motes.Sprite(pixels=None))
    water.configure(color=(0.8, 0.93, 1), size=motes.Uniform((0.03,) * 3, (0.09,) * 3), lifetime=2.15)
    wide = 2 * half / args.systems
    streams.append((water, Rectangle((i * wide - half, lip, -0.75), (wide, 0, 0), (0, 0.25, 0.1))))
mist = world.system("mist", capacity=4000, sprite=motes.Sprite(pixels=None, blend="alpha", softness=0.8))
mist.configure(velocity=Box((-1.6, 0.2, 0.2), (1.6, 1.6, 2.2)), lifetime=motes.Uniform(2, 4))
mist.configure(color=(0.8, 0.88, 0.93))

with world, motes.Movie(f"{args.out}/waterfall.mp4") as movie:
    for _ in world.frames(args.frames):
        for water, edge in streams:
            water.configure(velocity=Box((-0.15, -0.4, 1.0), (0.15, 0.1, 1.5)))
            water.configure(alpha=motes.Uniform(0, min(1, 12000 / args.particles)))
            water.source(edge, rate=args.particles / 2.2, jitter=True)
            water.gravity((0, -9.81, 0))
            water.curl_noise(5, scale=0.7, octaves=3, speed=2)
            for rock in (*rocks, *boulders):
                water.bounce(rock, restitution=0.35, friction=0.1)
            water.bounce(pool, restitution=0.22, friction=0.3)
            water.kill_expired()
            water.move()
        mist.source(Box((-2.2, 0.1, 0), (2.2, 0.6, 1.2)), rate=260, jitter=True)
        mist.curl_noise(1.2, scale=1.5, octaves=2, speed=0.4)
        mist.wind((0.25, 0.1, 0.3), drag=0.9)
        mist.size_over_life([(0, 0.6), (1, 3.4)])
        mist.alpha_over_life([(0, 0), (0.15, 0.045), (0.5, 0.02), (1, 0)])
        mist.kill_expired()
        mist.move()
        motes.script.end_frame(world, movie, args)
