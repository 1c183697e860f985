"""A fountain on a fast and a slow machine: python -m motes run -n 4 examples/heterogeneous.py.

The last calculator spends as much time as a machine of half the speed would. Watch the work split 2:1;
then try --balancer static, and compare the seconds.
"""

import json
from collections import defaultdict
from pathlib import Path

from mpi4py import MPI

import motes
from motes.shapes import Plane, Sphere

args = motes.script.options(
    __doc__, space="-16,16", systems=1, frames=48, balancer="pairwise", size="640x360"
)
args.log = args.log or f"{args.out}/heterogeneous"
calculators = list(range(2, MPI.COMM_WORLD.size)) or [MPI.COMM_WORLD.size - 1]
roles = motes.Roles(
    image_generator=0,
    manager=min(1, MPI.COMM_WORLD.size - 1),
    calculators=calculators,
    speeds={calculators[-1]: 0.5},
)
camera = motes.Camera((0, 5, 30), (0, 5, 0), fov_deg=35)
world = motes.World(
    seed=args.seed,
    space=args.space,
    roles=roles,
    balancer=args.balancer,
    renderer=motes.Renderer(*args.size, camera=camera),
    log=args.log,
)
water = world.system("water", capacity=args.particles, sprite=motes.Sprite("disc", pixels=3))
water.configure(velocity=Sphere((0, 11, 0), 3), color=(0.3, 0.6, 1), alpha=0.03)

with world, motes.Movie(f"{args.out}/heterogeneous.mp4") as movie:
    for frame in world.frames(args.frames):
        if frame == 0:
            water.burst(Sphere((0, 6, 0), 4), count=args.particles // 2)
        water.source(Sphere((0, 0.5, 0), 0.3), rate=args.particles / 4)
        water.gravity((0, -9.81, 0))
        water.bounce(Plane((0, 0, 0), (0, 1, 0)), restitution=0.4, friction=0.1)
        water.kill_old(2.2)
        water.move()
        motes.script.end_frame(world, movie, args)

if "manager" in world.role:
    held = defaultdict(list)
    for line in Path(args.log, "load.jsonl").read_text().splitlines():
        row = json.loads(line)
        held[row["frame"]].append(row["n_end"])
    for frame in range(0, args.frames, 4):
        total = max(1, sum(held[frame]))
        print(f"frame {frame:3}  " + "  ".join(f"{100 * n / total:5.1f} %" for n in held[frame]), flush=True)
