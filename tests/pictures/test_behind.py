"""Particles close behind a thin object are hidden, from either side; those lying on it show."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from numpy.typing import NDArray

import motes
from motes.shapes import Box, Cylinder, Disc, Plane, Rectangle, Sphere, Triangle

QUAD = motes.Mesh([(-9, 0, -9), (9, 0, -9), (9, 0, 9), (-9, 0, 9)], [(0, 1, 2), (0, 2, 3)])
THIN = {
    "plane": Plane((0, 0, 0), (0, 1, 0)),
    "rectangle": Rectangle((-9, 0, -9), (18, 0, 0), (0, 0, 18)),
    "disc": Disc((0, 0, 0), (0, 1, 0), 9),
    "triangle": Triangle((-30, 0, -20), (60, 0, 0), (30, 0, 60)),
    "mesh": QUAD,
    "sheet": Box((-9, -0.001, -9), (9, 0.001, 9)),
}
CAMERAS = [(0, -1.2, 9), (0, -0.2, 9), (-8.5, -1.1, -1.5), (3, -6, 2)]
SPRITES = {
    "disc": motes.Sprite("disc", pixels=3),
    "point": motes.Sprite("point"),
    "wide": motes.Sprite("disc", pixels=20),
    "metres": motes.Sprite("disc", pixels=None),
    "sphere": motes.Sprite("sphere", pixels=5, blend="opaque"),
    "alpha": motes.Sprite("disc", pixels=7, blend="alpha"),
    "soft": motes.Sprite("disc", pixels=5, softness=0.05),
}


def picture(
    shape: object | None,
    camera: tuple[float, float, float],
    positions: NDArray[np.float32] | None,
    sprite: motes.Sprite = SPRITES["disc"],
    look_at: tuple[float, float, float] = (0, 1.5, 0),
    **options: object,
) -> NDArray[np.int64]:
    objects = [] if shape is None else [motes.Solid(shape, (0.3, 0.3, 0.4))]
    renderer = motes.Renderer(
        320, 180, camera=motes.Camera(camera, look_at), objects=objects, background=(0, 0, 0)
    )
    world = motes.World(seed=7, renderer=renderer, progress="off", **options)
    s = world.system("s", sprite=sprite)
    with world:
        if positions is not None:
            s.emit(position=positions, size=np.full((len(positions), 3), 0.08, np.float32))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # one side of a plane is the inside of its half-space
            return np.asarray(world.render().pixels).astype(int)


def changed(shape: object | None, camera: tuple[float, float, float], y: float, **options: object) -> int:
    """Count the shape's pixels (all pixels if there is no shape) that a row of particles changes."""
    row = np.array([(x, y, z) for x in np.linspace(-1, 1, 60) for z in (-0.5, 0, 0.7)], np.float32)
    without, with_them = picture(shape, camera, None, **options), picture(shape, camera, row, **options)
    shows = without.sum(axis=2) > 0
    return int(((np.abs(with_them - without).sum(axis=2) > 0) & (shows | (shape is None))).sum())


def mirrored(camera: tuple[float, float, float]) -> tuple[float, float, float]:
    return (camera[0], -camera[1], camera[2])


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("shape", THIN)
def test_what_is_close_behind_a_surface_is_hidden_from_both_sides(shape, camera):
    above, below = {"look_at": (0, 1.5, 0)}, {"look_at": (0, -1.5, 0)}
    for y in (0.02, 0.05, 0.2):
        assert changed(THIN[shape], camera, y, **above) == 0
        assert changed(THIN[shape], mirrored(camera), -y, **below) == 0


@pytest.mark.parametrize("sprite", SPRITES)
def test_of_every_kind(sprite):
    for camera in CAMERAS:
        assert changed(THIN["plane"], camera, 0.05, sprite=SPRITES[sprite]) == 0


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("shape", THIN)
def test_what_lies_on_a_surface_shows(shape, camera):
    """Seen from its own side it shows completely, except the lower edge of discs on surfaces seen edge on."""
    for at, eye, look_at in ((0.0012, mirrored(camera), (0, -1.5, 0)), (-0.0012, camera, (0, 1.5, 0))):
        free = changed(None, eye, at, look_at=look_at)
        assert free > 50
        shown = changed(THIN[shape], eye, at, look_at=look_at)
        assert shown == free if abs(eye[1]) > 5 else shown >= 0.7 * free


@pytest.mark.parametrize("radius", [2, 0.5])  # the smaller surface turns away within few pixels
@pytest.mark.parametrize("kind", [Sphere, Cylinder])
def test_what_lies_on_a_round_surface_shows_up_to_its_silhouette(kind, radius):
    rows = np.random.default_rng(3).normal(size=(300, 3))
    if kind is Cylinder:
        shape = Cylinder((0, -2, 0), (0, 2, 0), radius)
        angle = rows[:, 0] * 9
        positions = np.stack([radius * np.cos(angle), np.tanh(rows[:, 1]), radius * np.sin(angle)], 1)
        facing = np.stack([np.cos(angle), 0 * angle, np.sin(angle)], 1)
    else:
        shape = Sphere((0, 0, 0), radius)
        facing = rows / np.linalg.norm(rows, axis=1, keepdims=True)
        positions = radius * facing
    eye = np.array((0, 1, 9))
    towards = (facing * (eye - positions)).sum(axis=1) / np.linalg.norm(eye - positions, axis=1)
    near = positions[towards > 0.2].astype(np.float32)
    assert len(near) > 80
    point = SPRITES["point"]
    same = {"look_at": (0, 0, 0), "sprite": point}
    free = picture(None, (0, 1, 9), near, **same)
    solid, empty = picture(shape, (0, 1, 9), near, **same), picture(shape, (0, 1, 9), None, **same)
    lit = (free.sum(axis=2) > 30).sum()
    assert ((solid - empty).sum(axis=2) > 0).sum() > 0.99 * lit


def test_a_particle_that_reaches_out_from_behind_shows_there():
    """Of a disc across a rectangle's edge, only the part beside the rectangle is visible."""
    shape = Rectangle((-1, -1, 0), (2, 0, 0), (0, 2, 0))
    sprite = motes.Sprite("disc", pixels=21)
    same = {"look_at": (0, 0, 0), "sprite": sprite}
    at = np.array([(0.98, 0, -0.03)], np.float32)
    free = picture(None, (0, 0, 9), at, **same).sum(axis=2) > 0
    solid = picture(shape, (0, 0, 9), at, **same)
    empty = picture(shape, (0, 0, 9), None, **same)
    shown = np.abs(solid - empty).sum(axis=2) > 0
    assert 0.2 * free.sum() < shown.sum() < 0.6 * free.sum()
    assert (shown <= free).all()
    rectangle = empty.sum(axis=2) > 0
    assert not (shown & rectangle)[:, 1:].sum() > 25, "but for pixels on the edge itself"
