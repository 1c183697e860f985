"""Sparks that bounce, on ranks that kill themselves: `recovering.py OUT FRAMES [RANK@FRAME[.SECONDS] ...]`.

Options add features: `--callback`, `--write`, `--export`, `--checkpoint`. `--once`: no rank is killed
after a restart. `--closing`: rank 0 is killed while it closes the film. `--crashing`: all ranks crash
during recovery, as Open MPI does when another rank is lost meanwhile.
"""

import os
import signal
import sys
import threading
import time

from mpi4py import MPI

import motes
from motes._film.growing import GrowingFilm
from motes._world import recovering
from motes.shapes import Disc, Plane, Sphere

out, frames = sys.argv[1], int(sys.argv[2])
options = {argument for argument in sys.argv[3:] if argument.startswith("--")}
deaths: dict[int, list[tuple[int, float]]] = {}
for argument in sys.argv[3:]:
    if argument not in options:
        rank, _, moment = argument.partition("@")
        frame, _, milliseconds = moment.partition(".")
        deaths.setdefault(int(rank), []).append((int(frame), int(milliseconds or 0) / 1000))


def die(after_s: float) -> None:
    """Kill this process, now or a little later."""
    time.sleep(after_s)
    os.kill(os.getpid(), signal.SIGKILL)


ground, ball = Plane((0, 0, 0), (0, 1, 0)), Sphere((1, 0.5, 0), 0.5)
camera = motes.Camera((0, 2, 9), (0, 1.5, 0))
world = motes.World(
    seed=7,
    space=(-3, 3),
    on_loss="recover",
    balancer=motes.balance.Pairwise(),
    log=f"{out}/log",
    digest=True,
    progress="off",
    checkpoint=motes.Checkpoint(f"{out}/checkpoints", every=8) if "--checkpoint" in options else None,
    renderer=motes.Renderer(
        *(96, 64),
        camera=camera,
        shutter=0.5,
        objects=[motes.Solid(ground, (0.05, 0.06, 0.08))],
        linear=True,
    ),
)
sparks = world.system("sparks", capacity=20_000, sprite=motes.Sprite("disc", pixels=3))
sparks.configure(velocity=Sphere((0, 6, 0), 1.5), color=(1, 0.5, 0.15), alpha=0.3)
export = motes.Export(f"{out}/points") if "--export" in options else None
own = deaths.get(MPI.COMM_WORLD.rank, [])
again = "--once" in options and os.path.exists(f"{out}/checkpoints")
if again:
    own = []

if "--crashing" in options and not again:
    recovering.Recovery.regroup = lambda recovery, loss: os.kill(os.getpid(), signal.SIGSEGV)
if "--closing" in options and MPI.COMM_WORLD.rank == 0:
    GrowingFilm.finish = lambda film: die(0)

with world, motes.Movie(f"{out}/film.mp4") as movie:
    for frame in world.frames(frames):
        for _, after_s in [death for death in own if death[0] == frame]:
            threading.Thread(target=die, args=(after_s,), daemon=True).start()
        camera.position = (0.02 * frame, 2, 9)
        world.renderer.exposure = 1 + 0.25 * (frame % 3)  # a repeated frame gets its old exposure
        world.renderer.layers = ("depth",) if frame % 2 else ()
        sparks.source(Disc((0, 0, 0), (0, 1, 0), 0.2), rate=2000)
        sparks.gravity((0, -9.81, 0))
        sparks.bounce([ground, ball], restitution=0.5, friction=0.1, hits=True)
        sparks.rest(0.3)
        if "--callback" in options:
            sparks.callback(lambda particles: None)
        if "--write" in options:
            with sparks.local() as particles:
                particles.velocity[:] *= 0.99
        sparks.kill_old(1)
        sparks.move()
        picture = world.render()
        movie.write(picture)
        picture.save(f"{out}/{frame:04}.png", bits=8 if frame % 5 else 16)
        if export is not None:
            export.write(world)
    world.say(f"{world.digest()} on {world.size}")
