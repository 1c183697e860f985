"""Small and large grains part in a drum that turns: python -m motes run -n 4 examples/grains/drum.py."""

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Cylinder, Mesh

args = motes.script.options(__doc__, space="-0.3,0.3", systems=1, particles=3000, frames=240, size="960x540")

# Metres. A closed, turning mesh holds the grains; a ring is drawn instead of it.
radius, depth, degrees = 0.25, 0.1, 3.0
turn = np.arange(96) * 2 * np.pi / 96
ring = np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=1)
ends = [np.column_stack([ring, np.full(96, z)]) for z in (0, depth)]
near, after = np.arange(96), np.roll(np.arange(96), -1)
sides = np.stack([near, after, after + 96], 1), np.stack([near, after + 96, near + 96], 1)
lids = np.stack([0 * near + 192, after, near], 1), np.stack([0 * near + 193, near + 96, after + 96], 1)
vertices = np.concatenate([*ends, [(0, 0, 0), (0, 0, depth)]])
drum = Mesh(vertices, np.concatenate([*sides, *lids]), resolution=128)

steel = (0.2, 0.21, 0.23)
solids = [
    motes.Solid(Cylinder((0, 0, -0.01), (0, 0, depth), 1.06 * radius, radius), steel),
    motes.Solid(Cylinder((0, 0, -0.02), (0, 0, -0.01), 1.06 * radius), (0.05, 0.055, 0.065)),
    motes.Solid(Box((-1, -0.9, -0.2), (1, -0.285, 0.6)), (0.1, 0.06, 0.035)),
]
camera = motes.Camera((0.12, 0.12, 1.15), (0, -0.01, 0.03), fov_deg=33)
renderer = motes.Renderer(*args.size, camera=camera, background=(0.02, 0.025, 0.03), objects=solids)

# The lightest grains touch for pi sqrt(mass / (2 stiffness)) = 1.6 ms: 20 sub-steps.
world = motes.World(**args.world, substeps=500, renderer=renderer)
grains = world.system("grains", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))

# Grains start on a grid in the lower part; one in six is twice as wide.
pitch = 0.0125
x, y, z = (g.ravel() for g in np.mgrid[-20:21, -20:21, 0:8])
place = np.stack([x * pitch, y * pitch, (z + 0.5) * depth / 8], axis=1)
place = place[(np.hypot(place[:, 0], place[:, 1]) < radius - pitch) & (place[:, 1] < 0.02)][: args.particles]
dice = np.random.default_rng(args.seed)
large = dice.uniform(size=len(place)) < 1 / 6
size = np.where(large, 0.0125, 0.0075) * dice.uniform(0.95, 1, len(place))
color = np.where(large[:, None], (0.9, 0.85, 0.75), (0.75, 0.22, 0.06))

with world, motes.Movie(f"{args.out}/drum.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            mass = 2500 * np.pi / 6 * size**3
            grains.emit(position=place.round(5), size=np.repeat(size[:, None], 3, 1), mass=mass, color=color)
        before = drum.at(axis=(0, 0, 1), angle_deg=degrees * frame)
        here = drum.at(axis=(0, 0, 1), angle_deg=degrees * (frame + 1), moving_from=before)
        grains.gravity((0, -9.81, 0))
        grains.contact(1000, restitution=0.3, friction=0.6, rolling_friction=0.05, walls=[here])
        grains.move()
        motes.script.end_frame(world, movie, args)
    high = column("position").y > -0.05
    world.say(f"At the end {grains.total(1, where=high):.0f} of {grains.count} grains are high in the drum.")
