"""Exports with columns of every kind for other programs, plus the results of `gather`.

Argument: a folder, which gets the exports and reference.npz. Systems: grains with orientations, whose color
and alpha start late; drops of which as many die as are born; one that starts late; one that stays empty; and
one with attributes of the user, whose names other programs also use.
"""

import sys

import numpy as np

import motes
from motes.expressions import column
from motes.shapes import Box, Disc, Sphere

folder = sys.argv[1]
FRAMES, LATE, STARTS = 10, 5, 3
world = motes.World(seed=5, dt=1 / 60, space=(-1, 1), roles="shared", progress="off")
grains = world.system("grains", attributes={"heat": 1.0, "wind": (0, 0, 1)})
grains.clumps([(0, 0, 0, 0.02), (0.03, 0, 0, 0.02), (0, 0.02, 0, 0.01)], density=1000)
drops = world.system("drops of rain")
named = world.system(
    "named", attributes={"displayColor": (0, 0, 1), "widths": 0.5, "normals": (0, 1, 0), "Points": (7, 8, 9)}
)
world.system("void")
exports = [motes.Export(f"{folder}/all{suffix}") for suffix in ("", ".pvd", ".usd")]
exports.append(motes.Export(f"{folder}/fours", every=4))
seen = {}
with world:
    for frame in world.frames(FRAMES):
        if frame == STARTS:
            late = world.system("late")
        if frame >= STARTS:
            late.configure(size=motes.Uniform(0.1, 0.2))
            late.burst(Sphere((0, 0, 0), 1), count=frame)
        grains.configure(velocity=Sphere((0, 0, 0), 2), orientation="random", spin=Sphere((0, 0, 0), 9))
        grains.configure(heat=motes.Uniform(0, 1), wind=Sphere((0, 0, 0), 1))
        grains.burst(Box((-1, -1, -1), (1, 1, 1)), count=20)
        if frame >= LATE:
            grains.set(color=(0.9, 0.2, 0.1), alpha=column("heat"), mass=2 * column("heat"))
        grains.move()
        drops.configure(velocity=(0, -9, 0), size=motes.Uniform((0.01, 0.01, 0.01), (0.03, 0.02, 0.02)))
        drops.source(Disc((0, 1, 0), (0, 1, 0), 1), rate=1800)  # 30 per frame, each for 4 frames
        drops.kill_old(3.5 / 60)
        drops.move()
        named.configure(displayColor=Sphere((0, 0, 0), 1), widths=motes.Uniform(0, 1))
        if frame == 0:
            named.burst(Sphere((0, 0, 0), 1), count=1)  # on one rank only
        world.step()
        for export in exports:
            export.write(world)
        for system in world.systems:
            gathered = system.gather()
            if gathered is not None and world.rank == 0:
                for name in ("id", *gathered.columns()):
                    seen[f"{system.name}/{frame}/{name}"] = getattr(gathered, name)
if world.rank == 0:
    np.savez(f"{folder}/reference.npz", **seen)
