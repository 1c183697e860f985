"""Balloons rise over the hills: python -m motes run -n 4 examples/balloons.py."""

import colorsys

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Cone, Cylinder, Plane, Sphere

args = motes.script.options(__doc__, space="-20,20", systems=6, particles=70, frames=168, size="960x540")


def balloon(pixels=160):
    """Draw a balloon on its string as RGBA, grey: its particle has the colour."""
    y, x = np.mgrid[-1 : 1 : pixels * 1j, -1 : 1 : pixels * 1j]
    down = y + 0.42
    half = 0.42 * np.sqrt(np.clip(1 - (down / 0.52) ** 2, 0, 1)) * (1 - 0.16 * down / 0.52)
    skin = np.abs(x) < half
    knot = (np.abs(x) < 0.05 * (down - 0.46) / 0.1) & (down > 0.46) & (down < 0.58)
    string = (np.abs(x - 0.03 * np.sin(9 * y)) < 0.012) & (down >= 0.58)
    # Light comes from the upper left; light that shines through brightens the rim on the other side.
    round_ = np.clip((x / np.maximum(half, 0.02) * -0.55 - down * 0.9), -1, 1)
    light = np.where(skin, 0.66 + 0.28 * round_ + 0.1 * np.clip(x / np.maximum(half, 0.02), 0, 1) ** 4, 0.5)
    spot = np.exp(-(((x + 0.17) / 0.07) ** 2) - ((down + 0.22) / 0.11) ** 2)
    alpha = np.where(skin, 0.93, np.where(knot, 1, np.where(string, 0.8, 0)))
    light = np.clip(light + 0.35 * spot * skin, 0, 1)
    return (np.dstack([light, light, light, alpha]) * 255).astype(np.uint8)


meadow, hedge = Plane((0, 0, 0), (0, 1, 0)), Box((-60, 0, -9.5), (60, 2.2, -9))
hills = [(-60, -130, 46, 0.09), (30, -170, 62, 0.12), (95, -120, 40, 0.08), (-130, -190, 70, 0.13)]
solids = [motes.Solid(meadow, (0.14, 0.25, 0.06)), motes.Solid(hedge, (0.03, 0.09, 0.02))]
solids += [
    motes.Solid(Sphere((x, -1.6 * h, z), 2.2 * h), (0.12 + b, 0.2 + b, 0.1 + 2 * b)) for x, z, h, b in hills
]
for x, z in ((-13, -6), (-16, -12), (15, -10), (19, -5), (-25, -20), (27, -24), (6, -30)):
    solids += [motes.Solid(Cylinder((x, 0, z), (x, 1.6, z), 0.2), (0.1, 0.06, 0.03))]
    solids += [
        motes.Solid(Cone((x, y + 3, z), (x, y, z), 2.0 - 0.25 * y), (0.04, 0.13, 0.04)) for y in (1, 2.4, 3.8)
    ]
camera = motes.Camera((0, 2.2, 20), (0, 6.6, 0), fov_deg=40)
renderer = motes.Renderer(
    *args.size, camera=camera, background=(0.36, 0.58, 0.9), objects=solids, sun=(-0.6, 0.7, 0.5)
)
world = motes.World(**args.world, renderer=renderer)

picture, bunches = balloon(), []
for i in range(args.systems):
    sprite = motes.Sprite("image", pixels=None, blend="alpha", image=picture)
    bunch = world.system(f"balloons {i}", sprite=sprite)
    bunch.configure(size=motes.Uniform((1.5,) * 3, (2.0,) * 3), up=(0, 1, 0), mass=motes.Uniform(0.8, 1.3))
    bunch.configure(
        color=colorsys.hsv_to_rgb(i / args.systems, 0.85, 1), velocity=Box((-0.4, 1, -0.4), (0.4, 2, 0.4))
    )
    bunches.append(bunch)

with world, motes.Movie(f"{args.out}/balloons.mp4") as movie:
    for frame in world.frames(args.frames):
        for bunch in bunches:
            if frame == 0:
                bunch.burst(Box((-13, 2.5, -12), (9, 17, 8)), count=args.particles)
            for start in (
                Box((-16, -0.6, -14), (11, 0, -10)),
                Box((-8, -1.6, 7), (4, -1.2, 11)),
            ):  # out of sight
                bunch.source(start, rate=args.particles / 16, jitter=True)
            bunch.set(velocity=column("velocity") + (0, 2.2 * world.dt, 0) / column("mass"))
            bunch.curl_noise(1.5, scale=5, octaves=2, speed=0.15)
            bunch.wind((0.55, 0, 0), drag=1.2)
            sway = column("velocity") * (0.12, 0, 0) + (0, 1, 0)  # the string trails behind
            bunch.set(up=sway)
            bunch.sink(Box((-60, -9, -60), (60, 21, 60)), inside=False)
            bunch.move()
        motes.script.end_frame(world, movie, args)
