"""Shapes as values: what they contain, where their samples fall, their measure, what they refuse."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

import motes
from motes.errors import ArgumentError
from motes.shapes import (
    Blob,
    Box,
    Cone,
    Cylinder,
    Disc,
    Line,
    Plane,
    Point,
    Rectangle,
    Shape,
    Sphere,
    Triangle,
    Union,
)

Cells = Callable[[np.ndarray], list[np.ndarray]]

COUNT, SIDE = 200_000, 6
START, AXIS = np.array([1.0, -2.0, 0.5]), np.array([2.0, 1.0, -2.0])  # the axis is 3 m long


def around_axis(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the fraction of the axis, the distance from it, and the angle around it in turns."""
    unit = AXIS / 3
    offset = points - START
    along = offset @ unit
    u = np.cross(unit, [1.0, 0, 0])
    u /= np.linalg.norm(u)
    across = offset - along[:, None] * unit
    turn = np.arctan2(across @ np.cross(unit, u), across @ u) / (2 * np.pi) + 0.5
    return along / 3, np.linalg.norm(across, axis=1), turn


def in_line(points: np.ndarray) -> list[np.ndarray]:
    return [points @ AXIS / 9 - START @ AXIS / 9]


def in_rectangle(points: np.ndarray) -> list[np.ndarray]:
    return [points[:, 0] / 2, (points[:, 1] - points[:, 0] / 2) / 3]


def in_triangle(points: np.ndarray) -> list[np.ndarray]:
    a, b = in_rectangle(points)  # coordinates in the parallelogram of two edges
    return [(a + b) ** 2, b / (a + b)]


def in_disc(points: np.ndarray) -> list[np.ndarray]:
    _, r, turn = around_axis(points)
    return [(r**2 - 1) / 3, turn]


def in_box(points: np.ndarray) -> list[np.ndarray]:
    return [(points[:, 0] + 1) / 3, points[:, 1] / 2, (points[:, 2] - 5) / 0.5]


def in_ball(inner: float) -> Cells:
    def cells(points: np.ndarray) -> list[np.ndarray]:
        r = np.linalg.norm(points - START, axis=1)
        z = (points - START)[:, 2] / r
        turn = np.arctan2(*(points - START)[:, :2].T) / (2 * np.pi) + 0.5
        return [(r**3 - inner**3) / (8 - inner**3), (z + 1) / 2, turn]

    return cells


def in_cylinder(inner: float) -> Cells:
    def cells(points: np.ndarray) -> list[np.ndarray]:
        along, r, turn = around_axis(points)
        return [along, turn] if inner == 2 else [along, (r**2 - inner**2) / (4 - inner**2), turn]

    return cells


def in_cone(inner: float) -> Cells:
    def cells(points: np.ndarray) -> list[np.ndarray]:
        along, r, turn = around_axis(points)
        if inner == 2:
            return [along**2, turn]
        return [along**3, ((r / along) ** 2 - inner**2) / (4 - inner**2), turn]

    return cells


def in_blob(points: np.ndarray) -> list[np.ndarray]:
    erf = np.vectorize(math.erf, otypes=[float])
    return [0.5 + 0.5 * erf((points[:, c] - START[c]) / 0.7 / math.sqrt(2)) for c in range(3)]


END = tuple(START + AXIS)
UNIFORM = [
    (Line(START, END), in_line),
    (Rectangle((0, 0, 1), (2, 1, 0), (0, 3, 0)), in_rectangle),
    (Triangle((0, 0, 1), (2, 1, 1), (0, 3, 1)), in_triangle),
    (Disc(START, AXIS, 2, 1), in_disc),
    (Box((-1, 0, 5), (2, 2, 5.5)), in_box),
    (Sphere(START, 2), in_ball(0)),
    (Sphere(START, 2, 1.5), in_ball(1.5)),
    (Cylinder(START, END, 2), in_cylinder(0)),
    (Cylinder(START, END, 2, 1.5), in_cylinder(1.5)),
    (Cylinder(START, END, 2, 2), in_cylinder(2)),
    (Cone(START, END, 2), in_cone(0)),
    (Cone(START, END, 2, 1.5), in_cone(1.5)),
    (Cone(START, END, 2, 2), in_cone(2)),
    (Blob(START, 0.7), in_blob),
]


