"""Child processes started in every way, before, inside and after a world; each runs its own world."""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
from collections.abc import Callable

if sys.argv[2:] == ["mpi4py"]:
    from mpi4py import MPI  # noqa: F401

import motes

HELPER = """
import motes
world = motes.World(seed=1, progress="off", on_loss="recover")
system = world.system("s")
with world:
    for frame in world.frames(2):
        system.burst((0, 0, 0), count=3)
        world.step()
print(world.rank, world.size, system.count)
"""


def run_a_world(log: str) -> tuple[int, int, int]:
    """Run a world with everything that communicates: a log and checkpoints."""
    world = motes.World(seed=1, progress="off", log=log, checkpoint=f"{log}.saved")
    system = world.system("s")
    with world:
        for _ in world.frames(2):
            system.burst((0, 0, 0), count=3)
            world.step()
    return world.rank, world.size, system.count


def pools(where: str) -> None:
    """Run a world in a pool's process, for each start method."""
    for way in ("fork", "spawn", "forkserver"):
        with multiprocessing.get_context(way).Pool(1) as pool:
            print(where, way, pool.apply(run_a_world, (f"{where}.{way}.{rank}",)), flush=True)


def helper(where: str, first: str = "") -> None:
    """Run a world in a separate script."""
    ended = subprocess.run([sys.executable, "-c", first + HELPER], capture_output=True, text=True, timeout=60)
    print(where, "helper", ended.stdout.strip(), ended.stderr, flush=True)


def forks(where: str, *ends: Callable[[], object]) -> None:
    """Fork this process once per way to end the child."""
    codes = []
    for end in ends:
        child = os.fork()
        if child == 0:
            end()
            sys.exit(9)
        codes.append(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
    print(where, "forks", codes, flush=True)


if __name__ == "__main__":
    wanted = sys.argv[1].split(",")
    world = motes.World(seed=2, progress="off")
    rank, system = world.rank, world.system("s")
    if "before" in wanted:
        pools("before")
        forks("before", lambda: sys.exit(7), world.open)
    with world:
        for frame in world.frames(3):
            system.burst((0, 0, 0), count=9)
            if frame == 1 and "inside" in wanted:
                pools("inside")
                helper("inside")
                forks("inside", lambda: sys.exit(7), lambda: os._exit(5), world.step, lambda: 1 / 0)
            world.step()
    if "behind" in wanted:
        pools("behind")
        helper("behind", "from mpi4py import MPI\n")
        forks("behind", lambda: sys.exit(7), lambda: os._exit(5), lambda: run_a_world(f"fork.{rank}"))
    print("end", system.count, flush=True)
