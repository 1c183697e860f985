"""Coloured sand runs over a toy of wood and glass: python -m motes run -n 4 examples/bounce_toy.py."""

import colorsys
from itertools import pairwise

import motes
from motes.shapes import Box, Cone, Cylinder, Disc, Plane, Sphere, Triangle, Union

args = motes.script.options(__doc__, space="-5,5", systems=7, particles=120_000, frames=168, size="960x540")

# The toy, from top to bottom, in metres: cones, drums, balls, and between steps two tents on the floor.
cones = [Cone((x, 8.6, 0), (x, 7.4, 0), 1.1) for x in (-3.86, 0, 3.86)]
drums = [Cylinder((x, 5.8, -1.5), (x, 5.8, 1.5), 0.75) for x in (-5.6, -1.93, 1.93, 5.6)]
balls = [Sphere((x, 3.5, 0), 0.85) for x in (-3.6, 0, 3.6)]
steps = [
    Box((x, 0, -1.3), (x + 1, height, 1.3))
    for x, height in ((-6.4, 1.4), (-5.4, 0.7), (4.4, 0.7), (5.4, 1.4))
]
tents = []  # four triangles each, from the sides of a square to a point above its middle
corners = [(-1.2, -1.2), (1.2, -1.2), (1.2, 1.2), (-1.2, 1.2), (-1.2, -1.2)]
for x in (-1.8, 1.8):
    for (x0, z0), (x1, z1) in pairwise(corners):
        tents.append(Triangle((x + x0, 0, z0), (x + x1, 0, z1), (x, 1.7, 0)))
floor = Plane((0, 0, 0), (0, 1, 0))

painted = [
    (Union(*cones), (0.45, 0.04, 0.03)),
    (Union(*drums), (0.40, 0.24, 0.03)),
    (Union(*balls), (0.03, 0.19, 0.40)),
    (Union(*steps), (0.05, 0.24, 0.08)),
    (Union(*tents), (0.28, 0.06, 0.31)),
]
toy = Union(*(shape for shape, _ in painted))  # one bounce off all of it
solids = [motes.Solid(floor, (0.025, 0.025, 0.03)), *(motes.Solid(*part) for part in painted)]
camera = motes.Camera((3.5, 7.0, 17), (0, 4.25, 0), fov_deg=38)
renderer = motes.Renderer(*args.size, camera=camera, background=(0.006, 0.006, 0.009), objects=solids)
# With one sub-step, sand that has fallen nine metres would move half a metre at a time.
world = motes.World(**args.world, substeps=2, renderer=renderer)

streams = []  # side by side, in the colours of the rainbow
for i in range(args.systems):
    part = (i + 0.5) / args.systems
    sand = world.system(f"sand {i}", capacity=args.particles, sprite=motes.Sprite(height=0.0037))
    sand.configure(color=colorsys.hsv_to_rgb(0.9 * part, 0.88, 1), alpha=0.2)
    sand.configure(velocity=Sphere((0, -4, 0), 0.25), lifetime=motes.Uniform(2.2, 3.5))
    streams.append((sand, Disc((9 * part - 4.5, 10.6, 0), (0, 1, 0), 0.22)))

with world, motes.Movie(f"{args.out}/bounce_toy.mp4") as movie:
    for _ in world.frames(args.frames):
        for sand, mouth in streams:
            sand.source(mouth, rate=args.particles / 3, jitter=True)
            sand.gravity((0, -9.81, 0))
            sand.bounce(toy, restitution=0.35, friction=0.06)
            sand.bounce(floor, restitution=0.25, friction=0.4)
            sand.kill_expired()
            sand.move()
        motes.script.end_frame(world, movie, args)
