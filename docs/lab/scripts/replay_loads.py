"""A load for make_replay_table.py: its arguments are step, wave, drift or jet, and perhaps pictures."""

from __future__ import annotations

import sys
from typing import Any

import motes
from motes.shapes import Box
from motes_lab.workloads import workload

FRAMES = 50
NAME = sys.argv[1]


def picture() -> dict[str, Any]:
    """Return the argument of World that makes pictures, if they are asked for."""
    if "pictures" not in sys.argv[2:]:
        return {}
    return {"renderer": motes.Renderer(320, 240, camera=motes.Camera((0, 0, 30), (0, 0, 0)))}


def end(world: motes.World) -> None:
    """End the frame."""
    if picture():
        world.render()
    else:
        world.step()


def play(name: str) -> None:
    """Run one of the arena's workloads."""
    game = workload(name, frames=FRAMES, cells=400, particles=12_000)
    world = motes.World(**game.world, **picture(), progress="off")
    system = world.system("particles")
    with world:
        for frame in world.frames(FRAMES):
            game.step(system, frame)
            for _ in range(4):
                system.gravity((0, 0, 0))  # no effect but work
            end(world)


def stream(speed: float, life: float) -> None:
    """Emit particles on the left that drift and die."""
    world = motes.World(seed=3, space=(-10, 10), **picture(), progress="off")
    system = world.system("particles")
    system.configure(velocity=motes.Normal((speed, 0, 0), (1.0, 1.0, 0)), lifetime=life)
    with world:
        for _ in world.frames(FRAMES):
            system.source(Box((-9, -1, -1), (-5, 1, 1)), rate=9000)
            system.gravity((0.5, 0, 0))
            system.kill_expired()
            system.move()
            end(world)


if NAME == "drift":
    stream(4.0, 60.0)
elif NAME == "jet":
    stream(12.0, 0.8)
else:
    play(NAME)
