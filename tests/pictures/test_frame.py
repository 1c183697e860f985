"""Frames: pixels on the image generator, none elsewhere; and the image files they write."""

from __future__ import annotations

import hashlib
import pathlib
import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from motes import _core
from motes._io import png
from motes._picture.frame import Frame
from motes.errors import ArgumentError, MissingExtraError, MotesError, NotHereError


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
    """Decode a PNG of the two kinds we write, by the PNG specification."""
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
    assert kind in ([8, 2, 0, 0, 0], [16, 2, 0, 0, 0])
    rows = np.frombuffer(zlib.decompress(chunks[2][1]), np.uint8).reshape(height, -1)
    assert not rows[:, 0].any()
    samples = np.ascontiguousarray(rows[:, 1:]).view(np.uint8 if kind[0] == 8 else ">u2")
    return samples.reshape(height, width, 3)


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
        with pytest.raises(NotHereError, match="live on rank 0, the image generator; this is rank 2"):
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


# --- 16 bits


@pytest.fixture
def light():
    """Return linear light from the darkest that 16 bits resolve to far above white."""
    return np.geomspace(1e-7, 1e3, 64 * 33 * 3, dtype=np.float32).reshape(64, 33, 3)


def shown(light: np.ndarray) -> np.ndarray:
    """Return the screen values of light, 0..1: the tone curve and sRGB, in double precision."""
    over = np.maximum(light - 0.5, 0) / 0.5
    rolled = np.where(light <= 0.5, light, 0.5 + 0.5 * (1 - 1 / np.sqrt(1 + 2 * over)))
    return np.where(rolled <= 0.0031308, 12.92 * rolled, 1.055 * rolled ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize("exposure", [1, 0.25, 8])
def test_png_with_16_bits_has_the_curve_and_not_the_8_bits(tmp_path, light, exposure):
    pixels = np.zeros(light.shape, np.uint8)
    frame = Frame(0, 0.0, pixels, linear=lambda: light, exposure=exposure)
    frame.save(tmp_path / "a.png", bits=16)
    read = decoded((tmp_path / "a.png").read_bytes()).astype(int)
    assert np.abs(read - shown(light.astype(float) * exposure) * 65535).max() <= 1
    assert len(np.unique(read)) > 3000
    frame.save(tmp_path / "b.png")
    assert not decoded((tmp_path / "b.png").read_bytes()).any()


def test_png_with_16_bits_is_read_by_others(tmp_path, light):
    av = pytest.importorskip("av")
    Frame(0, 0.0, np.zeros(light.shape, np.uint8), linear=lambda: light).save(tmp_path / "a.png", bits=16)
    with av.open(str(tmp_path / "a.png")) as container:
        read = next(container.decode(video=0))
        assert read.format.name == "rgb48be"
        assert np.array_equal(read.to_ndarray(), _core.tone_16_bits(light, 1))


def test_16_bits_and_exr_need_the_linear_picture_on_all_ranks(tmp_path, frame, elsewhere):
    for one in (frame, elsewhere):
        for name, bits in (("a.png", 16), ("a.exr", 8)):
            with pytest.raises(MotesError, match=r"no linear picture.*Renderer\(linear=True\)"):
                one.save(tmp_path / name, bits=bits)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("name", "bits"), [("a.png", 12), ("a.npy", 16), ("a.exr", 16), ("a.png", 8.0)])
def test_other_bits_are_refused_on_every_rank(tmp_path, frame, elsewhere, name, bits):
    for one in (frame, elsewhere):
        with pytest.raises(ArgumentError, match="bits must be"):
            one.save(tmp_path / name, bits=bits)


# --- layers, and the files that hold them


@pytest.fixture
def layered(light):
    height, width, _ = light.shape
    depth = np.full((height, width), np.inf)
    depth[10:20] = 12.3456
    layers = {
        "depth": lambda: depth,
        "alpha": lambda: np.full((height, width), 0.25),
        "velocity": lambda: np.broadcast_to([1.5, -2, 0], light.shape),
    }
    return Frame(7, 0.0, np.zeros(light.shape, np.uint8), linear=lambda: light, layers=layers)


def test_a_layer_is_made_once_and_on_request(layered):
    assert layered.layer("depth").shape == (64, 33)
    assert layered.layer("depth").dtype == np.float32
    assert layered.layer("depth") is layered.layer("depth")
    assert layered.layer("velocity")[3, 4].tolist() == [1.5, -2, 0]


def test_an_unknown_layer_is_refused_and_the_message_says_which_there_are(layered, frame):
    with pytest.raises(
        ArgumentError, match=r"'depth', 'alpha', 'velocity', got 'dept'; did you mean 'depth'"
    ):
        layered.layer("dept")
    with pytest.raises(ArgumentError, match=r"but it has none: request them with Renderer\(layers=...\)"):
        frame.layer("depth")
    with pytest.raises(ArgumentError, match="name must be"):
        layered.layer(None)


def test_elsewhere_a_layer_is_not_here():
    elsewhere = Frame(120, 5.0, None, layers={"depth": lambda: []}, home=0, rank=2)
    with pytest.raises(NotHereError, match="live on rank 0"):
        elsewhere.layer("depth")
    with pytest.raises(ArgumentError, match="one of the renderer's layers: 'depth'"):
        elsewhere.layer("alpha")


