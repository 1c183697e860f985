"""Particles in periodic space in one small scene; prints digests under variants of domains and balancers.

Arguments: a JSON list of variants, each some of {"axis", "space", "balancer", "checkpoint", "dies"}.
One line per frame: variant, frame, digest of the particles, numbers of particles.
"""

from __future__ import annotations

import json
import os
import sys
from typing import Any

import numpy as np

import motes
from motes import expressions as ex
from motes import shapes
from motes.expressions import column

FRAMES = 10
PERIODIC = {"x": (-1, 3), "z": (0, 2)}


def grains(s: motes.System, sparks: motes.System, frame: int) -> None:
    """Simulate a tilting chute: births across a periodic boundary, contacts with memory, children."""
    s.configure(
        velocity=shapes.Sphere((6, -1, 3), 2), size=motes.Uniform(0.15, 0.3), mass=motes.Uniform(1, 2)
    )
    if frame < 4:
        s.source(shapes.Box((2.4, 0.1, 1.5), (3.6, 1.2, 2.5)), rate=900, jitter=True)
    s.spawn(into=sparks, on="collision", count=1, inherit_velocity=0.5)
    s.gravity((4, -9.8, 2))
    s.contact(stiffness=2000, friction=0.6, rolling_friction=0.1)
    s.bounce(shapes.Plane((0, 0, 0), (0, 1, 0)), restitution=0.3)
    s.move()


def gas(s: motes.System, stones: motes.System, frame: int) -> None:
    """Simulate spheres with collisions within and between systems, jumps set by the script, pair forces."""
    s.configure(velocity=shapes.Sphere((0, 0, 0), 9), rotational_velocity=shapes.Sphere((0, 0, 0), 3))
    if frame == 0:
        s.burst(shapes.Box((-4, 0, -3), (6, 1, 5)), count=250)
    s.callback(push, where=column("velocity").x > 5)
    s.collide(radius=0.09, restitution=0.8)
    s.collide(radius=0.1, other=stones, other_radius=0.2, where=column("position").y < 0.8)
    s.pairs(repel, 0.25)
    touched = {"times": ex.a.state.times + 1}
    s.interact(0.3, velocity=ex.normal * (ex.a.state.times - 2) / 50, state={"times": 1}, set=touched)
    s.follow(0.1, 0.1)
    s.curl_noise(30, scale=0.7, octaves=2, speed=3)
    s.move()
    s.set(position=column("position") + (2.5, 0, -7), where=column("position").y > 1.5)
    if frame == 5:
        s.set(position=column("position") / 0, where=column("velocity").z > 8)


def liquid(s: motes.System, frame: int) -> None:
    """Simulate a fluid that falls through a corner of space."""
    s.configure(velocity=(-3, 0, -2))
    if frame == 0:
        s.burst(shapes.Box((-1.4, 0, -0.4), (-0.6, 0.6, 0.4)), count=300)
    s.fluid(radius=0.25, rest_density=1000, viscosity=0.01)
    s.match_velocity(magnitude=0.01, epsilon=0.01, max_radius=0.3, where=column("position").y < 0.4)
    s.gravitate(0.01, 0.01, max_radius=1)
    s.move()


PLACES = np.stack(np.meshgrid(np.arange(9), np.arange(12), indexing="ij"), -1).reshape(-1, 2)
STEPS = np.abs(PLACES[:, None] - PLACES).sum(-1)
TIES = motes.Ties(np.argwhere(np.triu(STEPS == 1)), 0.1, pinned=[0, 107])


def flag(s: motes.System, frame: int) -> None:
    """Simulate a net born across a corner: it hangs from pins, crosses the boundaries, and tears."""
    if frame == 0:
        s.emit(position=np.insert(0.1 * PLACES, 1, 0, axis=1) + (2.6, 0.8, 1.7))
    s.gravity((9, -9.8, -6))
    s.tie(TIES, break_at=1.2, damping=0.5)
    s.move()
    s.kill_old(0.25, where=shapes.Box((-1, -9, 0), (-0.7, 9, 2)))


def push(p: motes.LocalParticles) -> None:
    """Throw some particles far beyond the boundaries."""
    p.position[p.id % 7 == 0] += np.float32(11.5)


def repel(p: Any) -> Any:
    """Repel near particles, also across the boundaries."""
    return np.float32(0.125) * (p.position - p.other_position)


def run(number: int, variant: dict[str, Any]) -> None:
    """Run all systems under one variant."""
    balancer = variant.get("balancer")
    world = motes.World(
        seed=5,
        substeps=3,
        axis=variant.get("axis", "x"),
        space=variant.get("space"),
        periodic=PERIODIC,
        roles="shared",
        balancer=getattr(motes.balance, balancer)(threshold=0.001, min_particles=1) if balancer else None,
        checkpoint=motes.Checkpoint(variant["checkpoint"], every=2) if "checkpoint" in variant else None,
        progress="off",
    )
    first, second, third = (world.system(name) for name in ("grains", "gas", "liquid"))
    sparks, sheet = world.system("sparks", capacity=300), world.system("sheet")
    with world:
        for frame in world.frames(FRAMES):
            if frame == variant.get("dies"):
                os._exit(9)
            grains(first, sparks, frame)
            gas(second, first, frame)
            liquid(third, frame)
            sparks.move()
            flag(sheet, frame)
            world.step()
            with sparks.local() as p:
                p.position[p.id % 5 == 0] += np.float32(3.25)
            digest = world.digest()
            if "manager" in world.role:
                print(number, frame, digest, *(s.count for s in world.systems), flush=True)


for i, chosen in enumerate(json.loads(sys.argv[1])):
    run(i, chosen)
