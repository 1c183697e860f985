"""Grains run out of a hopper and pile up: python -m motes run -n 4 examples/grains/hopper.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Plane, Rectangle

args = motes.script.options(__doc__, space="-0.5,0.5", systems=1, particles=6000, frames=240, size="960x540")

# Metres: two slopes that leave a slot of six grains between them, glass in front and behind, a tray below.
diameter, slot, depth = 0.02, 0.12, 0.2
foot, mouth = 0.45, 0.8
slopes = [
    Rectangle((side * slot / 2, foot, 0), (side * 0.3, mouth - foot, 0), (0, 0, depth)) for side in (-1, 1)
]
sides = [Plane((side * 0.36, 0, 0), (-side, 0, 0)) for side in (-1, 1)]
glass = [Plane((0, 0, z), (0, 0, way)) for z, way in ((0, 1), (depth, -1))]
tray = Plane((0, 0, 0), (0, 1, 0))
gate = Rectangle((-slot, foot, 0), (2 * slot, 0, 0), (0, 0, depth))

steel, wood = (0.16, 0.17, 0.19), (0.1, 0.06, 0.035)
solids = [
    motes.Solid(tray, wood),
    motes.Solid(Box((-0.9, 0, -0.03), (0.9, 1.6, -0.001)), (0.03, 0.045, 0.07)),
]
solids += [motes.Solid(slope, steel) for slope in slopes]
solids += [motes.Solid(Box((x, mouth, 0), (x + 0.01, 1.5, depth)), steel) for x in (-0.37, 0.36)]
camera = motes.Camera((0.35, 0.75, 2.3), (0, 0.6, 0.1), fov_deg=38)
renderer = motes.Renderer(*args.size, camera=camera, background=(0.02, 0.025, 0.03), objects=solids)

# Two grains touch for pi sqrt(mass / (2 stiffness)) = 5 ms: 24 sub-steps.
world = motes.World(**args.world, substeps=200, renderer=renderer)
grains = world.system("grains", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))

# Layers on a grid, in coloured stripes, fall into the closed hopper.
x, z = (grid.ravel() for grid in np.meshgrid(np.arange(-14, 15) * 1.15, np.arange(0.6, 9.5, 1.1)))
layers = -(-args.particles // len(x))
y = mouth / diameter - 6 + np.repeat(np.arange(layers), len(x)) * 1.15
place = np.stack([np.tile(x, layers), y, np.tile(z, layers)], axis=1)[: args.particles] * diameter
room = np.abs(place[:, 0]) < slot / 2 + (place[:, 1] - foot) * 0.3 / (mouth - foot) - diameter
place = place[room | (place[:, 1] > mouth)]
jitter = np.random.default_rng(args.seed).uniform(-0.04, 0.04, place.shape) * diameter
tones = np.array([(0.8, 0.35, 0.08), (0.85, 0.75, 0.5), (0.12, 0.3, 0.45), (0.9, 0.88, 0.8)])

with world, motes.Movie(f"{args.out}/hopper.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            stripe = (place[:, 1] / (6 * diameter)).astype(int) % len(tones)
            grains.configure(size=diameter, mass=0.01)
            grains.emit(position=(place + jitter).round(5), color=tones[stripe])
        walls = [tray, *slopes, *sides, *glass, *([gate] if frame < 24 else [])]
        grains.gravity((0, -9.81, 0))
        grains.contact(2000, restitution=0.4, friction=0.5, rolling_friction=0.05, walls=walls)
        grains.move()
        motes.script.end_frame(world, movie, args)
    out = grains.total(1, where=column("position").y < foot)
    world.say(f"At the end {out:.0f} of {grains.count} grains have left the hopper.")
