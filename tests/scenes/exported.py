"""Exports in all formats at once, plus the results of `gather`; the manager prints each frame's digest.

Arguments: a folder, which gets reference.npz; where in a frame to write: end, middle or never; the formats.
"""

import argparse

import numpy as np

import motes
from motes import expressions as ex
from motes.shapes import Box, Plane, Sphere

parser = argparse.ArgumentParser()
parser.add_argument("folder")
parser.add_argument("where", choices=("end", "middle", "never"))
parser.add_argument("formats", nargs="*")
parser.add_argument("--roles", default="auto")
parser.add_argument("--substeps", type=int, default=1)
args = parser.parse_args()

FRAMES = 8
world = motes.World(
    seed=9,
    space=(-1, 1),
    roles=args.roles,
    substeps=args.substeps,
    progress="off",
    balancer=motes.balance.PrefixCuts(0.01, min_particles=1),
)
snow = world.system("snow", attributes={"heat": 0.5, "wind": (0, 0, 1)})
rain = world.system("rain, fine", capacity=150, axis="y")
world.system("empty")
names = {"npz": "all", "pvd": "all.pvd", "usd": "all.usd"}
exports = [motes.Export(f"{args.folder}/{names[one]}") for one in args.formats]
if args.where == "end":
    exports.append(motes.Export(f"{args.folder}/third", every=3))
    exports.append(motes.Export(f"{args.folder}/some", attributes=["heat", "size", "heat", "id"]))
seen = {}


def write(frame):
    """Write to all exports, and keep the results of `gather`."""
    for export in exports:
        export.write(world)
    for system in world.systems:
        for name, column in (system.gather() or motes.Particles({"id": np.empty(0)})).columns().items():
            seen[f"{system.name}/{frame}/{name}"] = column
        gathered = system.gather()
        if gathered:
            seen[f"{system.name}/{frame}/id"] = gathered.id


with world:
    for frame in world.frames(FRAMES):
        if frame == 3:
            late = world.system("late")
        if frame >= 4:
            late.burst(Sphere((0, 0, 0), 1), count=frame)
        snow.configure(velocity=Sphere((0, 0, 0), 3), color=motes.Uniform((0, 0, 0), (1, 1, 1)))
        snow.configure(heat=motes.Uniform(0, 1), lifetime=motes.Uniform(0.1, 0.3))
        snow.source(Box((-1, -1, -1), (1, 1, 1)), rate=4800, jitter=True)
        snow.random_acceleration(Sphere((0, 0, 0), 3))
        snow.kill_expired()
        if args.where == "middle":
            write(frame)
        snow.move()
        if frame == 5:
            snow.set(size=ex.column("age"))
        snow.sink(Plane((0, -0.9, 0), (0, 1, 0)))
        rain.source(Box((-1, 0.8, 0.9), (-0.9, 1, 1)), rate=1200)  # only few calculators have particles of it
        rain.move()
        world.step()
        world.say(f"{frame} {world.digest()}")
        if args.where == "end":
            write(frame)
    for export in exports[1:]:
        export.close()  # the end of the world closes the first
if world.rank == 0 and seen:
    np.savez(f"{args.folder}/reference.npz", **seen)
