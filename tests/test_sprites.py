"""Sprites as values: what they take, and what they refuse at the call."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from plain_values import INF, LEAF, NAN, equal_and_immutable

import motes
from motes.errors import ArgumentError, MissingExtra


@pytest.mark.parametrize(
    "arguments",
    [
        {},
        {"kind": "point"},
        {"kind": "sphere", "pixels": None, "blend": "opaque"},
        {"kind": "disc", "pixels": 512, "blend": "alpha", "softness": 0.3},
        {"height": 0.01},
        {"kind": "image", "image": LEAF},
    ],
)
def test_sprites_are_values(arguments):
    equal_and_immutable(motes.Sprite(**arguments), motes.Sprite(**arguments))
    assert motes.Sprite(**arguments) != motes.Sprite("disc", 7)


def test_an_image_is_a_copy_that_nobody_changes():
    pixels = LEAF.copy()
    sprite = motes.Sprite("image", image=pixels)
    pixels[0, 0] = 99
    assert np.array_equal(sprite.image, LEAF)
    assert sprite != motes.Sprite("image", image=pixels)
    with pytest.raises(ValueError, match="read-only"):
        sprite.image[0, 0] = 1
    assert repr(sprite) == "Sprite(kind='image', image=<6x4 pixels>)"


def test_an_image_without_alpha_is_opaque():
    whole = LEAF.copy()
    whole[:, :, 3] = 255
    assert motes.Sprite("image", image=LEAF[:, :, :3]) == motes.Sprite("image", image=whole)


def test_an_image_may_be_a_path(tmp_path):
    images = pytest.importorskip("PIL.Image")
    images.fromarray(LEAF, "RGBA").save(tmp_path / "leaf.png")
    assert motes.Sprite("image", image=tmp_path / "leaf.png") == motes.Sprite("image", image=LEAF)
    assert motes.Sprite("image", image=str(tmp_path / "leaf.png")).image.shape == (4, 6, 4)


@pytest.mark.parametrize("content", [None, b"", b"no picture", b"\x89PNG\r\n\x1a\n"])
def test_a_path_without_a_picture_is_refused(tmp_path, content):
    pytest.importorskip("PIL.Image")
    if content is not None:
        (tmp_path / "leaf.png").write_bytes(content)
    with pytest.raises(ArgumentError, match="image must be a picture that can be read"):
        motes.Sprite("image", image=tmp_path / "leaf.png")


@pytest.mark.parametrize(("width", "height"), [(14_000, 14_000), (10_000, 10_000), (1, 8193)])
def test_a_path_to_a_picture_that_is_too_large_is_refused(tmp_path, width, height):
    """Pillow refuses what is beyond 179 million pixels, and warns beyond 89 million: here an error."""
    images = pytest.importorskip("PIL.Image")
    images.new("1", (width, height)).save(tmp_path / "wide.png")
    with pytest.raises(ArgumentError, match=r"image must be a picture of 1\.\.8192 pixels") as caught:
        motes.Sprite("image", image=tmp_path / "wide.png")
    assert caught.value.value == str(tmp_path / "wide.png")


def test_pillows_warning_about_large_pictures_is_not_shown(tmp_path, monkeypatch):
    images = pytest.importorskip("PIL.Image")
    images.fromarray(LEAF, "RGBA").save(tmp_path / "leaf.png")
    monkeypatch.setattr(images, "MAX_IMAGE_PIXELS", LEAF.shape[0] * LEAF.shape[1] - 1)
    assert motes.Sprite("image", image=tmp_path / "leaf.png") == motes.Sprite("image", image=LEAF)


def test_a_path_needs_pillow(monkeypatch):
    monkeypatch.setitem(sys.modules, "PIL.Image", None)
    with pytest.raises(MissingExtra, match=r"Pillow.*\.\[image\]"):
        motes.Sprite("image", image="leaf.png")


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"kind": "disk"}, "kind"),
        ({"pixels": 0}, "pixels"),
        ({"pixels": 513}, "pixels"),
        ({"pixels": 2.5}, "pixels"),
        ({"pixels": NAN}, "pixels"),
        ({"height": 0}, "height"),
        ({"height": -0.1}, "height"),
        ({"height": NAN}, "height"),
        ({"height": 1.5}, "height"),
        ({"height": 0.1, "pixels": 9}, "height"),
        ({"height": 0.1, "pixels": None}, "height"),
        ({"blend": "over"}, "blend"),
        ({"softness": -1}, "softness"),
        ({"softness": NAN}, "softness"),
        ({"softness": INF}, "softness"),
        ({"softness": "soft"}, "softness"),
        ({"kind": "image"}, "image"),
        ({"kind": "disc", "image": LEAF}, "image"),
        ({"kind": "image", "image": np.zeros((0, 0, 4), np.uint8)}, "image"),
        ({"kind": "image", "image": np.zeros((4, 0, 4), np.uint8)}, "image"),
        ({"kind": "image", "image": np.zeros((4, 4), np.uint8)}, "image"),
        ({"kind": "image", "image": np.zeros((4, 4, 2), np.uint8)}, "image"),
        ({"kind": "image", "image": np.zeros((4, 4, 4), np.float32)}, "image"),
        ({"kind": "image", "image": np.zeros((1, 9000, 4), np.uint8)}, "image"),
        ({"kind": "image", "image": [[1, 2], [3]]}, "image"),
        ({"kind": "image", "image": 7}, "image"),
    ],
)
def test_what_is_no_sprite_is_refused_at_the_call(arguments, name):
    with pytest.raises(ArgumentError, match=f"^{name} must be"):
        motes.Sprite(**arguments)