@pytest.mark.parametrize(("shape", "cells"), UNIFORM, ids=[repr(shape) for shape, _ in UNIFORM])
def test_samples_are_uniform(shape: Shape, cells: Cells):
    # `cells` returns coordinates that are uniform in [0, 1] if samples are uniform in the shape.
    points = shape.sample(COUNT, seed=7).astype(float)
    places = cells(points)
    index = np.zeros(COUNT, int)
    for place in places:
        assert place.min() > -1e-4 and place.max() < 1 + 1e-4
        index = index * SIDE + np.clip((place * SIDE).astype(int), 0, SIDE - 1)
    number = SIDE ** len(places)
    expected = COUNT / number
    chi_square = float(((np.bincount(index, minlength=number) - expected) ** 2 / expected).sum())
    free = number - 1
    assert abs(chi_square - free) < 4 * math.sqrt(2 * free)


SOLIDS = [shape for shape, _ in UNIFORM if isinstance(shape, (Box, Sphere, Cylinder, Cone))]


@pytest.mark.parametrize("shape", SOLIDS, ids=repr)
def test_solids_hold_their_samples_and_measure_what_they_hold(shape: Shape):
    points = shape.sample(20_000, seed=1)
    thin = "inner_radius=2.0" in repr(shape)
    if thin:
        assert not isinstance(shape, (Cylinder, Cone)) or not shape.contains(points).any()
        return
    assert shape.contains(points).mean() > 0.999  # all except those rounded across the border
    low, high = points.min(0) - 0.1, points.max(0) + 0.1
    around = np.random.default_rng(1).uniform(low, high, (400_000, 3))
    held = shape.contains(around).mean() * np.prod(high - low)
    assert held == pytest.approx(shape.measure, rel=0.03)


def test_what_shapes_hold():
    cylinder, cone = Cylinder((0, 0, 0), (0, 4, 0), 2, 1), Cone((0, 4, 0), (0, 0, 0), 4, 2)
    points = [(1.5, 2, 0), (0.5, 2, 0), (2.5, 2, 0), (1.5, -0.1, 0), (1.5, 4.1, 0)]
    assert cylinder.contains(points).tolist() == [True, False, False, False, False]
    # Halfway up, the cone spans radii of 1 to 2 m.
    assert cone.contains(points).tolist() == [True, False, False, False, False]
    assert cone.contains((3, 0.5, 0)) and not cone.contains((1.5, 5, 0))  # nothing beyond the apex
    assert Blob((1, 0, 0), 0.5).contains([(1.4, 0, 0), (1.6, 0, 0)]).tolist() == [True, False]
    for flat in (Point((0, 0, 0)), Line((0, 0, 0), (2, 0, 0)), Triangle((0, 0, 0), (2, 0, 0), (0, 2, 0))):
        assert not flat.contains([(0, 0, 0), (0.5, 0.5, 0)]).any()


def test_measures():
    assert Triangle((0, 0, 0), (3, 0, 0), (0, 4, 0)).measure == pytest.approx(6)
    assert Cylinder(START, END, 2, 1).measure == pytest.approx(math.pi * 3 * 3)
    assert Cylinder(START, END, 2, 2).measure == pytest.approx(2 * math.pi * 2 * 3)
    assert Cone(START, END, 2, 1).measure == pytest.approx(math.pi * 3)
    assert Cone(START, END, 2, 2).measure == pytest.approx(math.pi * 2 * math.sqrt(13))
    assert Sphere(START, 2, 2).measure == pytest.approx(4 * math.pi * 4)
    assert Disc(START, AXIS, 2, 2).measure == pytest.approx(2 * math.pi * 2)
    assert Blob(START, 1).measure == math.inf
    assert (Box((0, 0, 0), (1, 1, 1)) | Triangle((0, 0, 0), (3, 0, 0), (0, 4, 0))).measure == pytest.approx(7)


def parts_hit(union: Union, shapes: list[Shape]) -> list[float]:
    points = union.sample(COUNT, seed=2)
    return [float(shape.contains(points).mean()) for shape in shapes]


def test_a_union_is_drawn_by_measure_or_evenly():
    small, large, far = Box((0, 0, 0), (1, 1, 1)), Box((2, 0, 0), (4, 2, 2)), Sphere((9, 9, 9), 0.01)
    assert parts_hit(small | large, [small, large]) == pytest.approx([1 / 9, 8 / 9], abs=0.005)
    # Samples in a part of a union are distributed as in the part by itself.
    points = (small | large).sample(COUNT, seed=2)
    mean, spread = points[large.contains(points)].mean(0), points[large.contains(points)].std(0)
    assert mean == pytest.approx([3, 1, 1], abs=0.01) and spread == pytest.approx(2 / math.sqrt(12), abs=0.01)
    endless = Blob((50, 50, 50), 1) | far | small
    assert parts_hit(endless, [far, small]) == pytest.approx([1 / 3, 1 / 3], abs=0.005)
    points = Union((0, 0, 0), (1, 0, 0), (2, 0, 0)).sample(COUNT, seed=3)
    assert [(points[:, 0] == x).mean() for x in range(3)] == pytest.approx([1 / 3] * 3, abs=0.005)
    assert not ((0, 0, 0) | large).contains((0.0, 0.0, 0.0))
    assert large.contains(((0, 0, 0) | large).sample(1000)).all(), "a point has no measure beside a box"


