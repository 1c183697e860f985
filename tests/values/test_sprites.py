"""Sprites as values: what they accept, and what they refuse at the call."""

from __future__ import annotations

import sys
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plain_values import INF, LEAF, NAN, equal_and_immutable

import motes
from motes.errors import ArgumentError, MissingExtraError


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
    allowed = "an existing file" if content is None else "a picture that can be read"
    with pytest.raises(ArgumentError, match=f"image must be {allowed}"):
        motes.Sprite("image", image=tmp_path / "leaf.png")


@pytest.mark.parametrize(("width", "height"), [(14_000, 14_000), (10_000, 10_000), (1, 8193)])
def test_a_path_to_a_picture_that_is_too_large_is_refused(tmp_path, width, height):
    """Pillow refuses more than 179 million pixels and warns above 89 million; here both are errors."""
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


def opened(path: Path, picture: Any, **options: Any) -> np.ndarray:
    picture.save(path, **options)
    image = motes.Sprite("image", image=path).image
    assert image is not None
    return image


@pytest.mark.parametrize(
    ("suffix", "array", "mode", "wanted"),
    [
        ("png", np.uint16([[65535, 300], [0, 20000]]), "I;16", [[255, 1], [0, 78]]),
        ("tif", np.uint16([[65535, 300], [0, 20000]]), "I;16", [[255, 1], [0, 78]]),
        ("tif", np.float32([[1, 0.5], [0, 0.25]]), "F", [[255, 128], [0, 64]]),
        ("png", np.uint8([[255, 1], [0, 78]]), "L", [[255, 1], [0, 78]]),
    ],
)
def test_one_channel_of_more_than_8_bits_is_scaled_by_its_range(tmp_path, suffix, array, mode, wanted):
    images = pytest.importorskip("PIL.Image")
    image = opened(tmp_path / f"grey.{suffix}", images.fromarray(array))
    np.testing.assert_array_equal(image, np.dstack([np.uint8(wanted)] * 3 + [np.full((2, 2), 255, np.uint8)]))


@pytest.mark.parametrize("depth", [16, 8])
def test_a_clear_grey_stays_clear(tmp_path, depth):
    def chunk(name: bytes, content: bytes) -> bytes:
        check = zlib.crc32(name + content).to_bytes(4, "big")
        return len(content).to_bytes(4, "big") + name + content + check

    rows = b"".join(b"\0" + value.to_bytes(depth // 8, "big") * 2 for value in (200, 0))
    head = (2).to_bytes(4, "big") * 2 + bytes([depth, 0, 0, 0, 0])
    chunks = [(b"IHDR", head), (b"tRNS", b"\0\xc8"), (b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    (tmp_path / "grey.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*one) for one in chunks))
    image = motes.Sprite("image", image=tmp_path / "grey.png").image
    assert image is not None and image[:, 0, 3].tolist() == [0, 255]
    assert image[1, 0, :3].tolist() == [0, 0, 0]


@pytest.mark.parametrize("orientation", range(1, 9))
def test_a_picture_is_turned_upright_as_its_exif_says(tmp_path, orientation):
    images = pytest.importorskip("PIL.Image")
    upright = np.zeros((2, 3, 3), np.uint8)
    upright[0], upright[0, 0] = (255, 0, 0), (255, 255, 255)
    stored = [
        *(upright, upright[:, ::-1], upright[::-1, ::-1], upright[::-1]),
        *(np.swapaxes(one, 0, 1) for one in (upright, upright[:, ::-1], upright[::-1, ::-1], upright[::-1])),
    ][orientation - 1]
    told = images.Exif()
    told[0x0112] = orientation
    image = opened(tmp_path / "turned.png", images.fromarray(np.ascontiguousarray(stored)), exif=told)
    np.testing.assert_array_equal(image[:, :, :3], upright)


@pytest.mark.parametrize(
    ("name", "picture", "message"),
    [
        ("a.tif", lambda images: images.new("I", (2, 2), 1000), "32-bit values.*have no known range"),
        ("a.tif", lambda images: images.new("F", (2, 2), 7.5), "its values must be within 0..1"),
        ("a.eps", lambda images: images.new("RGB", (2, 2)), ": PNG, JPEG, WEBP, TIFF, BMP"),
        ("a.ico", lambda images: images.new("RGB", (16, 16)), ": PNG, JPEG, WEBP"),
    ],
)
def test_pictures_without_a_range_and_other_formats_are_refused(tmp_path, name, picture, message):
    images = pytest.importorskip("PIL.Image")
    picture(images).save(tmp_path / name)
    with pytest.raises(ArgumentError, match=f"image must be a picture that can be read.*{message}"):
        motes.Sprite("image", image=tmp_path / name)


def test_a_path_needs_pillow(monkeypatch):
    monkeypatch.setitem(sys.modules, "PIL.Image", None)
    with pytest.raises(MissingExtraError, match=r"Pillow.*\.\[image\]"):
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
        ({"kind": "image", "image": np.full((4, 4, 4), 1.5, np.float32)}, "image"),
        ({"kind": "image", "image": np.zeros((1, 9000, 4), np.uint8)}, "image"),
        ({"kind": "image", "image": [[1, 2], [3]]}, "image"),
        ({"kind": "image", "image": 7}, "image"),
    ],
)
def test_what_is_no_sprite_is_refused_at_the_call(arguments, name):
    with pytest.raises(ArgumentError, match=f"^{name} must be"):
        motes.Sprite(**arguments)
