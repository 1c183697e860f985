"""A run for `motes.launch`. Arguments: a kind; a folder, in which it reports that it has ended."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import motes
from motes.shapes import Box

kind, folder = sys.argv[1], Path(sys.argv[2])
if kind == "early":
    sys.exit("there is no scene")
camera = motes.Camera((0, 2, 9), (0, 2, 0))
renderer = motes.Renderer(160, 90, camera=camera)
world = motes.World(seed=1, space=(-4, 4), renderer=renderer, progress="off")
snow = world.system("snow")
wind = world.control("wind", 0.0, low=-5, high=5)
with world:
    world.say(f"begins: {kind}")
    for frame in world.frames(100_000):
        snow.burst(Box((-4, 3, -2), (4, 4, 2)), count=50)
        snow.gravity((wind.value, -2, 0))
        snow.kill_old(1)
        snow.move()
        world.render()
        time.sleep(60 if kind == "stuck" and frame == 3 else 0.005)
        if kind == "fails" and frame == 5 and world.rank == 1:
            raise ValueError("too windy")
(folder / f"ended-{world.rank}").write_text(str(world.frame))
