"""Every feature of the engine in one small scene; prints digests under variants of roles and space.

Arguments: a JSON list of variants, each {"roles": ..., "space": ...}; optionally the path of a shared library
to load first. One line per frame: variant, frame, digest of the particles, digest of the picture.
"""

from __future__ import annotations

import ctypes
import json
import sys
from typing import Any

if len(sys.argv) > 2:
    ctypes.CDLL(sys.argv[2])

import numpy as np

import motes
from motes import expressions as ex
from motes import shapes

FRAMES = 14
CAMERA = motes.Camera((0, 2, 9), (0, 0.5, 0))
WHIRL = np.sin(np.arange(5 * 4 * 3 * 3.0)).reshape(5, 4, 3, 3) * 3


def roles_of(wish: Any) -> Any:
    """Turn [manager, image generator, calculators] into Roles."""
    if isinstance(wish, str):
        return wish
    return motes.Roles(manager=wish[0], image_generator=wish[1], calculators=wish[2])


def space_of(wish: Any) -> Any:
    """Turn a JSON list into a pair."""
    return tuple(wish) if isinstance(wish, list) else wish


def fountain(s: motes.System, frame: int) -> None:
    """Use sources with jitter, all distributions, bounces on every surface, three ways to die."""
    s.configure(
        velocity=shapes.Sphere((0.5, 6, 0), 1.5),
        color=motes.Uniform((0.2, 0.2, 0.5), (1, 1, 1)),
        alpha=motes.Normal(0.8, 0.1),
        lifetime=motes.Uniform(0.3, 0.9),
        mass=motes.Normal(2, 0.5),
        rotational_velocity=motes.Uniform((-1, -1, -1), (1, 1, 1)),
    )
    s.source(shapes.Disc((0, 0.1, 0), (0, 1, 0), 0.5, 0.1), rate=2400.5, jitter=True)
    s.gravity((0, -9.8, 0))
    s.configure(color=(1, 0, 0), velocity=(0, 0, 0), lifetime=0.5)
    s.burst(shapes.Sphere((-1, 2, 0), 0.8, 0.4), count=37)
    s.random_acceleration(shapes.Box((-9, -9, -9), (9, 9, 9)))
    s.damping((0.5, 0.6, 0.7), min_speed=0.5, max_speed=20)
    s.bounce(shapes.Sphere((0.3, 1.0, 0), 0.4), restitution=0.7)
    s.bounce(shapes.Box((1, 0, -1), (2, 1, 1)), restitution=0.9, friction=0.1)
    s.bounce(shapes.Rectangle((-3, 0.5, -2), (1, 0.3, 0), (0, 0, 4)), restitution=0.5)
    s.bounce(shapes.Disc((0, 2, 0), (1, 1, 0), 0.6, 0.1), friction=0.3, min_tangential_speed=1)
    s.bounce(shapes.Plane((0, 0, 0), (0.1, 1, 0)), restitution=0.4, friction=0.05)
    s.move()
    s.kill_expired()
    s.sink(shapes.Box((3.5, -9, -9), (9, 9, 9)))
    if frame == 9:
        s.random_velocity(shapes.Rectangle((-1, 3, -1), (2, 0, 0), (0, 0, 2)))


def snow(s: motes.System, frame: int) -> None:
    """Use a capacity, births after the move, emitted arrays, user columns; particles that come to rest."""
    s.configure(velocity=motes.Normal((0, -2, 0), (0.5, 0.2, 0.5)), size=0.1, heat=motes.Uniform(0, 1))
    s.source(shapes.Box((-4, 3, -4), (4, 3.5, 4)), rate=3000)
    s.random_acceleration(shapes.Sphere((0, 0, 0), 3))
    s.gravity((0, -4 * ex.column("size").x, 0), where=ex.column("id") % 3 == 1)
    s.wind((motes.Curve([(0, -1), (1, 1)]), 0, 0), drag=0.2 / ex.column("size").x)
    roof = shapes.Rectangle((-3, 1.5, -2), (2, 0.5, 0), (0, 0, 4))
    s.bounce([shapes.Sphere((1, 1, 0), 0.6), roof, shapes.Plane((0, 0.2, 0), (0, 1, 0))], 0.2, 0.7, hits=True)
    s.rest(0.6, angle_deg=10)
    s.set(color=(1, 0.2, 0.2), where=(ex.column("hit") > 1) & (ex.column("hit_normal").y > 0.9))
    s.move(rotational=False)
    s.burst((0.25 * frame, 2, 0))
    rows = np.random.default_rng(frame).normal(0, 2, (frame * 3 % 7, 3)).astype(np.float32)
    s.emit(position=rows, velocity=-rows, heat=rows[:, 0], wind=rows)
    s.sink([shapes.Plane((0, 0, 0), (0, 1, 0)), shapes.Sphere((3, 2, 0), 0.3)])
    s.kill_old(0.8)


