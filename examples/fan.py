"""A fan passes below a floor of balls and blows them up: python -m motes run -n 4 examples/fan.py."""

import colorsys

import numpy as np

import motes
from motes.shapes import Box, Cylinder, Plane, Triangle

args = motes.script.options(__doc__, space="-3,3", systems=1, particles=1400, frames=144, size="960x540")

# A tray with a grid as its floor; the fan runs to and fro below it. Metres.
wide, deep, radius = 2.9, 1.3, 0.075
frame_bars = [Box((-wide - 0.1, -0.12, z), (wide + 0.1, 0.25, z + 0.08)) for z in (-deep - 0.08, deep)]
frame_bars += [Box((x, -0.12, -deep), (x + 0.1, 0.25, deep)) for x in (-wide - 0.1, wide)]
bars = [Box((x, -0.03, -deep), (x + 0.012, -0.005, deep)) for x in np.arange(-2.8, 2.9, 0.14).round(2)]
legs = [
    Box((x, -1.5, z), (x + 0.12, -0.12, z + 0.12)) for x in (-wide, wide - 0.12) for z in (-deep, deep - 0.12)
]
solids = [motes.Solid(Plane((0, -1.5, 0), (0, 1, 0)), (0.22, 0.23, 0.25))]
solids += [motes.Solid(bar, (0.30, 0.19, 0.10)) for bar in (*frame_bars, *legs)]
solids += [motes.Solid(bar, (0.1, 0.1, 0.11)) for bar in bars]
camera = motes.Camera((1.2, 1.9, 8.6), (0, 0.75, 0), fov_deg=33)
renderer = motes.Renderer(
    *args.size, camera=camera, background=(0.45, 0.5, 0.56), sun=(-0.5, 0.9, 0.5), shutter=0.3
)
world = motes.World(**args.world, substeps=12, renderer=renderer)

balls = world.system("balls", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))
balls.configure(size=2 * radius)
dice = np.random.default_rng(args.seed)
across, layers = int(2 * wide / (2.1 * radius)), int(2 * deep / (2.1 * radius))
k = np.arange(args.particles)
place = np.stack([k % across, k // (across * layers), k // across % layers], axis=1) * 2.1 * radius
place += np.array([-wide, 0.02, -deep]) + 1.05 * radius + dice.uniform(-0.004, 0.004, place.shape)
hues = [colorsys.hsv_to_rgb(h, 0.95, 0.8) for h in (0.0, 0.08, 0.14, 0.36, 0.56, 0.78)]

with world, motes.Movie(f"{args.out}/fan.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            balls.emit(position=place.round(4), color=np.array(hues)[dice.integers(6, size=len(k))])
        x = round(2.1 * np.sin(2 * np.pi * world.time / 6), 4)
        hub = [Cylinder((x, -0.75, 0), (x, -0.55, 0), 0.12), Cylinder((x, -1.5, 0), (x, -0.75, 0), 0.04)]
        for blade in range(5):
            edges = 2.1 * frame + 1.2566 * blade + np.array([0, 0.85])
            (c0, c1), (s0, s1) = (0.6 * np.cos(edges)).round(4), (0.6 * np.sin(edges)).round(4)
            hub.append(Triangle((x, -0.62, 0), (x + c0, -0.7, s0), (x + c1, -0.54, s1)))
        renderer.objects = [*solids, *(motes.Solid(part, (0.6, 0.1, 0.05)) for part in hub)]
        balls.gravity((0, -9.81, 0))
        balls.jet(Cylinder((x, -0.5, 0), (x, 1.5, 0), 0.55), acceleration=Box((-4, 13, -4), (4, 22, 4)))
        balls.collide(radius, restitution=0.5, friction=0.2)
        balls.wind((0, 0, 0), drag=0.25)
        inner = Box((-wide + radius, radius, -deep + radius), (wide - radius, 20, deep - radius))
        balls.bounce(inner, restitution=0.4, friction=0.05)
        balls.move()
        motes.script.end_frame(world, movie, args)
