"""Frames: pixels on the image generator, nothing elsewhere; and the pictures they write."""

from __future__ import annotations

import hashlib
import struct
import zlib

import numpy as np
import pytest

from motes._io import png
from motes.errors import ArgumentError, MotesError, NotHere
from motes.frame import Frame


@pytest.fixture
def pixels():
    return np.random.default_rng(1).integers(0, 256, (5, 7, 3), np.uint8)


@pytest.fixture
def frame(pixels):
    return Frame(120, 5.0, pixels)


@pytest.fixture
def elsewhere():
    return Frame(120, 5.0, None, home=0, rank=2)


def decoded(data: bytes) -> np.ndarray:
    """Read a PNG of the one kind we write, by the format's own page."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    position, chunks = 8, []
    while position < len(data):
        (length,) = struct.unpack_from(">I", data, position)
        name, body = data[position + 4 : position + 8], data[position + 8 : position + 8 + length]
        (check,) = struct.unpack_from(">I", data, position + 8 + length)
        assert check == zlib.crc32(name + body)
        chunks.append((name, body))
        position += 12 + length
    assert [name for name, _ in chunks] == [b"IHDR", b"sRGB", b"IDAT", b"IEND"]
    width, height, *kind = struct.unpack(">2I5B", chunks[0][1])
    assert kind == [8, 2, 0, 0, 0]
    rows = np.frombuffer(zlib.decompress(chunks[2][1]), np.uint8).reshape(height, 1 + 3 * width)
    assert not rows[:, 0].any()
    return rows[:, 1:].reshape(height, width, 3)


def test_pixels_are_the_array_given_and_cannot_be_changed(frame, pixels):
    assert (frame.index, frame.time, bool(frame)) == (120, 5.0, True)
    assert np.shares_memory(frame.pixels, pixels)
    with pytest.raises(ValueError, match="read-only"):
        frame.pixels[0, 0, 0] = 1
    assert pixels.flags.writeable
    assert repr(frame) == "<Frame 120 7x5>"


def test_numpy_takes_it_without_a_copy_unless_asked(frame, pixels):
    assert np.shares_memory(np.asarray(frame), pixels)
    assert not np.shares_memory(np.array(frame), pixels)
    assert np.array_equal(np.asarray(frame, np.float32), pixels.astype(np.float32))
    with pytest.raises(ValueError, match="copied"):
        frame.__array__(np.float32, copy=False)


@pytest.mark.parametrize(
    "wrong", [np.zeros((4, 4), np.uint8), np.zeros((4, 4, 3)), np.zeros((0, 4, 3), np.uint8)]
)
def test_only_pictures_are_taken(wrong):
    with pytest.raises(ArgumentError, match="pixels must be uint8"):
        Frame(0, 0.0, wrong)


def test_digest_is_of_shape_and_pixels(frame, pixels):
    assert frame.digest() == hashlib.sha256(b"5x7x3\n" + pixels.tobytes()).hexdigest()
    turned = Frame(0, 0.0, pixels.reshape(7, 5, 3))
    assert turned.digest() != frame.digest()
    assert Frame(3, 1.0, np.asfortranarray(pixels)).digest() == frame.digest()


def test_elsewhere_a_frame_is_nothing(elsewhere, tmp_path):
    assert not elsewhere
    assert repr(elsewhere) == "<Frame 120 on rank 0>"
    assert elsewhere._repr_png_() is None
    elsewhere.save(tmp_path / "a.png")
    assert not list(tmp_path.iterdir())
    for ask in (
        lambda: elsewhere.pixels,
        lambda: elsewhere.linear,
        elsewhere.digest,
        lambda: np.asarray(elsewhere),
    ):
        with pytest.raises(NotHere, match="live on rank 0, the image generator; this is rank 2"):
            ask()


def test_linear_is_made_once_and_on_request(pixels):
    made = []

    def linear():
        made.append(1)
        return pixels / 255

    frame = Frame(0, 0.0, pixels, linear=linear)
    assert not made
    assert frame.linear.dtype == np.float32
    assert frame.linear is frame.linear
    assert len(made) == 1


def test_a_missing_linear_picture_is_said_in_a_sentence(frame):
    with pytest.raises(MotesError, match="frame 120 has no linear picture"):
        _ = frame.linear


@pytest.mark.parametrize("shape", [(5, 7, 3), (1, 1, 3), (64, 33, 3)])
def test_png(tmp_path, shape):
    pixels = np.random.default_rng(2).integers(0, 256, shape, np.uint8)
    Frame(0, 0.0, pixels).save(tmp_path / "a.png")
    data = (tmp_path / "a.png").read_bytes()
    assert np.array_equal(decoded(data), pixels)
    assert Frame(0, 0.0, pixels)._repr_png_() == data


def test_png_is_read_by_others(tmp_path, frame):
    av = pytest.importorskip("av")
    frame.save(tmp_path / "a.png")
    with av.open(str(tmp_path / "a.png")) as container:
        read = next(container.decode(video=0)).to_ndarray(format="rgb24")
    assert np.array_equal(read, frame.pixels)


def test_png_refuses_what_is_no_picture():
    with pytest.raises(ValueError, match="uint8"):
        png.encode(np.zeros((4, 4, 3), np.float32))


def test_npy(tmp_path, frame):
    frame.save(tmp_path / "a.npy")
    assert np.array_equal(np.load(tmp_path / "a.npy"), frame.pixels)


def test_exr_is_read_by_others(tmp_path, pixels):
    av = pytest.importorskip("av")
    linear = np.random.default_rng(3).random((5, 7, 3), np.float32) * 100
    Frame(0, 0.0, pixels, linear=lambda: linear).save(tmp_path / "a.exr")
    with av.open(str(tmp_path / "a.exr")) as container:
        read = next(container.decode(video=0))
        assert read.format.name == "gbrpf32le"
        assert np.array_equal(read.to_ndarray(), linear)


def test_an_unknown_suffix_is_refused_on_every_rank(tmp_path, frame, elsewhere):
    for one in (frame, elsewhere):
        with pytest.raises(ArgumentError, match=r"must be a name ending in .png, .npy or .exr, got"):
            one.save(tmp_path / "a.jpg")
