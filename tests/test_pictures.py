"""What a renderer's attributes do to a picture."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import motes
from motes.errors import ArgumentError

CAMERA = motes.Camera((0, 0, 5), (0, 0, 0))


def rendered(*, sprite: motes.Sprite | None = None, **attributes: Any) -> motes.Frame:
    """One particle in the middle of a picture."""
    renderer = motes.Renderer(**{"width": 96, "height": 64, "camera": CAMERA, "linear": True, **attributes})
    world = motes.World(seed=1, renderer=renderer, progress="off")
    system = world.system("a", sprite=sprite or motes.Sprite(pixels=9))
    with world:
        system.burst((0, 0, 0), count=1)
        return world.render()


# --- bloom


def test_bloom_spreads_light_and_keeps_it():
    sharp, soft = rendered().linear, rendered(bloom=0.3).linear
    assert soft.sum() == pytest.approx(sharp.sum(), rel=1e-3)
    assert soft.max() < sharp.max()
    assert (soft > 0).sum() > 2 * (sharp > 0).sum()
    assert np.array_equal(soft, rendered(bloom=0.3).linear)


def test_pixels_with_bloom_are_the_same_whether_their_light_is_kept_or_not():
    assert rendered(bloom=0.3, linear=False).digest() == rendered(bloom=0.3).digest() != rendered().digest()


@pytest.mark.parametrize("bloom", [-0.1, 1.1, float("nan"), "much", None])
def test_bloom_is_a_part(bloom):
    with pytest.raises(ArgumentError, match="bloom must be a"):
        motes.Renderer(96, 64, camera=CAMERA, bloom=bloom)


def test_bloom_may_change_between_frames():
    renderer = motes.Renderer(96, 64, camera=CAMERA)
    renderer.bloom = 0.5
    with pytest.raises(ArgumentError, match="bloom"):
        renderer.bloom = 2
    assert renderer.bloom == 0.5