def drift(s: motes.System, frame: int) -> None:
    """Use tiny numbers, a source on a line, writes by the script, particles infinitely far away."""
    s.configure(velocity=motes.Uniform((-3e-38, 1e-38, 0), (3e-38, 2e-38, 1)), age=0.25, up=(0, 0, 1))
    s.source(shapes.Line((-2, 0, 0), (2, 2, 2)), rate=700)
    s.damping((0.1, 0.1, 0.9))
    with s.local() as p:
        # Each value depends only on its own particle and is exact in float32.
        p.position[:, 2] += np.float32(0.25) * (p.id % 8).astype(np.float32)
        p.color[p.position[:, 0] > 0] = (0, 1, 0)
        p.age[p.id % 5 == 0] += np.float32(0.5)
    s.random_velocity(shapes.Box((-1e-38, 0, 0), (1e-38, 4, 4)))
    if frame == 4:
        s.emit(position=[(1e30, 0, 0), (-1e30, 1, 0)], velocity=[(3e38, 0, 0), (-3e38, 0, 0)])
    s.move()
    s.kill_old(1.3)
    s.kill_old(-1, younger=True)


def whirl(s: motes.System, frame: int) -> None:
    """Use actions that pull, push, turn, or steer columns towards given values."""
    s.configure(
        velocity=shapes.Box((-2, -2, -2), (2, 2, 2)),
        lifetime=motes.Uniform(0.2, 2),
        mass=motes.Uniform(0.1, 3),
        rotational_velocity=motes.Uniform((-3, -3, -3), (3, 3, 3)),
        up=motes.Uniform((-1, -1, -1), (1, 1, 1)),
    )
    s.source(shapes.Sphere((0, 1, 0), 2), rate=1500)
    before, now = (shapes.Sphere((0.2 * k - 1, 1, 0), 0.1) for k in (frame, frame + 1))
    rising = motes.Curve([(0, 0), (0.3, 900)], interpolation="smooth")
    s.source(now, rate=rising, jitter=True, moving_from=before)
    s.copy_vertex_b(velocity=True, where=ex.column("age") == 0)
    s.vortex((0, 0, 0), axis=(0, 3, 1), tightness=1.7, max_radius=2, in_speed=9, up_speed=3, around_speed=8)
    s.orbit_point((0.5, 1, 0), magnitude=4, epsilon=0.1, max_radius=2.5)
    s.orbit_line((0, 1, 0), axis=(1, 1, 0), magnitude=2, epsilon=0.2)
    s.explosion((0, 1, 0), radius=0.3 * frame, magnitude=20, sigma=0.4, epsilon=0.1)
    s.jet(shapes.Cylinder((0, 0, 0), (0, 3, 0), 1), acceleration=shapes.Cone((0, 0, 0), (0, 9, 0), 4))
    s.jet(shapes.Box((-1, 0, -1), (0, 1, 0)), acceleration=(3, 0, 0))
    s.wind((1, 0, 0.5), drag=0.8)
    s.curl_noise(6, scale=0.7, octaves=3, speed=4)
    s.curl_noise(2, scale=0.2, field=1, where=shapes.Sphere((0, 1, 0), 1))
    s.field(WHIRL, (-1, 0, -1), (1, 2, 1), 2, drag=0.5)
    s.follow_path([(0, 0, 0), (1, 1, 0), (0, 2, 1)], 2, radius=0.4, smooth=True)
    steer(s)
    flicker = ex.noise(ex.column("position"), 3 * ex.time(), octaves=2)
    around = ex.cross((0, 1, 0), ex.normalize(ex.column("position")))
    s.set(velocity=ex.column("velocity") + around * np.sin(flicker), where=np.exp(flicker) > 0.9)
    s.gravity(motes.Curve([(0, (0, 0, 0)), (0.5, (0, -2, 0))]))
    s.rotational_damping((0.2, 0.5, 0.9), max_speed=4)
    s.random_rotational_velocity(shapes.Sphere((0, 0, 0), 2), where=ex.column("age") > 0.4)
    s.random_displacement(shapes.Box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)))
    s.target_velocity((0, 1, 0), scale=0.3)
    s.target_rotational_velocity((0, 5, 0), scale=0.7)
    s.target_color((1, 0.5, 0.2), alpha=0.5, scale=0.9)
    s.target_size(0.2, scale=(0.3, 0.2, 0.1))
    s.speed_clamp(0.1, max_speed=12)
    if frame == 7:
        s.restore(0.4)
    s.move()
    s.restore(0, position=False, where=ex.column("age") > 1)
    s.color_over_life(
        [(0, (1, 1, 1)), (0.3, (1, 0.6, 0.1)), (1, (0.2, 0, 0))], where=shapes.Sphere((0, 1, 0), 1)
    )
    s.alpha_over_life([(0.1, 0), (0.2, 1), (0.9, 0)])
    s.size_over_life([(0, 0.1), (1, (0.3, 0.2, 0.1))])
    s.sink_velocity(shapes.Sphere((0, 0, 0), 11.5), inside=False)
    s.kill_expired()


