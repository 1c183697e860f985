"""Grains are poured over steps into a heap that stands still: python -m motes run -n 4 examples/heap.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Cylinder, Plane, Union

args = motes.script.options(__doc__, space="-1.6,1.2", systems=1, particles=8000, frames=192, size="960x540")

# Grains fall out of a pipe on the uppermost of three steps before a wall, and run down to the floor. Metres.
radius = 0.025
walls = [(-1.7, -1.5, 1.7, 0.9), (-1.5, -1.05, 0.9, 0.6), (-1.05, -0.6, 0.6, 0.6), (-0.6, -0.15, 0.3, 0.6)]


def masonry(more=0):
    """Return the steps and the wall, thicker by a margin on all sides."""
    parts = [((x0 - more, -1, -z - more), (x1 + more, y + more, z + more)) for x0, x1, y, z in walls]
    return Union(*(Box(low, high) for low, high in parts))


pipe = Cylinder((-1.2, 1.6, 0), (-1.2, 2.4, 0), 0.32, 0.3)
solids = [motes.Solid(Plane((0, 0, 0), (0, 1, 0)), (0.07, 0.068, 0.065))]
solids += [motes.Solid(masonry(), (0.14, 0.15, 0.17)), motes.Solid(pipe, (0.03, 0.05, 0.09))]
camera = motes.Camera((1.5, 1.75, 3.3), (-0.62, 0.66, 0), fov_deg=36)
renderer = motes.Renderer(*args.size, camera=camera, background=(0.2, 0.26, 0.32), objects=solids)
# More interactions per frame make stacked grains stiffer: here 20.
world = motes.World(**args.world, substeps=20, renderer=renderer)
grains = world.system("grains", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))

# Newborn grains must not overlap, or they fly apart: each frame emits one layer of them, on a grid.
row = np.arange(-5, 6) * 2.2 * radius
x, z = (grid.ravel() for grid in np.meshgrid(row, row))
mouth = np.stack([x - 1.2, 0 * x + 2.1, z], axis=1)[x * x + z * z < 0.26**2]
dice = np.random.default_rng(args.seed)
tones = [(0.75, 0.3, 0.08), (0.9, 0.75, 0.45), (0.3, 0.08, 0.05), (0.9, 0.85, 0.75)]

with world, motes.Movie(f"{args.out}/heap.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame * len(mouth) < args.particles:
            jitter = dice.uniform(-1, 1, mouth.shape) * (0.002, 0.02, 0.002)
            grains.configure(velocity=(0, -2.2, 0), size=2 * radius, color=tones[frame // 22 % len(tones)])
            grains.emit(position=(mouth + jitter).round(4))
        grains.gravity((0, -9.81, 0))
        grains.collide(radius, friction=0.6)
        # Only centres bounce, so solids are enlarged by a radius. Grains that hit them stop dead.
        for solid in (masonry(radius), Plane((0, radius, 0), (0, 1, 0))):
            grains.bounce(solid, restitution=0, friction=1, exact_hit=False)
        grains.move()
        motes.script.end_frame(world, movie, args)
    moving = grains.total(1, where=column("velocity").length() > 0)
    world.say(f"At the end {moving:.0f} of {grains.count} grains move.")
