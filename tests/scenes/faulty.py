"""A small scene in which one rank (or all: -1) fails in frame 3; the first argument says how."""

from __future__ import annotations

import ctypes
import os
import resource
import sys
import time
from pathlib import Path

import numpy as np

import motes
from motes import shapes

FRAME = 3
kind, who = sys.argv[1], int(sys.argv[2])


def note() -> None:
    """Print the time of the fault."""
    os.write(1, b"failing at %f\n" % time.time())


log = None
if kind == "bad log":
    log = "/dev/null/log"
    note()

world = motes.World(
    seed=5,
    space=(-1, 1),
    roles=os.environ.get("MOTES_TEST_ROLES", "auto"),
    renderer=motes.Renderer(64, 48, camera=motes.Camera((0, 1, 8), (0, 1, 0))),
    progress="off",
    log=log,
)
system = world.system("sparks")


def fail(frame: int) -> bool:
    """Fail in frame 3 on the chosen rank; return whether to leave the loop."""
    if frame != FRAME or who not in (-1, world.rank):
        return False
    note()
    if kind == "raise":
        raise ValueError("the mistake")
    if kind.startswith("exit"):
        sys.exit(int(kind.split()[1]))
    if kind == "segfault":
        ctypes.string_at(0)
    if kind == "kill":
        os.kill(os.getpid(), 9)
    if kind == "another action":
        system.gravity((0, 0, 1))
    if kind == "another call":
        world.digest()
    if kind == "no memory":
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        most = pages * resource.getpagesize() + (3 << 20)
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
        library = ctypes.CDLL(None)
        library.malloc.restype = ctypes.c_void_p
        while library.malloc(ctypes.c_size_t(1 << 18)):  # also use up memory that earlier frames freed
            pass
    return kind == "break"


def draw(frame: int) -> bool:
    """Record and render one frame; return whether to leave the loop."""
    if kind == "no memory" and frame == 0:
        system.configure(velocity=motes.Uniform((0, 0, 0), (0, 0, 1)))
        system.burst(shapes.Box((0.1, 0, 0), (0.9, 1, 1)), count=500_000)
    if kind == "no memory" and frame == FRAME:  # new columns need memory for existing particles
        drawn = motes.Uniform((0, 0, 0), (1, 1, 1))
        system.configure(
            rotational_velocity=drawn, color=drawn, size=drawn, up=drawn, mass=motes.Uniform(1, 2)
        )
    system.source(shapes.Box((-1, 0, -1), (1, 1, 1)), rate=24 * 200)
    if kind == "another parameter" and frame == FRAME and world.rank == who:
        note()
        system.gravity((0, -9.5, 0))
    else:
        system.gravity((0, -9.8, 0))
    if kind == "another last bit" and frame == FRAME:
        speeds = np.float32([(1, 2, 3), (4, 5, 0)])
        if world.rank == who:
            note()
            speeds[:, :2] = np.nextafter(speeds[:, :2], np.float32(9))
        system.emit(position=np.zeros((2, 3)), velocity=speeds)
    elif fail(frame):
        return True
    system.random_acceleration(shapes.Sphere((0, 0, 0), 30))
    system.move()
    if kind == "no memory":
        try:
            world.step()
        except motes.RankError as error:
            os.write(1, f"caught {type(error).__name__} on rank {world.rank}: {error}\n".encode())
            raise
    else:
        world.render()
    return False


with world:
    for number in world.frames(10**9 if kind in ("endless", "stall") else 6):
        if kind in ("endless", "stall") and number == FRAME and world.rank == who:
            Path(sys.argv[3]).write_text(f"{os.getpid()}\n")
        if draw(number):
            break
if kind == "none":
    world.say("done")
