"""A scene of grains and clumps and laws of the script's own, whose lists are kept with any skin."""

from __future__ import annotations

__all__ = ["SCENE"]

# Arguments: whether the first system has clumps, or the second (1 or 0), particles per system, folder of
# checkpoints. KILL: the frame to die in.
SCENE = """
import os, sys
import numpy as np
import motes
from motes import expressions as ex
from motes.shapes import Plane

clumps, count, folder = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
dice = np.random.default_rng(4)
wide = 0.1 * (count ** (1 / 3))
world = motes.World(
    seed=1, dt=0.02, substeps=12, progress="off", roles="shared", space=(0, wide), periodic={"x": (0, wide)},
    balancer=motes.balance.PrefixCuts(), checkpoint=motes.Checkpoint(folder, every=2),
)
grains, stones = world.system("grains", axis="x"), world.system("stones", axis="yz")
seen = world.system("seen", axis="xz")
(grains if clumps else stones).clumps([(0, 0, 0, 0.03), (0.03, 0, 0, 0.03)], density=1000)
law = 30 * (0.12 - ex.r) * ex.normal - ex.a.state.way
with world:
    for frame in world.frames(6):
        if frame == int(os.environ.get("KILL", -1)):
            os._exit(9)
        if frame == 0:
            place, speed = dice.uniform(0, wide, (count, 3)), dice.uniform(-1, 1, (count, 3))
            size = np.ones((count, 1)) if clumps else dice.uniform(0.05, 0.09, (count, 1))
            grains.emit(position=place, velocity=speed, size=size * (1, 1, 1))
            place, speed = dice.uniform(0, wide, (count // 2, 3)), dice.uniform(-1, 1, (count // 2, 3))
            stones.emit(position=place, velocity=speed, size=np.full(place.shape, 0.08 if clumps else 1))
            seen.emit(position=dice.uniform(0, wide, (count, 3)), velocity=dice.uniform(-1, 1, (count, 3)))
        grains.gravity((0, -9.81, 0))
        floor = Plane((0, 0, 0), (0, 1, 0))
        grains.contact(300, friction=0.6, rolling_friction=0.05, walls=[floor])
        grains.contact(200, friction=0.4, rolling_friction=0.1, other=stones)
        stones.contact(300, friction=0.6, walls=[(floor, motes.Wall(friction=0.2))])
        remembered = {"way": ex.normal + 0.5 * ex.a.state.way}
        seen.interact(0.12, acceleration=law, set=remembered, state={"way": 3})
        seen.interact(0.1, acceleration=law, set=remembered, state={"way": 3}, other=grains)
        for system in world.systems:
            system.move()
        world.step()
        digest = world.digest()
        if "manager" in world.role:
            print("digest", frame, digest, *(one.tolist() for one in world.force(floor)), flush=True)
    touching = [s.total(ex.column("contacts")) > count / 2 for s in (grains, stones)]
    if "manager" in world.role:
        print("digest touching", all(touching))
"""
