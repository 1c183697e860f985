"""Sizes in metres and in parts of the height, and light that depends neither on resolution nor on motion."""

from __future__ import annotations

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
    """The linear picture of particles around the middle."""
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


@pytest.mark.parametrize("kind", ["disc", "sphere"])
@pytest.mark.parametrize("distance", [2, 5, 17, 60])
def test_sizes_in_metres_hold_at_any_distance(kind, distance):
    sprite = motes.Sprite(kind, pixels=None, blend="opaque")
    rows = (light(sprite, 720, distance=distance, size=(0.5, 0, 0)).sum(axis=2) > 0).any(axis=1).sum()
    expected = 0.5 / distance * 720 / (2 * np.tan(np.radians(FOV / 2)))
    assert rows == pytest.approx(expected, abs=1)  # half a pixel on each side


@pytest.mark.parametrize("sprite", [motes.Sprite(pixels=None), motes.Sprite(height=0.01)])
@pytest.mark.parametrize("size", [0.003, 0.02, 0.2])
def test_brightness_does_not_depend_on_the_resolution(sprite, size):
    scene = {"count": 3000, "spread": 1.5, "size": (size, 1, 1)}
    small, large = (light(sprite, height, **scene).mean() for height in (180, 1080))
    assert small == pytest.approx(large, rel=0.03)


@pytest.mark.parametrize("speed", [1, 5, 25])
@pytest.mark.parametrize("sprite", [motes.Sprite("point"), motes.Sprite(pixels=5), motes.Sprite(pixels=None)])
def test_streaks_keep_their_light(sprite, speed):
    still = light(sprite, size=(0.1, 0, 0))
    streak = light(sprite, size=(0.1, 0, 0), velocity=(speed, -speed / 2, 0), shutter=0.5)
    assert streak.sum() == pytest.approx(still.sum(), rel=0.01)
    assert (streak > 0).sum() > (still > 0).sum()


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
