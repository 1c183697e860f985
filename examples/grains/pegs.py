"""Pegs of four balls fall onto a disc and pile up: python -m motes run -n 4 examples/grains/pegs.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Cylinder, Disc, Plane

args = motes.script.options(__doc__, space="-0.4,0.4", systems=1, particles=900, frames=200, size="960x540")

# Metres. A peg is a row of overlapping balls; the disc lies on a floor that removes pegs that slip off.
width, disc = 0.03, 0.3
peg = [(x * 0.6 * width, 0, 0, 0.5 * width) for x in (-1.5, -0.5, 0.5, 1.5)]
plate = Disc((0, 0, 0), (0, 1, 0), disc)

solids = [
    motes.Solid(Cylinder((0, -0.06, 0), (0, 0, 0), disc), (0.2, 0.21, 0.23)),
    motes.Solid(Plane((0, -0.06, 0), (0, 1, 0)), (0.05, 0.06, 0.08)),
]
camera = motes.Camera((0.5, 0.5, 1.0), (0, 0.09, 0), fov_deg=38)
renderer = motes.Renderer(*args.size, camera=camera, background=(0.02, 0.025, 0.03), objects=solids)

# Two pegs touch for pi sqrt(mass / (2 stiffness)) = 6 ms, their ends for half as long.
world = motes.World(**args.world, substeps=200, renderer=renderer)
pegs = world.system("pegs", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))
pegs.clumps(peg, density=700)

# Falling layers, each peg turned at random.
dice = np.random.default_rng(args.seed)
pitch = 2.9 * width
x, z = (grid.ravel() * pitch for grid in np.meshgrid(np.arange(-2, 3), np.arange(-2, 3)))
layers = -(-args.particles // len(x))
y = 0.1 + np.repeat(np.arange(layers), len(x)) * pitch
place = np.stack([np.tile(x, layers), y, np.tile(z, layers)], axis=1)[: args.particles]
place[:, [0, 2]] += dice.uniform(-0.3, 0.3, (len(place), 2)) * width
tones = np.array([(0.75, 0.3, 0.08), (0.85, 0.7, 0.4), (0.15, 0.3, 0.4), (0.85, 0.83, 0.75)])

with world, motes.Movie(f"{args.out}/pegs.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            pegs.configure(orientation="random", velocity=(0, -2, 0))
            pegs.emit(position=place.round(5), color=tones[dice.integers(0, 4, len(place))])
        pegs.gravity((0, -9.81, 0))
        pegs.contact(4000, restitution=0.3, friction=0.5, walls=[plate])
        pegs.sink(Plane((0, -0.04, 0), (0, 1, 0)))
        pegs.move()
        motes.script.end_frame(world, movie, args)
    high = pegs.total(1, where=column("position").y > 3 * width)
    world.say(f"At the end {pegs.count} of {pegs.born} pegs lie on the disc, {high:.0f} of them high.")
