"""Measure the exchange of shadows for docs/lab/speed_of_pictures.md: lit smoke on a virtual cluster.

`python docs/lab/scripts/make_shadow_table.py [RANKS ...]`; has the requirements of `python -m motes cluster`.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from motes_lab.cluster import Cluster, Node, simulate
from motes_lab.cluster.growth import network
from motes_lab.cluster.simulate import record

SCENE = """
import motes

camera = motes.Camera((0, 2, 9), (0, 1.5, 0))
world = motes.World(seed=1, space=(-4, 4), progress="off", renderer=motes.Renderer(1920, 1080, camera=camera))
puff = motes.Sprite(pixels=None, blend="alpha", softness=0.3, lit=True, shadow=0.5)
smoke = world.system("smoke", sprite=puff)
with world:
    smoke.burst(motes.shapes.Box((-4, 0, -2), (4, 4, 2)), count=20_000)
    for _ in world.frames(4):
        smoke.move()
        world.render()
"""


def recorded(folder: Path) -> Path:
    """Record the scene in `folder`, and write costs beside it: work on particles is free."""
    script, scene = folder / "smoke.py", folder / "smoke.motes"
    script.write_text(SCENE)
    (folder / "no.costs").write_text("")
    record(scene, script)
    return scene


def exchange_ms(ranks: int, scene: Path) -> float:
    """Return the slowest calculator's time for the exchange in a frame, ms."""
    folder = scene.parent
    run = simulate(
        scene,
        Cluster([Node("node", count=ranks)], network()),
        log=folder / f"log{ranks}",
        costs=folder / "no.costs",
        options=["--roles", "shared", "--spans"],
    )
    spans = run.spans
    spans = spans[(spans["phase"] == "shadows") & (spans["frame"] == spans["frame"].max())]
    assert len(spans) == ranks, spans
    return 1e3 * float((spans["end_s"] - spans["start_s"]).max())


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        scene = recorded(Path(place))
        for ranks in map(int, sys.argv[1:] or (2, 8, 64)):
            print(f"{ranks} calculators: {exchange_ms(ranks, scene):.2f} ms", flush=True)
