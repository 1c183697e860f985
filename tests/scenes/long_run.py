"""A long run in which everything is created and deleted: `long_run.py OUT FRAMES [--keep]`.

Prints one row per rank at the end: `RANK KILOBYTES ...`, its resident memory after each tenth of the frames.
`--keep`: with replicas against losses, and checkpoints.
"""

import sys

from mpi4py import MPI

import motes
from motes.shapes import Disc, Plane, Sphere

out, frames, keeps = sys.argv[1], int(sys.argv[2]), "--keep" in sys.argv


def resident_kb() -> int:
    """Return this process's anonymous resident memory (no mapped files), in KiB."""
    with open("/proc/self/status", encoding="ascii") as status:
        lines = dict(line.split(":", 1) for line in status)
    return int(lines["RssAnon"].split()[0])


ground = Plane((0, 0, 0), (0, 1, 0))
world = motes.World(
    seed=7,
    space=(-3, 3),
    balancer=motes.balance.Pairwise(threshold=0.02, min_particles=10),
    log=f"{out}/log",
    progress="off",
    on_loss="recover" if keeps else "stop",
    checkpoint=motes.Checkpoint(f"{out}/checkpoints", every=200) if keeps else None,
    renderer=motes.Renderer(96, 64, camera=motes.Camera((0, 2, 9), (0, 1.5, 0))),
)
sparks = world.system("sparks", capacity=4000)
sparks.configure(velocity=Sphere((0, 4, 0), 1.5), color=(1, 0.5, 0.15))
embers = world.system("embers", capacity=4000)
embers.configure(velocity=Sphere((0, 1, 0), 0.5))
snow = world.system("snow")
rows: list[int] = []
with world, motes.Movie(f"{out}/film.mp4") as movie:
    for frame in world.frames(frames):
        if frame % (frames // 10) == 0:
            rows.append(resident_kb())
        place = 2 * ((frame % 400) / 200 - 1)  # moves the load, and with it the domains
        sparks.source(Disc((place, 0.1, 0), (0, 1, 0), 0.2), rate=1500)
        sparks.gravity((0, -9.81, 0))
        sparks.spawn(into=embers, on="collision", count=1)
        sparks.bounce(ground, restitution=0.5, friction=0.1)
        sparks.kill_old(1)
        sparks.move()
        embers.kill_old(0.5)
        embers.move()
        if frame % 100 == 0:
            snow.burst(Sphere((place, 1, 0), 0.5), count=500)
        snow.gravity((0, -2, 0))
        snow.kill_old(2)
        snow.move()
        movie.write(world.render())
rows.append(resident_kb())
all_rows = MPI.COMM_WORLD.gather(rows)
if all_rows is not None:
    for rank, numbers in enumerate(all_rows):
        print(rank, *numbers)