def test_unions_are_flat_values():
    a, b, c = Sphere((0, 0, 0), 1), Box((2, 2, 2), (3, 3, 3)), Point((5, 5, 5))
    union = a | b | c
    assert isinstance(union, Union) and union.shapes == (a, b, c)
    assert union == a | (b | c) == Union(a, b, (5, 5, 5)) == a | b | (5, 5, 5)
    assert hash(union) == hash(a | (b | c))
    assert union != a | c | b and union != a | b and Union(a) != a
    assert ((5, 5, 5) | a).shapes == (c, a)
    assert eval(repr(union)) == union
    assert union.contains([(0, 0, 0), (2.5, 2.5, 2.5), (5, 5, 5)]).tolist() == [True, True, False]
    many = Union(*(Sphere((3 * i, 0, 0), 1) for i in range(300)))
    assert many.contains([(3 * i, 0.5, 0) for i in range(300)]).all()
    assert len(np.unique(np.round(many.sample(20_000)[:, 0] / 3))) == 300


def test_a_sample_depends_on_seed_and_number_alone():
    for shape in (Cone(START, END, 2), Blob(START, 1) | Box((0, 0, 0), (1, 1, 1)) | Sphere(START, 1)):
        points = shape.sample(1000, seed=4)
        assert (shape.sample(1003, seed=4)[:1000] == points).all()
        assert (shape.sample(17, seed=4) == points[:17]).all()
        assert not (shape.sample(1000, seed=5) == points).all()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Triangle((0, 0, 0), (1, 1, 1), (2, 2, 2)), "must span an area"),
        (lambda: Cylinder((0, 0, 0), (0, 0, 0), 1), "p0 and p1 must differ"),
        (lambda: Cylinder((0, 0, 0), (0, 0, 1), 0), "radius must be > 0"),
        (lambda: Cylinder((0, 0, 0), (0, 0, 1), 1, 2), "inner_radius must be 0..radius"),
        (lambda: Cone((0, 0, 0), (0, 0, 0), 1), "apex and base must differ"),
        (lambda: Cone((0, 0, 0), (0, 0, 1), -1), "radius must be a finite number >= 0"),
        (lambda: Blob((0, 0, 0), 0), "sigma must be > 0"),
        (lambda: Blob((0, 0, math.nan), 1), "center must be 3 finite numbers"),
        (lambda: Union(), "shapes must be one shape or more"),
        (lambda: Union(3), "shapes must be a shape or 3 finite numbers"),
        (lambda: motes.actions.Bounce(shape=Point((0, 0, 0))), "surface"),
        (lambda: motes.actions.Bounce(shape=Plane((0, 0, 0), (0, 1, 0)) | (1, 1, 1)), "surface"),
        (
            lambda: motes.Solid(Sphere((0, 0, 0), 1) | Blob((0, 0, 0), 1)),
            "shape must be a shape with a surface",
        ),
    ],
)
def test_refusals(make: Callable[[], object], message: str):
    with pytest.raises(ArgumentError, match="(?s)" + message.replace(".", r"\.")):
        refused = make()
        motes.Renderer(8, 8, camera=motes.Camera((0, 0, 9), (0, 0, 0)), objects=[refused])


def test_a_solid_union_looks_like_its_parts():
    ball, cone = Sphere((-1, 1, 0), 0.8), Cone((1, 2, 0), (1, 0, 0), 0.9)
    camera = motes.Camera((0, 2, 7), (0, 1, 0))
    pictures = set()
    for objects in (
        [motes.Solid(ball | cone, (0.5, 0.2, 0.1))],
        [motes.Solid(s, (0.5, 0.2, 0.1)) for s in (ball, cone)],
    ):
        renderer = motes.Renderer(64, 36, camera=camera, objects=objects)
        with motes.World(seed=1, renderer=renderer, progress="off") as world:
            picture = world.render()
        assert len(np.unique(np.asarray(picture), axis=None)) > 20
        pictures.add(picture.digest())
    assert len(pictures) == 1
