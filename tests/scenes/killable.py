"""Clumps, a film, pictures, exports and checkpoints, on ranks that die: `killable.py OUT MODE`.

MODE: "restart", "survive", or "survive,export". KILLS in the environment, as JSON: [rank, place, number, ms]
each. Places: "start", ms after the script's first line; "frame", ms after frame `number` begins; "name",
before or behind the `number`-th time that this rank gives a complete file its name (ms: 0 or 1).
"""

import json
import os
import signal
import sys
import threading
import time

FIRST = time.monotonic()
me = int(os.environ.get("OMPI_COMM_WORLD_RANK", "0"))
kills = [kill[1:] for kill in json.loads(os.environ.get("KILLS", "[]")) if kill[0] == me]


def die(at_s: float) -> None:
    """Kill this process at this time."""
    time.sleep(max(0.0, at_s - time.monotonic()))
    os.kill(os.getpid(), signal.SIGKILL)


def dies_after(ms: float, *, since: float) -> None:
    """Kill this process some time after a moment."""
    threading.Thread(target=die, args=(since + ms / 1000,), daemon=True).start()


names, replace = [0], os.replace


def replaced(source: str, target: str) -> None:
    """Give a file its name, and die."""
    names[0] += 1
    if ["name", names[0], 0] in kills:
        die(0)
    replace(source, target)
    if ["name", names[0], 1] in kills:
        die(0)


os.replace = replaced  # type: ignore[assignment]
for place, _, ms in kills:
    if place == "start":
        dies_after(ms, since=FIRST)

import motes  # noqa: E402
from motes.shapes import Box, Plane, Sphere  # noqa: E402

FRAMES = 26
out, mode = sys.argv[1:3]
camera = motes.Camera((0, 0, 4), (0, 0, 0))
world = motes.World(
    seed=5,
    space=(-1, 1),
    substeps=3,
    on_loss="recover" if "survive" in mode else "stop",
    checkpoint=motes.Checkpoint(f"{out}/checkpoints", every=4),
    balancer=motes.balance.PrefixCuts(0.01, min_particles=1),
    log=f"{out}/log",
    digest=True,
    progress="off",
    renderer=motes.Renderer(64, 48, camera=camera, shutter=0.5),
)
grains = world.system("grains", sprite=motes.Sprite("sphere", pixels=None, blend="opaque"))
dust = world.system("dust", attributes={"heat": 0.0})
grains.clumps([(-0.1, 0, 0, 0.08), (0.1, 0, 0, 0.08), (0, 0.15, 0, 0.05)], density=500)
exports = [] if mode == "survive" else [motes.Export(f"{out}/all"), motes.Export(f"{out}/some.pvd", every=4)]
film = motes.Movie(f"{out}/film.mp4", fps=4)
with world:
    for frame in world.frames(FRAMES):
        began = time.monotonic()
        for place, number, ms in kills:
            if (place, number) == ("frame", frame):
                dies_after(ms, since=began)
        camera.position = (0.05 * frame, 0, 4)
        if frame == 0:
            grains.burst(Box((-1, -0.6, 0), (1, 0.6, 0)), 12)
        if frame == 5:
            dust.sprite = motes.Sprite("disc", pixels=9, blend="alpha")
        if frame == 9:
            dust.configure(color=(1, 0.5, 0.1), heat=motes.Uniform(0, 2))
        grains.contact(100, walls=[Plane((0, -1, 0), (0, 1, 0))])
        grains.move()
        dust.configure(velocity=Sphere((0, 0, 0), 2))
        dust.source(Box((-1, -1, -1), (1, 1, 1)), rate=2400)
        dust.kill_old(0.3)
        dust.move()
        picture = world.render()
        film.write(picture)
        picture.save(f"{out}/{frame:04}.png")
        for export in exports:
            export.write(world)
    film.close()
