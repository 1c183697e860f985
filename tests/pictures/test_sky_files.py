"""Files of skies and textures: Radiance pictures, windows of OpenEXR, damaged files, and what is no file."""

from __future__ import annotations

import os
import threading
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import motes
from motes._io import hdr
from motes.errors import ArgumentError
from motes.shapes import Sphere

CAMERA = motes.Camera((0, 0, 5), (0, 0, 0))


def sky_of(path: Path) -> np.ndarray:
    return motes.Renderer(8, 8, camera=CAMERA, background=path).background.light


def shared_exponents(light: np.ndarray) -> np.ndarray:
    """Code linear light as mantissas with a shared exponent, uint8 (height, width, 4)."""
    _, exponent = np.frexp(light.max(axis=2))
    mantissa = np.floor(np.ldexp(light, 8 - exponent[:, :, None]))
    coded = np.concatenate([mantissa, (exponent + 128)[:, :, None]], axis=2)
    coded[light.max(axis=2) < 1e-32] = 0
    return coded.astype(np.uint8)


def by_channels(row: np.ndarray) -> bytes:
    """Code a row as runs, one channel after the other."""
    coded = bytearray([2, 2, *divmod(len(row), 256)])
    for channel in row.T:
        at = 0
        while at < len(channel):
            same = 1
            while same < 127 and at + same < len(channel) and channel[at + same] == channel[at]:
                same += 1
            if same > 2:
                coded += bytes([128 + same, channel[at]])
                at += same
            else:
                some = channel[at : at + min(5, len(channel) - at)].tobytes()
                coded += bytes([len(some)]) + some
                at += len(some)
    return bytes(coded)


def by_pixels(row: np.ndarray) -> bytes:
    """Code a row as pixels with repeats, the older form."""
    coded, at = bytearray(), 0
    while at < len(row):
        same = 1
        while at + same < len(row) and (row[at + same] == row[at]).all():
            same += 1
        coded += row[at].tobytes()
        rest = same - 1
        while rest:
            coded += bytes([1, 1, 1, rest % 256])
            rest //= 256
        at += same
    return bytes(coded)


def flat(row: np.ndarray) -> bytes:
    return row.tobytes()


def picture(rows: np.ndarray, code, *, ways: str = "-Y {0} +X {1}", more: str = "") -> bytes:
    head = f"#?RADIANCE\nSOFTWARE=a test\nFORMAT=32-bit_rle_rgbe\n{more}\n{ways.format(*rows.shape)}\n"
    return head.encode() + b"".join(map(code, rows))


@settings(max_examples=60, deadline=None)
@given(
    width=st.sampled_from([1, 7, 8, 9, 300]),
    height=st.integers(1, 4),
    coarse=st.sampled_from([1, 4, 100]),
    power=st.integers(-20, 18),
    code=st.sampled_from([by_channels, by_pixels, flat]),
    seed=st.integers(0, 99),
)
def test_radiance_pictures_are_read_as_they_were_coded(
    tmp_path_factory, width, height, coarse, power, code, seed
):
    if code is by_channels and width < 8:
        code = flat
    dice = np.random.default_rng(seed)
    light = np.repeat(dice.integers(1, 256, (height, width, 3)), coarse, axis=1)[:, :width] * 2.0**power
    light[dice.random((height, width)) < 0.1] = 0
    coded = shared_exponents(light)
    if code is by_pixels:
        coded[(coded[:, :, :3] == 1).all(axis=2)] = 0  # would be a repeat
    path = tmp_path_factory.mktemp("sky") / "sky.hdr"
    path.write_bytes(picture(coded, code))
    wanted = coded[:, :, :3] * np.ldexp(1.0, coded[:, :, 3:].astype(int) - 136)
    np.testing.assert_array_equal(hdr.read(path, 8192), wanted.astype(np.float32))


def test_rows_may_run_either_way_and_exposures_are_undone(tmp_path):
    light = np.arange(2 * 8 * 3).reshape(2, 8, 3) + 1.0
    coded = shared_exponents(light)
    for ways, turned in (
        ("-Y {0} +X {1}", light),
        ("+Y {0} +X {1}", light[::-1]),
        ("-Y {0} -X {1}", light[:, ::-1]),
    ):
        (tmp_path / "sky.pic").write_bytes(picture(coded, by_channels, ways=ways))
        np.testing.assert_array_equal(sky_of(tmp_path / "sky.pic"), turned)
    (tmp_path / "sky.hdr").write_bytes(picture(coded, flat, more="EXPOSURE=4\nEXPOSURE= .5\n"))
    np.testing.assert_array_equal(sky_of(tmp_path / "sky.hdr"), light / 2)


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "does not begin"),
        (b"GIF89a\n\n", "does not begin"),
        (b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n1234", "32-bit_rle_xyze"),
        (b"#?RADIANCE\n\n+X 1 -Y 1\n1234", "rows like"),
        (b"#?RADIANCE\n\n-Y 1\n1234", "rows like"),
        (b"#?RADIANCE\n\n-Y 1 +X 9000\n1234", "8192"),
        (b"#?RADIANCE\nEXPOSURE=0\n\n-Y 1 +X 1\n1234", "exposure"),
        (b"#?RADIANCE\n\n-Y 2 +X 2\n12341234", "ends in the middle"),
        (b"#?RADIANCE\n\n-Y 1 +X 8\n\2\2\0\x08\x82\1\0\3", "damaged"),
        (b"#?RADIANCE\n\n-Y 1 +X 8\n\2\2\0\x08\x88\1\x88", "ends in the middle"),
        (b"#?RADIANCE\n\n-Y 1 +X 8\n\2\2\0\x08\x89\1", "damaged"),
    ],
)
def test_damaged_radiance_pictures_are_refused(tmp_path, content, why):
    path = tmp_path / "sky.hdr"
    path.write_bytes(content)
    for use in (sky_of, lambda path: motes.Solid(Sphere((0, 0, 0), 1), image=path)):
        with pytest.raises(
            ArgumentError, match=f"(background|image) must be a whole .hdr picture.*{why}.*sky.hdr"
        ):
            use(path)


