"""Lamps brighten lit spheres, meshes, cards and images beyond sun and sky; references in double precision.

Opaque surfaces become brighter than white; blended ones keep their hue and end at white.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import motes

SUN, SKY, BOUNCE = 0.70, 0.24, 0.10  # fractions of daylight
COLOR = (0.5, 0.25, 0.1)
POINTS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CUBE = motes.Mesh(POINTS, [t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))])
GREY = np.full((8, 8, 3), 0.5, np.float32)  # sRGB
LINEAR = ((0.5 + 0.055) / 1.055) ** 2.4
TINTED = np.full((8, 8, 3), (0.7, 0.5, 0.5), np.float32)  # sRGB
LINEAR_TINT = ((TINTED[0, 0] + 0.055) / 1.055) ** 2.4


def pixels(sprite: motes.Sprite, power: float, *, sun: Any = (0, 0, 0), **lens: float) -> np.ndarray:
    """Render one particle, with the eye 5 m and a lamp 4 m away along z."""
    lamps = [motes.Light((0, 0, 4), (1, 1, 1), power)]
    camera = motes.Camera((0, 0, 5), (0, 0, 0), **lens)
    renderer = motes.Renderer(48, 48, camera=camera, linear=True, sun=sun, lights=lamps)
    world = motes.World(seed=1, renderer=renderer, progress="off")
    system = world.system("one", sprite=sprite)
    with world:
        system.emit(position=[(0, 0, 0)], color=[COLOR])
        return world.render().linear.astype(float)


def within_white(color: np.ndarray) -> np.ndarray:
    return color / np.maximum(color.max(axis=-1, keepdims=True), 1)


@pytest.mark.parametrize("power", [2.0, 30.0, 120.0])
@pytest.mark.parametrize("sun", [(0, 0, 0), (0.0, 1.0, 1.0)])
def test_a_sphere(sun: tuple[float, ...], power: float) -> None:
    """Each point of its surface is lit by sun, sky and lamp from their directions."""
    picture = pixels(motes.Sprite("sphere", 30, blend="opaque", lit=True), power, sun=sun)
    focal = 24 / np.tan(np.radians(20))
    radius = 15 * 5 / focal
    across, down = np.meshgrid(*[(np.arange(48) - 23.5) / focal] * 2)
    ray = np.stack([across, -down, -np.ones_like(across)], -1)
    square, ahead = (ray**2).sum(-1), 5.0  # the centre is 5 m ahead
    under = ahead**2 - square * (ahead**2 - radius**2)
    inside = under > 0.2 * radius**2
    length = (ahead - np.sqrt(np.where(inside, under, 0))) / square
    normal = (ray * length[..., None] + (0, 0, 5)) / radius
    toward = np.array(sun) / max(np.linalg.norm(sun), 1e-9)
    along = np.array((0, 0, 4)) - normal * radius
    distance = np.linalg.norm(along, axis=-1)
    lamp = power * np.maximum((normal * along).sum(-1), 0) / distance**3
    light = (
        BOUNCE + (SKY - BOUNCE) * (0.5 + 0.5 * normal[..., 1]) + SUN * np.maximum(normal @ toward, 0) + lamp
    )
    expected = np.array(COLOR) * light[..., None]
    assert (np.abs(picture - expected) / expected.max(axis=-1, keepdims=True))[inside].max() < 0.02


@pytest.mark.parametrize("blend", ["add", "alpha", "opaque"])
@pytest.mark.parametrize("power", [2.0, 30.0, 120.0])
def test_a_mesh_that_faces_the_lamp(power: float, blend: Any) -> None:
    """Without a sun the front, 3.5 m from the lamp, gets the sky's mean light and the lamp's."""
    light = np.array(COLOR) * ((BOUNCE + SKY) / 2 + power / 3.5**2)
    picture = pixels(motes.Sprite("mesh", mesh=CUBE, blend=blend, lit=True), power)
    expected = light if blend == "opaque" else within_white(light)
    assert picture[24, 24] == pytest.approx(expected, abs=0.012 * max(expected))


@pytest.mark.parametrize("facing", ["camera", "orientation"])
@pytest.mark.parametrize("blend", ["add", "alpha", "opaque"])
@pytest.mark.parametrize("power", [2.0, 60.0, 500.0])
def test_a_dark_picture(power: float, blend: Any, facing: Any) -> None:
    """A lamp brightens a dark image by the same factor as a white one, and keeps the hue."""
    sprite = motes.Sprite("image", 30, image=TINTED, blend=blend, lit=True)
    part = 2 / 3
    if facing == "orientation":
        sprite, part = motes.Sprite("image", image=TINTED, blend=blend, lit=True, facing=facing), 1.0
    light = (BOUNCE + SKY) / 2 + part * power / 16
    picture = pixels(sprite, power)
    expected = LINEAR_TINT * np.array(COLOR) * light
    if blend != "opaque" or facing == "camera":
        expected = within_white(expected)
    assert picture[24, 24] == pytest.approx(expected, abs=0.012 * max(expected.max(), 1))


@pytest.mark.parametrize(
    "kind", [{"kind": "sphere", "pixels": 3}, {"kind": "image", "pixels": 4, "image": GREY}]
)
@pytest.mark.parametrize("blend", ["add", "alpha"])
def test_small_ones_have_the_light_of_large_ones(kind: dict[str, Any], blend: Any) -> None:
    def mean(pixels_wide: int) -> np.ndarray:
        sprite = motes.Sprite(**kind | {"pixels": pixels_wide}, blend=blend, lit=True)
        return np.asarray(pixels(sprite, 60.0).sum(axis=(0, 1)) / pixels_wide**2)

    assert mean(kind["pixels"]) == pytest.approx(mean(32), rel=0.06)


def test_blurred_cards_are_as_bright() -> None:
    """A card out of focus keeps its light."""
    sprite = motes.Sprite("image", image=GREY, blend="alpha", lit=True, facing="orientation")
    there = pixels(sprite, 60, focus=4.9, aperture=0.2)[24, 24]
    light = (BOUNCE + SKY) / 2 + 60 / 16
    assert there == pytest.approx(LINEAR * np.array(COLOR) * light, abs=0.012)
