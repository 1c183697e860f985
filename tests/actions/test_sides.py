"""No particle passes through what it bounces off: any shape, size, place, speed and number of sub-steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from sides import Sheet, Wall, rounding, walls_of

import motes
from motes import shapes
from motes.errors import ArgumentError

COUNT = 24  # particles per combination
TOGETHER = 25  # combinations per world
KINDS = ("Plane", "Box", "Sphere", "Cylinder", "Pipe", "Tube", "Cone", "Funnel", "Hat", "Disc", "Ring")
KINDS += ("Rectangle", "Triangle", "Union")


@st.composite
def directions(draw: st.DrawFn) -> np.ndarray:
    """Draw a unit vector, along an axis or in any direction."""
    axis = draw(st.integers(-1, 5))
    if axis >= 0:
        return np.eye(3)[axis % 3] * (1 - 2 * (axis // 3))
    v = np.array(draw(st.tuples(*[st.integers(-9, 9)] * 3).filter(any)), float)
    return v / np.linalg.norm(v)


def magnitudes(low: float, high: float) -> st.SearchStrategy[float]:
    """Draw numbers between 10**low and 10**high, of any magnitude."""
    return st.floats(low, high).map(lambda power: 10.0**power)


def across(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    u = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    u /= np.linalg.norm(u)
    return u, np.cross(axis, u)


@st.composite
def made(draw: st.DrawFn, kind: str, at: np.ndarray, size: float) -> shapes.Shape:
    """Draw a shape of the given kind and size around a position."""
    part = st.integers(1, 9).map(lambda n: n / 9)
    axis, some, other = draw(directions()), draw(part), draw(part)
    u, v = across(axis)
    if kind == "Plane":
        return shapes.Plane(at, axis * draw(st.sampled_from([1, 0.3, 40])))
    if kind == "Box":
        half = np.array([1, some, other]) * size
        return shapes.Box(at - half, at + half)
    if kind == "Sphere":
        return shapes.Sphere(at, size)
    if kind == "Union":
        near = at + u * size * 0.7
        kinds = [draw(st.sampled_from(("Box", "Sphere", "Cylinder", "Cone", "Rectangle"))) for _ in range(2)]
        return shapes.Union(*[draw(made(k, place, size)) for k, place in zip(kinds, (at, near), strict=True)])
    if kind in ("Disc", "Ring"):
        return shapes.Disc(at, axis, size, 0 if kind == "Disc" else some * size * 0.6)
    if kind == "Rectangle":
        return shapes.Rectangle(at - (u + v) * size, 2 * u * size, 2 * v * size)
    if kind == "Triangle":
        return shapes.Triangle(at - u * size, at + u * size, at + v * size)
    first, last, radius = at - axis * size * other, at + axis * size * other, size * some
    inner = {"Cylinder": 0, "Cone": 0, "Tube": 1, "Hat": 1}.get(kind, 0.6) * radius
    if kind in ("Cylinder", "Pipe", "Tube"):
        return shapes.Cylinder(first, last, radius, inner)
    return shapes.Cone(first, last, radius, inner)


@st.composite
def combinations(draw: st.DrawFn) -> dict[str, Any]:
    """Draw a shape, and how particles fly at it and bounce."""
    size, away = draw(magnitudes(-3, 4)), draw(directions())
    # The shape is around the origin, has the origin on its surface, or is anywhere.
    far = draw(st.one_of(st.sampled_from([0.0, size, size]), magnitudes(-2, 6)))
    try:
        shape = draw(made(draw(st.sampled_from(KINDS)), away * far, size))
    except ArgumentError:  # too small for float32 at that distance
        shape = draw(made("Sphere", away * far, size))
    part = st.one_of(st.sampled_from([0.0, 0.2, 0.5, 1.0]), st.floats(0, 1))
    return {
        "shape": shape,
        "at": away * far,
        "size": size,
        "restitution": draw(part),
        "friction": draw(part),
        "gravity": draw(directions()) * draw(st.sampled_from([0, 9.8, 9.8, 300])),
        "speed": draw(st.one_of(st.sampled_from([0.0, 1.0, 10.0]), magnitudes(-38, 4))),
        "exact_hit": draw(st.sampled_from([True, True, True, False])),
        "avoids": draw(st.sampled_from([False, False, True])),
        "seed": draw(st.integers(0, 2**32)),
    }


def born(combination: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Return positions near the surface or on it, and velocities."""
    dice = np.random.default_rng(combination["seed"])
    apart = dice.normal(0, 1, (COUNT, 3)) * 10.0 ** dice.uniform(-4, 0.1, (COUNT, 1))
    points = combination["shape"].sample(COUNT, seed=int(combination["seed"]))
    position = np.float32(points + apart * combination["size"])
    v = dice.normal(0, 1, (COUNT, 3))
    v /= np.linalg.norm(v, axis=1)[:, None]
    return position, np.float32(v * combination["speed"])


