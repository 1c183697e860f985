"""Grains whose neighbour lists, and so ghosts, are kept for many sub-steps: the same bits on any ranks."""

from __future__ import annotations

import pytest
from standing import alike

BED = """
import numpy as np
import motes
from motes import column

axes, other = {0!r}, {1!r}
rng = np.random.default_rng(5)
places = np.stack(np.meshgrid(*[np.arange(7)] * 3, indexing="ij"), -1).reshape(-1, 3) * 0.1 - 0.3
box = motes.shapes.Box((-0.4, -0.4, -0.4), (0.4, 0.6, 0.4))
with motes.World(
    seed=1, dt=0.02, substeps=30, progress="off", roles="shared", space=(-0.4, 0.4),
    balancer=motes.balance.PrefixCuts(),
) as world:
    grains = world.system("grains", axis=axes)
    grains.emit(
        position=places + rng.uniform(-0.01, 0.01, places.shape),
        velocity=rng.uniform(-0.5, 0.5, places.shape),
        size=np.repeat(rng.uniform(0.05, 0.12, (len(places), 1)), 3, axis=1),
        mass=rng.uniform(0.5, 2, len(places)),
    )
    for frame in world.frames(6):
        grains.gravity((0.0, -9.81, 0.0))
        grains.contact(2000, friction=0.6, rolling_friction=0.05)
        grains.bounce(box, restitution=0.2)
        if frame == 3:
            grains.set(velocity=column("velocity") * 3)
        if frame == 4:
            grains.configure(size=0.05)
            grains.source(motes.shapes.Box((-0.3, 0.4, -0.3), (0.3, 0.5, 0.3)), 1000)
            grains.sink(motes.shapes.Box((-0.4, -0.4, -0.4), (-0.3, 0.6, 0.4)))
        if other:
            grains.collide(radius=0.02)
        grains.move()
        world.step()
        digest = world.digest()
        if "manager" in world.role:
            print(digest, flush=True)
"""


@pytest.mark.parametrize("axes", ["x", "xy"])
def test_grains_that_cross_borders_while_lists_are_kept(axes: str):
    assert len(set(alike(BED.format(axes, False), ranks=(1, 2, 3, 5)))) == 6


@pytest.mark.slow
def test_lists_beside_an_interaction_that_moves_particles_to_their_owners():
    assert len(set(alike(BED.format("xyz", True), ranks=(1, 3, 5)))) == 6
