"""Snow stays on a roof and on branches: python -m motes run -n 4 examples/light/winter.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Cylinder, Plane, Rectangle, Sphere, Triangle, Union

args = motes.script.options(__doc__, space="-5,5", systems=2, particles=60_000, frames=180, size="960x540")
rng = np.random.default_rng(8)


def branches(start, along, thick):
    """Grow a bare tree: each branch ends in three that are shorter and thinner."""
    end = start + along
    yield Cylinder(start.round(3), end.round(3), round(thick, 3))
    if thick > 0.04:
        for _ in range(3):
            aside = rng.uniform(-0.6, 0.6, 3) * np.linalg.norm(along)
            yield from branches(end, 0.78 * along + aside * (1, 0.3, 1), 0.62 * thick)


# A hut of boards, a woodpile, a fence and a tree. Metres.
ground = Plane((0, 0, 0), (0, 1, 0))
walls = Box((0.4, 0, -1.2), (3.4, 1.75, 1.2))
gables = Union(*(Triangle((x, 1.7, -1.2), (x, 1.7, 1.2), (x, 2.9, 0)) for x in (0.4, 3.4)))
slopes = [Rectangle((0.1, 1.4, z), (3.6, 0, 0), (0, 1.55, -z)) for z in (-1.6, 1.6)]  # of the roof
sills = [Box((x - 0.05, 0.8, 1.2), (x + 0.75, 0.85, 1.32)) for x in (0.75, 2.3)]
panes = [Box((x, y, 1.15), (x + 0.33, y + 0.28, 1.22)) for x in (0.75, 1.12, 2.3, 2.67) for y in (0.85, 1.17)]
ends = ((4.1, 0.12), (4.35, 0.12), (4.6, 0.12), (4.22, 0.33), (4.47, 0.33), (4.35, 0.54))
logs = Union(*(Cylinder((x, y, -0.6), (x, y, 0.9), 0.12) for x, y in ends))
fence = Union(*(Box((x, 0, 2.4), (x + 0.1, 0.7, 2.5)) for x in np.arange(-4.6, 0, 0.55)))
fence |= Union(Box((-4.8, 0.25, 2.5), (-0.1, 0.33, 2.54)), Box((-4.8, 0.52, 2.5), (-0.1, 0.6, 2.54)))
tree = Union(*branches(np.array([-2, 0, 0.3]), np.array([0.05, 1.2, 0]), 0.13))
boards = rng.integers(140, 255, (32, 1, 1)).repeat(32, 1).repeat(3, 2).astype(np.uint8)
solids = [
    motes.Solid(ground, (0.16, 0.15, 0.13)),
    motes.Solid(walls | gables, (0.26, 0.14, 0.08), image=boards, scale=2),
    motes.Solid(Union(*slopes), (0.15, 0.09, 0.08)),
    motes.Solid(Union(*sills, logs), (0.3, 0.2, 0.12)),
    motes.Solid(fence, (0.2, 0.14, 0.1)),
    motes.Solid(tree, (0.1, 0.075, 0.06)),
    motes.Solid(Union(*panes), (1, 0.55, 0.18), light=2.2),
]
renderer = motes.Renderer(
    *args.size,
    camera=motes.Camera((-1.2, 1.9, 8.6), (0.4, 1.65, 0), fov_deg=33),
    background=motes.Gradient((0.11, 0.14, 0.22), (0.03, 0.05, 0.11), (0.1, 0.12, 0.18)),
    fog=((0.1, 0.13, 0.2), 40),
    objects=solids,
    lights=[motes.Light((2, 1.1, 2), (1, 0.5, 0.16), 1.2)],
    sun=(-0.6, 0.7, 0.35),
    sun_color=(0.75, 0.85, 1),
    sun_power=0.45,
    occlusion=0.6,
    shutter=0.4,
    bloom=0.1,
)
world = motes.World(**args.world, renderer=renderer)

falls = []
for i in range(args.systems):
    flake = motes.Sprite("sphere", None, "opaque", lit=True)
    snow = world.system(f"snow {i}", capacity=args.particles, sprite=flake)
    snow.configure(
        color=(0.95, 0.96, 0.98), size=motes.Uniform(0.012, 0.024), velocity=Sphere((0.25, -1.3, 0), 0.2)
    )
    falls.append(snow)

air = Box((-6, 0.05, -5), (6, 5.2, 5))
flying = column("velocity").length() > 0
with world, motes.Movie(f"{args.out}/winter.mp4") as movie:
    for frame in world.frames(args.frames):
        for snow in falls:
            if frame == 0:
                snow.burst(air, count=args.particles // 8)
            snow.source(Box((-7, 5.1, -5), (5.5, 5.3, 5)), rate=args.particles / 10, jitter=True)
            snow.gravity((0, -9.8, 0))
            snow.wind((0.25, -0.1, 0), drag=8)
            snow.curl_noise(3, scale=1, octaves=2, speed=0.3, where=flying)
            snow.bounce(
                [ground, walls, *slopes, logs, fence, tree, *sills], restitution=0, friction=1, hits=True
            )
            snow.rest(0.5)
            snow.set(size=column("size") + 0.06 * world.dt, where=~flying & (column("size").x < 0.1))
            snow.move()
        motes.script.end_frame(world, movie, args)