def passed(wall: Sheet, start: np.ndarray, end: np.ndarray, way: np.ndarray, steps: int) -> np.ndarray:
    return wall.pierced(start, end) if wall.flat and steps == 1 else wall.crossed(start, end, way)


def check(list_of: list[dict[str, Any]], frames: int, substeps: int, every: int) -> None:
    """Run combinations side by side and check that no particle passes through a wall."""
    dt = 1 / 24
    world = motes.World(seed=1, dt=dt, substeps=substeps, progress="off")
    systems = [world.system(f"s{i}", capacity=COUNT) for i in range(len(list_of))]
    walls = [walls_of(c["shape"]) for c in list_of]
    starts = [born(c) for c in list_of]
    last = [position.astype(float) for position, _ in starts]
    first = [position.astype(float) for position, _ in starts]
    holds = [c["shape"].contains(position) for c, (position, _) in zip(list_of, starts, strict=True)]
    with world:
        for frame in world.frames(frames):
            for s, c, (position, velocity) in zip(systems, list_of, starts, strict=True):
                if frame == 0:
                    s.emit(position=position, velocity=velocity)
                s.gravity(c["gravity"])
                if c["avoids"]:
                    s.avoid(c["shape"], magnitude=2, epsilon=0, look_ahead=1)
                s.bounce(c["shape"], c["restitution"], c["friction"], exact_hit=c["exact_hit"])
                s.move()
            world.step()
            if frame % every and frame != frames - 1:
                continue
            for i, (s, c) in enumerate(zip(systems, list_of, strict=True)):
                p = s.gather()
                assert len(p.id) == COUNT, f"frame {frame}: {COUNT - len(p.id)} died of {c}"
                order = np.argsort(p.id)
                now = p.position[order].astype(float)
                speed = np.linalg.norm(p.velocity[order].astype(float), axis=1)
                held = c["shape"].contains(p.position[order])
                assert not (held & ~holds[i]).any(), f"frame {frame}: {c['shape']} holds others of {c}"
                assert isinstance(c["shape"], shapes.Plane) or (held == holds[i]).all(), f"lost: {c}"
                way = 1.01 * dt * speed + dt * dt * np.linalg.norm(c["gravity"]) + 4 * rounding(now)
                for wall in walls[i]:
                    if isinstance(wall, Wall):
                        lost = wall.crossed(first[i], now)
                    elif every == 1:
                        lost = passed(wall, last[i], now, 2 * way, substeps)
                    else:
                        continue
                    assert not lost.any(), (
                        f"frame {frame}: {lost.sum()} of {COUNT} passed {c['shape']} of {c}"
                    )
                last[i] = now


many = settings(
    deadline=None,
    database=None,
    derandomize=True,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
)
worlds = given(
    list_of=st.lists(combinations(), min_size=TOGETHER, max_size=TOGETHER),
    substeps=st.sampled_from([1, 1, 2, 5, 20]),
)


@settings(many, max_examples=20)
@worlds
def test_nobody_passes_a_surface(list_of, substeps):
    check(list_of, 16, substeps, every=1)


@pytest.mark.slow
@settings(many, max_examples=800, derandomize=False)
@worlds
def test_nobody_of_many_passes_a_surface(list_of, substeps):
    check(list_of, 16, substeps, every=1)