def write_exr(path: Path, pixels: np.ndarray, x: int, y: int, display: tuple[int, int, int, int]) -> None:
    library = pytest.importorskip("OpenEXR")
    height, width, _ = pixels.shape
    left, top, right, bottom = display
    header = {"compression": library.ZIP_COMPRESSION, "type": library.scanlineimage}
    header["dataWindow"] = ((x, y), (x + width - 1, y + height - 1))
    header["displayWindow"] = ((left, top), (right - 1, bottom - 1))
    with library.File(header, {"RGB": pixels.astype(np.float32)}) as file:
        file.write(str(path))


@settings(max_examples=25, deadline=None)
@given(x=st.integers(-12, 40), y=st.integers(-12, 30), width=st.integers(1, 40), height=st.integers(1, 30))
def test_pixels_of_an_exr_are_where_its_display_window_says(tmp_path_factory, x, y, width, height):
    pixels = np.random.default_rng(1).random((height, width, 3)).astype(np.float32)
    path = tmp_path_factory.mktemp("sky") / "sky.exr"
    write_exr(path, pixels, x, y, (2, 1, 34, 17))
    wanted = np.zeros((16, 32, 3), np.float32)
    for row in range(height):
        for column in range(width):
            at = (y + row - 1, x + column - 2)
            if 0 <= at[0] < 16 and 0 <= at[1] < 32:
                wanted[at] = pixels[row, column]
    np.testing.assert_array_equal(sky_of(path), wanted)


def test_a_display_window_too_large_for_memory_is_refused(tmp_path):
    write_exr(tmp_path / "sky.exr", np.ones((2, 2, 3)), 0, 0, (0, 0, 100_000, 100_000))
    with pytest.raises(ArgumentError, match="background.*100000x100000"):
        sky_of(tmp_path / "sky.exr")


def test_a_cut_exr_is_refused(tmp_path, capfd):
    whole = tmp_path / "whole.exr"
    write_exr(whole, np.random.default_rng(1).random((64, 128, 3)), 0, 0, (0, 0, 128, 64))
    content = whole.read_bytes()
    for part in (0, 10, 200, len(content) // 2, len(content) - 100):
        (tmp_path / "sky.exr").write_bytes(content[:part])
        for use in (sky_of, lambda path: motes.Solid(Sphere((0, 0, 0), 1), image=path)):
            with pytest.raises(
                ArgumentError, match="(background|image) must be a whole .exr picture.*sky.exr"
            ):
                use(tmp_path / "sky.exr")
    capfd.readouterr()  # OpenEXR prints some reasons itself


READERS = {
    "sky.png": sky_of,
    "sky.hdr": sky_of,
    "sky.exr": sky_of,
    "flake.png": lambda path: motes.Sprite("image", image=path),
    "flakes.jpg": lambda path: motes.Sprite("image", image=[path]),
    "wood.png": lambda path: motes.Solid(Sphere((0, 0, 0), 1), image=path),
    "stone.ply": motes.Mesh.load,
    "tints.png": lambda path: motes.Mesh(np.eye(3), [(0, 1, 2)], colors=path, uv=np.zeros((3, 2))),
    "dense.png": lambda path: motes.Mesh(np.eye(3), [(0, 1, 2)], density=path, uv=np.zeros((3, 2))),
}


@pytest.mark.parametrize("name", READERS)
def test_what_is_no_file_is_refused_at_once(tmp_path, name):
    """Opening a pipe that nobody writes to would wait for ever."""
    path = tmp_path / name
    with pytest.raises(ArgumentError, match=f"an existing file.*{name}"):
        READERS[name](path)
    path.mkdir()
    with pytest.raises(ArgumentError, match=f"a regular file.*{name}"):
        READERS[name](path)
    path.rmdir()
    os.mkfifo(path)
    ended = threading.Timer(20, lambda: os.close(os.open(path, os.O_WRONLY)))  # wakes who waits for a writer
    ended.start()
    try:
        with pytest.raises(ArgumentError, match=f"a regular file.*{name}"):
            READERS[name](path)
        assert ended.is_alive()
    finally:
        ended.cancel()


def test_pictures_by_position_and_colours_for_all_vertices():
    with pytest.raises(ArgumentError, match="pixels must be .* given by name: image=, mesh=, got 'rock.glb'"):
        motes.Sprite("mesh", "rock.glb")
    corners, faces = np.eye(3), [(0, 1, 2)]
    for color in ("gold", "#ff8800"):
        np.testing.assert_array_equal(
            motes.Mesh(corners, faces, colors=color).colors,
            motes.Mesh(corners, faces, colors=[color] * 3).colors,
        )
    with pytest.raises(ArgumentError, match="did you mean 'gold'"):
        motes.Mesh(corners, faces, colors="golld")
