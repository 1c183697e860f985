"""Particles in a given state, and the effects of actions on them."""

from __future__ import annotations

from typing import Any

import numpy as np

import motes
from motes import actions, shapes

__all__ = ["SOLIDS", "after", "born", "cloud", "length"]

SOLIDS = {
    "Plane": shapes.Plane((0, 0, 0), (0, 1, 0)),
    "Rectangle": shapes.Rectangle((-2, 0, -2), (4, 0, 0), (0, 0, 4)),
    "Triangle": shapes.Triangle((-2, 0, -2), (2, 0, -2), (0, 0, 3)),
    "Disc": shapes.Disc((0, 0, 0), (0, 1, 0), 2),
    "Sphere": shapes.Sphere((0, 0, 0), 1.5),
    "Box": shapes.Box((-1, -1, -1), (1, 1, 1)),
    "Cylinder": shapes.Cylinder((0, 0, -2), (0, 0, 2), 1.2),
    "Cone": shapes.Cone((0, 2, 0), (0, -1, 0), 1.5),
    "Union": shapes.Sphere((0, 0, 0), 1) | shapes.Box((0, -1, -1), (2, 1, 1)),
}


def born(where: shapes.Shape, count: int = 2000, **state: Any) -> motes.Particles:
    """Emit particles from a shape, and return them."""
    world = motes.World(seed=4, progress="off")
    system = world.system("all")
    with world:
        system.configure(**state)
        system.burst(where, count=count)
        world.step()
        return system.gather()


def after(
    state: dict[str, Any], *recorded: actions.Action, dt: float = 0.1, frames: int = 1, substeps: int = 1
) -> motes.Particles:
    """Give particles a state, run actions on them for some frames, and return them."""
    world = motes.World(seed=3, dt=dt, substeps=substeps, progress="off")
    system = world.system("all")
    with world:
        for frame in world.frames(frames):
            if frame == 0:
                system.emit(**state)
            system.apply(list(recorded))
            world.step()
        return system.gather()


def cloud(n: int, scale: float = 3, seed: int = 0) -> dict[str, np.ndarray]:
    """Make positions and velocities."""
    dice = np.random.default_rng(seed)
    return {"position": dice.normal(0, scale, (n, 3)), "velocity": dice.normal(0, scale, (n, 3))}


def length(vectors: np.ndarray) -> np.ndarray:
    return np.linalg.norm(vectors.astype(np.float64), axis=1)
