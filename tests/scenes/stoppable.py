"""A run that signals stop. Each rank writes its process id to a folder when it may be signalled."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import motes

kind, folder = sys.argv[1], Path(sys.argv[2])
ready = 0 if kind == "first" else 2
world = motes.World(
    seed=5,
    space=(-1, 1),
    renderer=motes.Renderer(64, 48, camera=motes.Camera((0, 1, 8), (0, 1, 0))),
    progress="off",
    log=folder / "log",
)
sparks = world.system("sparks")


def note() -> None:
    """Report that this rank may now be signalled."""
    draft = folder / f"{world.rank}.part"
    draft.write_text(str(os.getpid()))
    draft.rename(folder / f"{world.rank}.pid")


def slow(particles: object) -> None:
    """Take long while the other ranks wait."""
    if world.rank == world.calculators[0]:
        note()
        time.sleep(1)


def record(frame: int) -> None:
    """Record one frame."""
    if frame == ready and kind != "callback":
        note()
    late = kind in ("wait", "gather") and world.rank == world.size - 1
    time.sleep(1.5 if late and frame == ready else 30 if kind == "long" and frame == ready else 0.05)
    sparks.burst(motes.shapes.Box((-1, 0, 0), (1, 1, 1)), count=20)
    if kind == "callback" and frame == ready:
        sparks.callback(slow)
    sparks.move()
    if kind == "gather":
        assert len(sparks.gather(to="all")) == 20 * (frame + 1)


count = 0
with world, motes.Movie(folder / "a.mp4") as movie:
    if kind == "own":
        while True:
            record(world.frame)
            movie.write(world.render())
    for frame in world.frames(1000):
        record(frame)
        movie.write(world.render())
        count += 1
    assert list(world.frames(1000)) == []
os.write(1, b"rank %d stopped after frame %d\n" % (world.rank, count))
try:
    world = motes.World(seed=1, log=folder / "second")
    with world:
        os.write(1, b"a second run has started\n")
except motes.errors.Stopped:
    os.write(1, b"no second run\n")
