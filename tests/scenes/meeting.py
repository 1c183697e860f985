"""Interactions in one small scene; prints digests under variants of roles, domains and balancers.

Arguments: a JSON list of variants, each some of {"roles", "space", "axis", "balancer", "births", "combine",
"together"}. One line per frame: variant, frame, digest of the particles, numbers of particles.
"""

from __future__ import annotations

import json
import sys
from typing import Any

from mpi4py import MPI

import motes
from motes import expressions as ex
from motes import shapes
from motes.expressions import column

FRAMES = 8
HERE = (0.25, 0.5, 0.0)


def grains(s: motes.System, pebbles: motes.System, sparks: motes.System, frame: int) -> None:
    """Use collisions within and between systems, births at cuts and at one place, children, jumps, NaN."""
    s.configure(velocity=shapes.Sphere((0, -3, 0), 4), size=motes.Uniform(0.1, 0.3), mass=motes.Uniform(1, 3))
    s.source(shapes.Box((-3, 0.1, -1), (2, 1, 1)), rate=1500, jitter=True)
    s.spawn(into=sparks, on="collision", count=2)
    s.gravity((0, -9.8, 0))
    s.collide(restitution=0.3)
    for x in (-1.0, 0.0, 0.5, 1.0, 2.0):
        s.burst((x, 0.5, 0.0))
    s.emit(position=[HERE] * 5, velocity=[(0, 0, 0)] * 5)
    s.bounce(shapes.Plane((0, 0, 0), (0, 1, 0)), restitution=0.5)
    far = column("position") * (-2.0, 1.0, -3.0)
    s.set(position=far, where=column("position").x > 1.9 + 0.01 * frame)
    if frame == 3:
        s.set(position=column("position") / 0 * 0, where=column("age") == 0)
    older = {"crowd": ex.b.mass * ex.a.state.n, "n": ex.a.state.n + 1}
    s.interact(0.3, spin=ex.normal, set=older, state={"n": 1})
    s.interact(
        0.25,
        acceleration=ex.normal * (ex.r - 0.3) * 20 + ex.a.state.slip,
        set={"slip": ex.a.state.slip - ex.relative_velocity * ex.b.heat, "crowd": ex.b.heat},
        state={"more": 3, "still": 3, "slip": 3},
        other=pebbles,
        where=ex.a.age > 0.02,
    )
    s.collide(radius=0.08, other=pebbles, other_radius=0.3, where=column("velocity").y < 0)
    s.kill_old(0.2)
    s.match_velocity(magnitude=0.01, epsilon=0.01, max_radius=0.4, where=shapes.Sphere((0, 0, 0), 1))
    s.move()


def stones(s: motes.System, sparks: motes.System) -> None:
    """Use the other system: born after the interaction, with children at birth and death."""
    s.configure(velocity=shapes.Sphere((0, -1, 0), 5), rotational_velocity=shapes.Sphere((0, 0, 0), 3))
    s.source(shapes.Box((-3, 0.2, -1), (3, 1.5, 1)), rate=500, jitter=True)
    s.spawn(into=sparks, on="birth", count=1)
    s.spawn(into=sparks, on="death", count=1, inherit_velocity=0.5)
    s.collide(radius=0.3, friction=0.1, sleep=0.5)
    s.interact(
        0.4,
        velocity=ex.normal * ex.a.state.n * -0.01,
        set={"n": ex.a.state.n + ex.where(ex.r > 0.1, 1, 2)},
        state={"n": 1},
    )
    s.law(acceleration=ex.a.velocity * -0.2, set={"heat": ex.a.heat + ex.a.age})
    s.contact(
        stiffness=200, friction=0.7, rolling_friction=0.2, radius=0.2, where=column("position").z > -0.8
    )
    s.bounce(shapes.Plane((0, 0, 0), (0, 1, 0)))
    s.match_rotational_velocity(magnitude=0.02, max_radius=0.5)
    s.kill_old(0.3)
    s.move()


def glow(s: motes.System, frame: int) -> None:
    """Use gravity with several radii or none, and a fluid."""
    s.gravitate(0.02, 1e-2, **({} if frame % 3 == 0 else {"max_radius": 0.4 * frame}))
    s.fluid(radius=0.3, rest_density=20, viscosity=0.01, cohesion=0.5, where=column("velocity").x > -2)
    s.move()
    s.kill_old(0.15)


def balancer_of(name: str) -> Any:
    """Make a balancer that moves cuts as often as possible."""
    if name == "Static":
        return motes.balance.Static()
    if name == "Proportional":
        calculators = MPI.COMM_WORLD.size
        return motes.balance.Proportional([1 + k % 3 for k in range(calculators)])
    if name == "Alone":
        return motes.balance.Diffusive(threshold=0.001, min_particles=1, manager=False)
    return getattr(motes.balance, name)(threshold=0.001, min_particles=1)


def run(number: int, variant: dict[str, Any]) -> None:
    """Run all systems under one variant."""
    space, roles = variant.get("space"), variant.get("roles", "auto")
    world = motes.World(
        seed=7,
        substeps=2,
        axis=variant.get("axis", "x"),
        space=tuple(space) if isinstance(space, list) else space,
        roles=roles
        if isinstance(roles, str)
        else motes.Roles(manager=roles[0], image_generator=roles[1], calculators=roles[2]),
        births=variant.get("births", "manager"),
        combine=variant.get("combine", "together"),
        balancer=balancer_of(variant["balancer"]) if "balancer" in variant else None,
        progress="off",
    )
    first = world.system("grains", attributes={"crowd": 0})
    shared = {"domains_of": first} if variant.get("together") else {}
    second = world.system("pebbles", attributes={"heat": 0}, **shared)
    third = world.system("sparks", capacity=400)
    with world:
        for frame in world.frames(FRAMES):
            grains(first, second, third, frame)
            stones(second, third)
            glow(third, frame)
            world.step()
            digest = world.digest()
            if "manager" in world.role:
                print(number, frame, digest, *(s.count for s in (first, second, third)), flush=True)


for i, chosen in enumerate(json.loads(sys.argv[1])):
    run(i, chosen)
