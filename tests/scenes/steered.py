"""A run that viewers steer, or its replay. Arguments: folder, frames, arguments of World as Python."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import motes
from motes.shapes import Box, Plane

folder, frames = Path(sys.argv[1]), int(sys.argv[2])
options = eval(sys.argv[3]) if len(sys.argv) > 3 else {}
pause_s = options.pop("pause_s", 0.0)
shutter = options.pop("shutter", 0.5)
own_loop = options.pop("own_loop", False)
balance = (
    {"balancer": motes.balance.Pairwise(threshold=0.02, min_particles=1)}
    if options.pop("moves", True)
    else {}
)

renderer = motes.Renderer(160, 96, camera=motes.Camera((0, 2, 12), (0, 2, 0)), shutter=shutter)
world = motes.World(
    **{"seed": 3, "space": (-4, 4), "renderer": renderer, "digest": True, "progress": "off"}
    | {"log": folder / "log"} | balance | options
)  # fmt: skip
wind = world.control("wind", 0.0, low=-5, high=5, step=0.1)
dense = world.control("dense", 20, low=10, high=60, step=10)
still = world.control("still", False)
shape = world.control("shape", "wide", choices=("wide", "narrow"))
snow = world.system("snow")
glow = world.system("glow", capacity=500)

with world:
    if world.live_url is not None:
        draft = folder / "url.part"
        draft.write_text(world.live_url)
        draft.rename(folder / "url")

    def record(frame: int) -> None:
        """Record one frame."""
        if not still.value:
            half = 4 if shape.value == "wide" else 1
            snow.burst(Box((-half, 4, -1), (half, 5, 1)), count=dense.value)
        glow.source(Box((-1, 0, 0), (1, 1, 1)), rate=120)
        for system in (snow, glow):
            system.gravity((wind.value, -2, 0))
            system.bounce(Plane((0, 0, 0), (0, 1, 0)), restitution=0.5)
            system.kill_old(2)
            system.move()
        renderer.camera.position = (0.01 * frame, 2, 12)  # a viewer's camera takes precedence
        time.sleep(pause_s)

    if own_loop:
        while world.frame < frames:
            record(world.frame)
            world.render()
    for frame in world.frames(frames):
        record(frame)
        world.render()
print(f"rank {world.rank} ended", flush=True)
