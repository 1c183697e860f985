"""Skies, textures on solids, and fog, compared with formulas in double precision."""

from __future__ import annotations

import numpy as np
import pytest
from plain_values import equal_and_immutable

import motes
from motes.errors import ArgumentError
from motes.shapes import Box, Plane, Sphere

WIDTH, HEIGHT = 96, 64
EYE = (0.3, 1.0, 2.0)


def light(look_at=(0, 1.2, 0), *, fov=100, size=(WIDTH, HEIGHT), sun=(0, 0, 0), **options) -> np.ndarray:
    camera = motes.Camera(EYE, look_at, fov_deg=fov)
    renderer = motes.Renderer(*size, camera=camera, sun=sun, linear=True, smooth=False, **options)
    world = motes.World(seed=1, renderer=renderer, progress="off")
    world.system("none")
    with world:
        return world.render().linear.astype(float)


def directions(look_at=(0, 1.2, 0), fov=100, size=(WIDTH, HEIGHT)) -> np.ndarray:
    width, height = size
    forward = np.array(look_at) - EYE
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, (0, 1, 0))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    focal = 0.5 * height / np.tan(np.radians(fov) / 2)
    x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, height / 2 - np.arange(height) - 0.5)
    way = forward + (x[..., None] * right + y[..., None] * up) / focal
    return way / np.linalg.norm(way, axis=2, keepdims=True)


def test_a_gradient_at_known_directions():
    horizon, zenith, ground = np.array([(0.9, 0.5, 0.2), (0.1, 0.2, 0.8), (0.05, 0.3, 0.1)])
    for below, given in ((ground, ground), (horizon, None)):
        shown = light(background=motes.Gradient(horizon, zenith, given))
        height = directions()[:, :, 1:2]
        expected = np.where(
            height > 0,
            horizon * (1 - height) + zenith * height,
            horizon * (1 + height) - below * height,
        )
        np.testing.assert_allclose(shown, expected, atol=2e-5)


@pytest.mark.parametrize("look_at", [(0, 1.2, 0), (5, 1.2, 4), (0.3, 1.0, 9)])
def test_a_panorama_at_known_directions(look_at):
    rows, columns = np.mgrid[:180, :360]
    latitude, longitude = np.pi / 2 - (rows + 0.5) / 180 * np.pi, (columns + 0.5) / 360 * 2 * np.pi - np.pi
    way = np.stack(
        [np.cos(latitude) * np.sin(longitude), np.sin(latitude), -np.cos(latitude) * np.cos(longitude)], 2
    )
    picture = 1 + way
    shown = light(look_at, background=picture.astype(np.float32))
    np.testing.assert_allclose(shown, 1 + directions(look_at), atol=2e-3)


def test_pictures_of_8_bits_are_srgb_and_files_are_read(tmp_path):
    images = pytest.importorskip("PIL.Image")
    grey = np.full((8, 16, 3), 188, np.uint8)
    images.fromarray(grey).save(tmp_path / "sky.png")
    for given in (grey, tmp_path / "sky.png", str(tmp_path / "sky.png")):
        np.testing.assert_allclose(light(background=given), ((188 / 255 + 0.055) / 1.055) ** 2.4, atol=1e-5)
    pytest.importorskip("OpenEXR")
    from motes import _extras
    from motes._io import exr

    exr.write(_extras.openexr(), tmp_path / "sky.exr", np.full((8, 16, 3), 3.5, np.float32), {})
    np.testing.assert_allclose(light(background=tmp_path / "sky.exr"), 3.5, atol=1e-5)


def test_a_sky_lights_solids_from_where_it_is_bright():
    plane, ceiling = Plane((0, 0, 0), (0, 1, 0)), Plane((0, 3, 0), (0, -1, 0))
    sky = motes.Gradient((0.3, 0.3, 0.3), (0.9, 0.6, 0.3), (0.2, 0.2, 0.2))
    white = {"color": (1, 1, 1)}
    fog = ("black", 1e9)  # fog too thin to matter
    below = light((0.3, 0, 1.9), fov=30, background=sky, fog=fog, objects=[motes.Solid(plane, **white)])
    np.testing.assert_allclose(below, np.full_like(below, 1) * [0.35, 0.25, 0.15], atol=2e-3)
    above = light((0.3, 3, 1.9), fov=30, background=sky, fog=fog, objects=[motes.Solid(ceiling, **white)])
    np.testing.assert_allclose(above, 0.35 / 3, atol=2e-3)


def test_fog_hides_solids_by_their_distance_but_not_the_sky():
    color = np.array((0.5, 0.6, 0.7))
    solid = motes.Solid(Plane((0, 0, 0), (0, 1, 0)), (0, 0, 0))
    shown = light(objects=[solid], fog=(color, 4.0), background=(0.1, 0.2, 0.3))
    height = directions()[:, :, 1]
    distance = np.where(height < 0, EYE[1] / np.maximum(-height, 1e-9), np.inf)
    expected = np.where(
        height[..., None] < 0, color * (1 - np.exp(-distance / 4))[..., None], (0.1, 0.2, 0.3)
    )
    np.testing.assert_allclose(shown, expected, atol=5e-4)


