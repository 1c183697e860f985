"""Two worlds, one after the other, on ranks that kill themselves: `losing.py OUT PLAN`, a plan as JSON.

"worlds", "frames": how many. "checkpoint": one after this many frames; 0: none. "film": closed "inside" the
world's block, or "forgotten", which ends with the script. "export": the last world's particles go to files.
"live": viewers are served. "deaths": [rank, world, place, count, ms]: in this world, this rank (of all) is
killed ms milliseconds after it reaches the place for the count-th time. A place is one of `PLACES`, prefixed
with "before " or "behind ".
"""

import functools
import importlib
import json
import os
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any

from losing_places import PLACES
from mpi4py import MPI

import motes
from motes.shapes import Plane, Sphere

out, plan = Path(sys.argv[1]), json.loads(sys.argv[2])
me = MPI.COMM_WORLD.rank
now = 0  # index of the world
seen: dict[str, int] = {}


def die(after_s: float) -> None:
    """Kill this process."""
    time.sleep(after_s)
    os.kill(os.getpid(), signal.SIGKILL)


def come_to(place: str) -> None:
    """Count this rank's visits to a place in this world, and kill the rank if the plan says so."""
    seen[place] = seen.get(place, 0) + 1
    for rank, world, where, count, ms in plan["deaths"]:
        if (rank, world, where, count) == (me, now, place, seen[place]):
            if ms == 0:
                die(0)
            threading.Thread(target=die, args=(ms / 1000,), daemon=True).start()


def watch(place: str, function: str) -> None:
    """Wrap a function to count where it begins and ends."""
    module, _, name = function.rpartition(".")
    try:
        owner: Any = importlib.import_module(module)
    except ImportError:
        module, _, kind = module.rpartition(".")
        owner = getattr(importlib.import_module(module), kind)
    called = getattr(owner, name)

    @functools.wraps(called)
    def counting(*args: Any, **named: Any) -> Any:
        come_to(f"before {place}")
        result = called(*args, **named)
        come_to(f"behind {place}")
        return result

    setattr(owner, name, counting)


for place in {place.partition(" ")[2] for _, _, place, *_ in plan["deaths"]}:
    if PLACES[place][0]:
        watch(place, PLACES[place][0])


def play(number: int) -> None:
    """Play one world to its end."""
    here = out / str(number)
    ground = Plane((0, 0, 0), (0, 1, 0))
    camera = motes.Camera((0, 2, 9), (0, 1.5, 0))
    world = motes.World(
        seed=7 + number,
        space=(-3, 3),
        on_loss="recover",
        balancer=motes.balance.Pairwise(),
        log=here / "log",
        digest=True,
        progress="off",
        checkpoint=motes.Checkpoint(here / "checkpoints", every=plan["checkpoint"])
        if plan["checkpoint"]
        else None,
        live=motes.Live(0) if plan["live"] else None,
        renderer=motes.Renderer(48, 32, camera=camera, shutter=0.5),
    )
    sparks = world.system("sparks", sprite=motes.Sprite("disc", pixels=2))
    sparks.configure(velocity=Sphere((0, 4, 0), 1.5), color=(1, 0.5, 0.15))
    film = motes.Movie(here / "film.mp4", fps=4)  # one segment per second of film
    exports = plan["export"] == "all" or (plan["export"] and number + 1 == plan["worlds"])
    export = motes.Export(here / "points") if exports else None
    with world:
        for frame in world.frames(plan["frames"]):
            come_to("before the frame")
            camera.position = (0.02 * frame, 2, 9)
            sparks.source(Sphere((0, 1, 0), 0.2), rate=500)
            sparks.gravity((0, -9.81, 0))
            sparks.bounce(ground, restitution=0.5)
            sparks.kill_old(0.4)
            sparks.move()
            picture = world.render()
            come_to("behind the frame")
            film.write(picture)
            picture.save(here / f"{frame:04}.png")
            if export is not None:
                export.write(world)
        if plan["film"] == "inside":
            film.close()
    assert (world.frame, world.time) == (plan["frames"], plan["frames"] * world.dt)
    world.say(f"world {number} ended on {world.size}: {sorted(world.role)} {len(world.calculators)}")
    assert 0 <= world.rank < world.size and sparks.count > 0


for now in range(plan["worlds"]):
    seen.clear()
    play(now)
