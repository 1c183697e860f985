"""What a lens, an open shutter and eight bits do to a picture: the same to all kinds, on all paths."""

from __future__ import annotations

import numpy as np

import motes
from motes import shapes


def film(drawn_from: int) -> str:
    """Return the digest of a panning film's sixth picture, with pictures from a frame on."""
    camera = motes.Camera(motes.Curve([(0, (-3, 1, 5)), (0.25, (3, 1, 5))]), (0, 0, 0))
    renderer = motes.Renderer(160, 90, camera=camera, background=(0.02, 0.02, 0.05), shutter=1)
    world = motes.World(seed=1, progress="off", renderer=renderer)
    system = world.system("s", sprite=motes.Sprite("disc", pixels=5))
    with world:
        for frame in world.frames(6):
            if frame == 0:
                system.burst(shapes.Sphere((0, 0, 0), 1.2), count=100)
            system.move()
            picture = world.render() if frame >= drawn_from else world.step()
        return picture.digest()


def test_streaks_after_frames_without_a_picture_begin_at_the_camera_of_the_frame_before() -> None:
    assert film(5) == film(3) == film(0)


def test_a_dark_gradient_is_dithered_on_average_as_the_light_says() -> None:
    sky = motes.Gradient((0.02, 0.03, 0.07), (0.002, 0.003, 0.01), (0.01, 0.01, 0.015))
    camera = motes.Camera((0, 1, 5), (0, 1.2, 0))
    renderer = motes.Renderer(320, 180, camera=camera, background=sky, linear=True)
    world = motes.World(seed=1, progress="off", renderer=renderer)
    world.system("s")
    with world:
        picture = world.render()
    light = picture.linear.astype(float)
    wanted = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055) * 255
    error = picture.pixels - wanted
    assert np.abs(error).max() < 1
    blocks = error[:176].reshape(11, 16, 20, 16, 3).mean((1, 3))  # rounding alone is off by up to half a step
    assert np.abs(blocks).max() < 0.12
