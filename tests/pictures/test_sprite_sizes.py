"""Sizes in metres and as fractions of the height, and light independent of resolution and motion."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import motes
from motes.shapes import Sphere

FOV = 40.0


def light(
    sprite: motes.Sprite,
    height: int = 360,
    *,
    distance: float = 5,
    velocity: tuple[float, ...] = (0, 0, 0),
    count: int = 1,
    size: Any = (1, 1, 1),
    spread: float = 0,
    **attributes: Any,
) -> NDArray[np.float32]:
    """Return the linear picture of particles around the centre."""
    camera = motes.Camera((0, 0, distance), (0, 0, 0), fov_deg=FOV)
    renderer = motes.Renderer(height * 16 // 9, height, camera=camera, linear=True, **attributes)
    world = motes.World(seed=3, dt=1 / 24, renderer=renderer, progress="off")
    system = world.system("a", sprite=sprite)
    with world:
        system.configure(size=size, velocity=velocity, alpha=0.1)
        system.burst(Sphere((0, 0, 0), spread) if spread else (0, 0, 0), count=count)
        linear = world.render().linear
    assert linear is not None
    return linear


def test_a_camera_that_moves_draws_streaks():
    def lit(step: float) -> int:
        camera = motes.Camera((0, 0, 5), (0, 0, 0))
        renderer = motes.Renderer(320, 180, camera=camera, shutter=1)
        world = motes.World(seed=3, renderer=renderer, progress="off")
        system = world.system("a", sprite=motes.Sprite(pixels=3))
        with world:
            system.burst((0, 0, 0), count=1)
            world.render()
            camera.position = (step, 0, 5)
            camera.look_at = (step, 0, 0)
            return int((world.render().pixels.max(axis=2) > 0).sum())

    assert lit(0) == lit(0) < lit(0.1) < lit(0.5)


# --- images that are small, thin or fast

WIDTH = 400


def a_picture_of(sprite: motes.Sprite, *, streak: float = 0, width: int = WIDTH) -> NDArray[Any]:
    """Return the light of one particle; its streak, `streak` pixels long, is centred in the picture."""
    camera = motes.Camera((0, 0, 5), (0, 0, 0), fov_deg=2 * math.degrees(math.atan(32 / 100)))
    renderer = motes.Renderer(width, 64, camera=camera, linear=True, shutter=1 if streak else 0)
    world = motes.World(seed=1, dt=1, renderer=renderer, progress="off")
    system = world.system("one", sprite=sprite)
    with world:
        system.emit(position=[(0.004 - streak / 40, 0.013, 0)], velocity=[(streak / 20, 0, 0)])
        system.move()
        return world.render().linear[:, :, 0]


def square(size: int, **cut: slice) -> NDArray[Any]:
    pixels = np.zeros((size, size, 4), np.uint8)
    pixels[cut.get("rows", slice(None)), cut.get("columns", slice(None))] = 255
    return pixels


@pytest.mark.parametrize(("pixels", "streak"), [(2, 150), (5, 300), (5, 1500), (40, 100)])
def test_the_streak_of_an_image_is_even(pixels, streak):
    light = a_picture_of(motes.Sprite("image", pixels, image=square(8)), streak=streak)
    reach = min(WIDTH, streak) // 2 - pixels
    columns = light.sum(0, dtype=float)[WIDTH // 2 - reach : WIDTH // 2 + reach]
    np.testing.assert_allclose(columns, pixels**2 / streak, rtol=0.03)


@pytest.mark.parametrize("streak", [30, 150, 1200])
def test_an_opaque_image_covers_its_way_for_a_part_of_the_time(streak):
    image = motes.Sprite("image", 8, "opaque", image=square(8))
    light = a_picture_of(image, streak=streak).sum(0, dtype=float)
    middle = slice(WIDTH // 2 - min(150, streak // 4), WIDTH // 2 + min(150, streak // 4))
    assert light[middle].mean() == pytest.approx(64 / streak, rel=0.1)
    if streak < WIDTH:  # longer ones are cut where they leave the picture
        inner = a_picture_of(image, streak=streak, width=WIDTH // 2)
        assert np.array_equal(inner, a_picture_of(image, streak=streak)[:, WIDTH // 4 : -WIDTH // 4])


@pytest.mark.parametrize("pixels", [2, 3, 5, 12, 40])
@pytest.mark.parametrize("rows", [slice(30, 34), slice(16, 48)])
def test_opaque_images_do_not_vanish_where_they_are_small(pixels, rows):
    """The image covers only part of its square: a bar across the middle."""
    light = a_picture_of(motes.Sprite("image", pixels, "opaque", image=square(64, rows=rows)))
    assert light.max() > 0.99, "as bright as the picture"
    assert light[light > 0].min() > 0.99
    assert np.count_nonzero(light.any(0)) >= min(pixels - 1, 2), "as long as it is"
    assert np.count_nonzero(light.any(1)) <= max(2, pixels / 2 + 1)


def test_what_is_less_than_half_opaque_is_no_surface():
    faint = square(8) // 3
    assert not a_picture_of(motes.Sprite("image", 9, "opaque", image=faint)).any()


@pytest.mark.parametrize("kind", ["disc", "sphere", "image"])
@pytest.mark.parametrize("shutter", [0, 0.5])
def test_a_particle_has_the_same_share_of_the_picture_at_any_resolution(kind: str, shutter: float) -> None:
    picture = np.full((8, 8, 4), 255, np.uint8) if kind == "image" else None
    sizes: list[dict[str, Any]] = [{"pixels": None}, {"height": 0.6}]
    for size in sizes:
        sprite = motes.Sprite(kind, image=picture, blend="alpha", **size)
        near = {"distance": 2, "size": (0.9, 1, 1), "shutter": shutter, "velocity": (0.3, 0, 0)}
        small, large = (light(sprite, height, **near).sum((0, 1)) / height**2 for height in (360, 1440))
        np.testing.assert_allclose(large, small, rtol=0.01)