def test_a_layer_of_another_size_is_an_error(pixels):
    with pytest.raises(MotesError, match=r"layer 'depth' of frame 0 is \(2, 2\), not \(5, 7\)"):
        Frame(0, 0.0, pixels, layers={"depth": lambda: np.zeros((2, 2))}).layer("depth")


def test_exr_is_read_by_others(tmp_path, pixels):
    av = pytest.importorskip("av")
    linear = np.random.default_rng(3).random((5, 7, 3), np.float32) * 100
    Frame(0, 0.0, pixels, linear=lambda: linear).save(tmp_path / "a.exr")
    with av.open(str(tmp_path / "a.exr")) as container:
        picture = next(container.decode(video=0))
        # Older releases convert the half floats in the file to float32.
        number = {"gbrpf16le": np.float16, "gbrpf32le": np.float32}[picture.format.name]
        green, blue, red = (np.frombuffer(plane, number) for plane in picture.planes)
        row = picture.planes[0].line_size // np.dtype(number).itemsize
    for read, i in ((red, 0), (green, 1), (blue, 2)):
        assert np.array_equal(read.reshape(5, row)[:, :7], linear[:, :, i].astype(np.float16))


def test_exr_has_half_floats_and_all_layers_and_is_compressed(tmp_path, layered, light):
    library = pytest.importorskip("OpenEXR")
    layered.save(tmp_path / "a.exr")
    with library.File(str(tmp_path / "a.exr"), separate_channels=True) as file:
        assert file.header()["compression"] == library.ZIP_COMPRESSION
        read = {name: channel.pixels for name, channel in file.channels().items()}
    floats = {name: pixels.dtype.itemsize for name, pixels in read.items()}
    velocity = {f"velocity.{axis}": 2 for axis in "XYZ"}
    assert floats == {"R": 2, "G": 2, "B": 2, "A": 2, "depth.Z": 4, "alpha.A": 2, **velocity}
    for i, name in enumerate("RGB"):
        assert np.array_equal(read[name], light[:, :, i].astype(np.float16))
    assert np.array_equal(read["depth.Z"], layered.layer("depth"))
    assert (read["velocity.Y"] == -2).all()
    assert (tmp_path / "a.exr").stat().st_size < 64 * 33 * 6 * 2
    assert [path.name for path in tmp_path.iterdir()] == ["a.exr"]


def test_exr_shows_what_is_brighter_than_a_half_float_as_the_brightest(tmp_path):
    library = pytest.importorskip("OpenEXR")
    light = np.full((2, 2, 3), 1e6, np.float32)
    Frame(0, 0.0, np.zeros((2, 2, 3), np.uint8), linear=lambda: light).save(tmp_path / "a.exr")
    with library.File(str(tmp_path / "a.exr")) as file:
        assert (file.channels()["RGB"].pixels == 65504).all()


def test_an_exr_that_cannot_be_written_leaves_the_old_one(tmp_path, layered, monkeypatch):
    library = pytest.importorskip("OpenEXR")
    layered.save(tmp_path / "a.exr")
    before = (tmp_path / "a.exr").read_bytes()

    class Full:
        def __init__(self, header, channels): ...
        def __enter__(self):
            return self

        def __exit__(self, *_): ...
        def write(self, path):
            pathlib.Path(path).write_bytes(b"half a picture")
            raise RuntimeError("disk full")

    monkeypatch.setattr(library, "File", Full)
    with pytest.raises(RuntimeError, match="disk full"):
        layered.save(tmp_path / "a.exr")
    assert (tmp_path / "a.exr").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["a.exr"]


def test_exr_without_its_library_says_how_to_install_it_on_every_rank(layered, elsewhere, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    for one in (layered, elsewhere):
        with pytest.raises(MissingExtraError, match=r"as .exr needs OpenEXR.*\.\[exr\]"):
            one.save("a.exr")


@pytest.mark.parametrize("path", ["a\0b.png", "\ud800.png"])
def test_names_that_no_file_can_have_are_refused_on_every_rank(frame, elsewhere, path):
    for each in (frame, elsewhere):
        with pytest.raises(ArgumentError, match="path must be a path"):
            each.save(path)


def test_an_unknown_suffix_is_refused_on_every_rank(tmp_path, frame, elsewhere):
    for one in (frame, elsewhere):
        with pytest.raises(
            ArgumentError, match=r"must be a name ending in .png, .jpg, .webp, .exr or .npy, got"
        ):
            one.save(tmp_path / "a.tiff")


@pytest.mark.parametrize("suffix", [".jpg", ".JPEG", ".webp"])
def test_pictures_for_the_web(suffix: str, tmp_path, elsewhere):
    rows, columns = np.mgrid[:60, :80]
    pixels = np.stack([3 * columns, 4 * rows, 255 - 3 * columns], axis=2).astype(np.uint8)
    Frame(0, 0.0, pixels).save(tmp_path / f"a{suffix}")
    elsewhere.save(tmp_path / f"b{suffix}")  # touches no file
    assert [path.name for path in tmp_path.iterdir()] == [f"a{suffix}"]
    picture = Image.open(tmp_path / f"a{suffix}")
    assert picture.format == ("WEBP" if suffix == ".webp" else "JPEG")
    error = np.abs(np.asarray(picture.convert("RGB")).astype(int) - pixels)
    assert error.max() == 0 if suffix == ".webp" else error.max() < 12 and error.mean() < 1.5
    with pytest.raises(ArgumentError, match="only for a name ending in .png"):
        elsewhere.save(tmp_path / f"b{suffix}", bits=16)