@pytest.mark.slow
@settings(many, max_examples=4)
@worlds
def test_nobody_passes_a_surface_in_a_long_time(list_of, substeps):
    check(list_of, 10_000, min(substeps, 2), every=200)


@pytest.mark.parametrize(
    "shape",
    [
        shapes.Sphere((0, 2, 0), 2),
        shapes.Cylinder((0, 0, 0), (0.3, 4, 0), 2),
        shapes.Cone((0, 4, 0), (0, 0, 0.1), 2),
        shapes.Box((-2, 0, -2), (2, 4, 2)),
        shapes.Cylinder((1e5, 0, 0), (1e5, 4, 0), 2),
    ],
    ids=repr,
)
def test_sink_and_where_find_nobody_beyond_the_surface(shape):
    middle = np.array(shape.sample(2000, seed=1)).mean(axis=0)
    born_at = np.float32(shape.sample(2000, seed=2) * 0.5 + middle * 0.5)
    born_at = born_at[shape.contains(born_at)]
    world = motes.World(seed=2, progress="off")
    grains = world.system("grains")
    with world:
        for frame in world.frames(60):
            if frame == 0:
                grains.emit(position=born_at, velocity=np.random.default_rng(3).normal(0, 1, born_at.shape))
            grains.gravity((0, -9.8, 0))
            grains.bounce(shape, restitution=0.1, friction=0.1)
            grains.move()
            grains.set(alpha=0.5, where=~shape)
            grains.sink(shape, inside=False)
            world.step()
        assert len(grains.gather().id) == len(born_at)
        assert (grains.gather().alpha == 1).all()


def globe(lobes: float) -> motes.Mesh:
    """Make a closed surface with bulges, between which a path has many hits."""
    across, along = np.meshgrid(
        np.linspace(0, 2 * np.pi, 24, endpoint=False), np.linspace(0, np.pi, 14)[1:-1]
    )
    radius = 1 + lobes * np.sin(5 * across) * np.sin(along) ** 2
    ring = radius * np.sin(along)
    middle = np.stack([ring * np.cos(across), radius * np.cos(along), ring * np.sin(across)], -1).reshape(
        -1, 3
    )
    points = np.concatenate([[[0, 1, 0]], middle, [[0, -1, 0]]])
    faces = []
    for i in range(24):
        j = (i + 1) % 24
        faces += [(0, 1 + j, 1 + i), (len(points) - 1, len(points) - 25 + i, len(points) - 25 + j)]
        for k in range(11):
            a, b, c, d = (1 + 24 * (k + n) + m for n, m in ((0, i), (0, j), (1, i), (1, j)))
            faces += [(a, b, c), (b, d, c)]
    return motes.Mesh(points, faces, resolution=24)


@pytest.mark.parametrize(
    ("speed", "moves"), [(0, False), (1e-30, False), (1e4, False), (3, True), (300, True), (1e4, True)]
)
def test_nobody_passes_a_mesh(moves, speed):
    dice = np.random.default_rng(4)
    body = globe(0.3)
    start = np.float32(dice.normal(0, 0.6, (400, 3)))
    velocity = dice.normal(0, 1, start.shape)
    velocity *= speed / np.linalg.norm(velocity, axis=1)[:, None]
    world = motes.World(seed=2, progress="off")
    dust = world.system("dust")
    now = before = body.at((0, 0, 0))
    inside = now.contains(start)
    with world:
        for frame in world.frames(40):
            if frame == 0:
                dust.emit(position=start, velocity=velocity)
            if moves:
                now = body.at(
                    (0.3 * np.sin(frame / 3), 0.02 * frame, 0),
                    axis=(1, 2, 1),
                    angle_deg=7 * frame,
                    moving_from=before,
                )
            dust.gravity((0, -9.8, 0))
            dust.bounce(now, restitution=[0.0, 0.3, 1.0][frame % 3], friction=0.2)
            dust.move()
            world.step()
            before = now
            p = dust.gather()
            order = np.argsort(p.id)
            np.testing.assert_array_equal(now.contains(p.position[order]), inside)