def steer(s: motes.System) -> None:
    """Avoid every shape, and bounce off some without an exact hit."""
    words = {"magnitude": 1.0, "epsilon": 0.2, "look_ahead": 0.4}
    corner = shapes.Triangle((-1, 0, -1), (1, 0, -1), (0, 2, -1)) | shapes.Box((1, 0, 0), (2, 1, 1))
    s.avoid(corner | shapes.Sphere((-1, 2, 0), 0.5), **words)
    s.avoid(shapes.Plane((0, -2, 0), (0, 1, 0)), **words)
    s.avoid(shapes.Disc((0, 3, 0), (0, 1, 0), 1), **words)
    s.avoid(shapes.Rectangle((-2, 0, 2), (4, 0, 0), (0, 3, 0)), **words)
    s.avoid(shapes.Cylinder((-2, 0, -2), (-2, 1, -2), 0.5) | shapes.Cone((2, 2, 2), (2, 0, 2), 0.5), **words)
    s.bounce(shapes.Sphere((0, 1, 0), 3), restitution=0.8, exact_hit=False)
    s.bounce(shapes.Plane((0, -1, 0), (0, 1, 0)), friction=0.2, exact_hit=False)


def run(number: int, variant: dict[str, Any]) -> None:
    """Run all systems under one variant."""
    world = motes.World(
        seed=variant.get("seed", 2024),
        substeps=variant.get("substeps", 2),
        axis=variant.get("axis", "x"),
        space=space_of(variant["space"]),
        roles=roles_of(variant["roles"]),
        births=variant.get("births", "manager"),
        fan_out=variant.get("fan_out", 8),
        balancer=motes.balance.PrefixCuts(0.001, min_particles=1) if "balance" in variant else None,
        renderer=motes.Renderer(
            160,
            120,
            camera=CAMERA,
            objects=[shapes.Plane((0, 0, 0), (0, 1, 0))],
            path=variant.get("path", "auto"),
        ),
        progress="off",
    )
    systems = [
        world.system("fountain", sprite=motes.Sprite("disc", pixels=7)),
        world.system(
            "snow",
            capacity=900,
            axis="y",
            space=(0, 3),
            attributes={"heat": 0.5, "wind": (0, 0, 0)},
            sprite=motes.Sprite("point"),
        ),
        world.system("drift", axis="z", space="fit"),
        world.system("whirl", axis="y", space=(-1, 3), sprite=motes.Sprite("disc", pixels=3)),
    ]
    with world:
        for frame in world.frames(FRAMES):
            for system, act in zip(systems, (fountain, snow, drift, whirl), strict=True):
                act(system, frame)
            if frame % 5 == 3:
                systems[0].gather()
            if frame % 3 == 1:
                world.step()
                picture = "-"
            else:
                shown = world.render()
                picture = shown.digest() if shown else ""
            digest = world.digest()
            counts = ",".join(str(system.count) for system in systems)
            if (picture and picture != "-") or (picture == "-" and "manager" in world.role):
                print(number, frame, digest, picture, counts, flush=True)


for i, chosen in enumerate(json.loads(sys.argv[1])):
    run(i, chosen)
