"""Ties, followers, pairs and far cells; prints one line per frame and variant of the domains.

Argument: a JSON list of variants: keyword arguments of World, and `threads`.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np

import motes
from motes import shapes

FRAMES = 5


def repel(pairs: Any) -> np.ndarray:
    """Push a particle away from the other one of its pair."""
    apart = pairs.position - pairs.other_position
    return np.float32(0.02) * apart - np.float32(0.05) * (pairs.velocity - pairs.other_velocity)


def play(number: int, variant: dict[str, Any]) -> None:
    """Run the scene, and print the digest of each frame."""
    given = {"space": (-1.2, 1.2), **variant}
    world = motes.World(seed=4, dt=1 / 24, substeps=3, progress="off", **given)
    sheet, rope, stars, birds = (world.system(name) for name in ("sheet", "rope", "stars", "birds"))
    with world:
        cloth = sheet.cloth(14, 18, (-0.9, 0.6, -0.7), (1.8, 0, 0.3), (0, 0, 1.4), pinned=[(0, 0), (-1, 3)])
        line = rope.rope((-1.1, 1, 0), (1.1, 1, 0), 40, pinned=[0])
        stars.configure(velocity=shapes.Sphere((0, 0, 0), 0.3))
        stars.burst(shapes.Sphere((0, 0, 0), 1), 700)
        birds.configure(velocity=shapes.Sphere((0, 0, 0), 1))
        for frame in range(FRAMES):
            birds.source(shapes.Box((-1, -0.5, -1), (1, 0.5, 1)), rate=24 * 60)
            sheet.gravity((0, -9.81, 0))
            sheet.tie(cloth, break_at=1.15, damping=0.5)
            sheet.bounce(shapes.Sphere((0.1, 0.1, 0), 0.4), restitution=0, friction=0.4)
            sheet.kill_old(0.13, where=shapes.Box((0.6, -2, -2), (2, 2, 2)))
            sheet.move()
            rope.gravity((3, -9.81, 1))
            rope.tie(line, bend=0)
            rope.move()
            stars.gravitate(magnitude=2e-4, epsilon=1e-3, far="cells" if frame % 2 == 0 else "exact")
            stars.move()
            birds.follow(magnitude=0.3, epsilon=0.2)
            birds.pairs(repel, 0.25, where=shapes.Box((-2, -2, -2), (2, 2, 0.5)))
            birds.kill_old(0.12)
            birds.move()
            world.step()
            digest = world.digest()
            if world.rank == 0:
                counts = ",".join(str(system.count) for system in (sheet, rope, stars, birds))
                print(number, frame, digest, counts, flush=True)
        if "log" not in variant and number == 0:
            after = sheet.gather()
            if world.rank == 0:
                print("torn", np.count_nonzero(after.torn), np.nanmax(np.abs(after.velocity)), flush=True)


for at, chosen in enumerate(json.loads(sys.argv[1])):
    play(at, chosen)