def test_fog_dims_particles():
    camera = motes.Camera((0, 0, 5), (0, 0, 0))
    found = {}
    for blend in ("add", "opaque"):
        for fog in (None, ("#888", 5)):
            renderer = motes.Renderer(33, 33, camera=camera, linear=True, fog=fog)
            world = motes.World(seed=1, renderer=renderer, progress="off")
            s = world.system("s", sprite=motes.Sprite("disc", 9, blend))
            with world:
                s.emit(position=[(0, 0, 0)], color=[(0.8, 0.4, 0.2)])
                found[blend, fog is None] = world.render().linear[16, 16]
    clear = np.exp(-1)
    np.testing.assert_allclose(found["add", False], found["add", True] * clear, rtol=0.02)
    grey = motes.Light((0, 0, 0), "#888").color
    expected = found["opaque", True] * clear + np.array(grey) * (1 - clear)
    np.testing.assert_allclose(found["opaque", False], expected, rtol=0.02)


def test_pictures_lie_on_solids_and_repeat():
    picture = np.zeros((2, 2, 3), np.float32)
    picture[0, 0], picture[0, 1], picture[1, 0], picture[1, 1] = (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)
    solid = motes.Solid(Plane((0, 0, 0), (0, 1, 0)), (1, 1, 1), light=1, image=picture, scale=2.0)
    size = (64, 64)
    shown = light((0.3, 0, 1.999), fov=60, size=size, objects=[solid], fog=("black", 1e9))
    way = directions((0.3, 0, 1.999), 60, size)
    place = np.array(EYE) - way * (EYE[1] / way[:, :, 1:2])
    near = np.hypot(place[..., 0] % 1 - 0.5, place[..., 2] % 1 - 0.5) < 0.1  # near the centre of a 1 m texel
    column, row = (np.floor(place[..., k]).astype(int) % 2 for k in (0, 2))
    found = shown / shown.max()
    assert near.sum() > 50
    np.testing.assert_allclose(found[near], picture[row, column][near], atol=0.35)
    right = np.argmax(found, axis=2) == np.argmax(picture[row, column], axis=2)
    assert right[near].mean() > 0.95


def test_far_pictures_are_their_mean():
    picture = np.tile(np.eye(2, dtype=np.float32)[..., None], (32, 32, 3))
    solid = motes.Solid(Plane((0, -1000, 0), (0, 1, 0)), (1, 1, 1), light=1, image=picture, scale=0.5)
    plain = motes.Solid(Plane((0, -1000, 0), (0, 1, 0)), (1, 1, 1), light=1)
    fog = ("black", 1e9)
    found = [light((0.3, -9, 0), fov=20, objects=[one], fog=fog) for one in (solid, plain)]
    np.testing.assert_allclose(found[0], found[1] / 2, rtol=0.02)


@pytest.mark.parametrize(
    "given",
    [
        np.zeros((4, 4)),
        np.zeros((4, 4, 2)),
        np.full((4, 4, 3), np.nan),
        np.full((4, 4, 3), -1.0),
        np.zeros((4, 4, 3), np.int32),
        "missing.png",
        "missing.exr",
        "nocolour",
        3,
    ],
)
def test_wrong_skies_and_pictures_are_refused(given):
    camera = motes.Camera((0, 0, 1), (0, 0, 0))
    with pytest.raises((ArgumentError, motes.MissingExtraError)):
        motes.Renderer(8, 8, camera=camera, background=given)
    with pytest.raises((ArgumentError, motes.MissingExtraError)):
        motes.Solid(Sphere((0, 0, 0), 1), image=given)


@pytest.mark.parametrize("given", ["grey", ("grey",), ("grey", 0), ("grey", -1), (3, 3), 5])
def test_wrong_fog_is_refused(given):
    with pytest.raises(ArgumentError):
        motes.Renderer(8, 8, camera=motes.Camera((0, 0, 1), (0, 0, 0)), fog=given)


def test_skies_and_solids_are_values():
    equal_and_immutable(motes.Gradient("red", "blue"), motes.Gradient((1, 0, 0), (0, 0, 1)))
    picture = np.ones((2, 2, 3), np.float32)
    solid = motes.Solid(Box((0, 0, 0), (1, 1, 1)), image=picture, scale=2)
    equal_and_immutable(solid, motes.Solid(Box((0, 0, 0), (1, 1, 1)), image=picture.copy(), scale=2))
    assert solid != motes.Solid(Box((0, 0, 0), (1, 1, 1)), image=2 * picture, scale=2)
