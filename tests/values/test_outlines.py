"""Letters and pictures as meshes: sizes, areas, colours, insides; what is refused."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageFont
from standing import on_ranks

import motes
from motes.errors import ArgumentError, MissingExtraError
from motes.shapes import Picture, Text

SIDE = 64


def spans(mesh: motes.Mesh) -> tuple[np.ndarray, np.ndarray]:
    return mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)


@pytest.fixture(scope="module")
def disc(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Save a disc, red on the left and blue on the right, on a transparent background."""
    y, x = (np.mgrid[:SIDE, : 2 * SIDE] + 0.5) - np.array((SIDE / 2, SIDE))[:, None, None]
    pixels = np.zeros((SIDE, 2 * SIDE, 4), np.uint8)
    pixels[:, :SIDE, 0] = pixels[:, SIDE:, 2] = 255
    pixels[:, :, 3] = 255 * np.clip(20 - np.hypot(x, y) + 0.5, 0, 1)
    path = tmp_path_factory.mktemp("pictures") / "disc.png"
    Image.fromarray(pixels).save(path)
    return path


@pytest.mark.parametrize(("text", "height"), [("motes", 0.3), ("I", 2.0), ("two\nlines", 1.0), ("Øgé!", 1.0)])
def test_letters_are_as_high_as_told_and_centred(text: str, height: float):
    low, high = spans(Text(text, height))
    assert high[1] - low[1] == pytest.approx(height, rel=1e-5)
    np.testing.assert_allclose(low + high, 0, atol=1e-5)
    assert low[2] == high[2] == 0


def test_an_i_is_a_bar_and_letters_stand_in_order():
    bar = Text("I", 2)
    low, high = spans(bar)
    assert bar.measure == pytest.approx((high - low)[0] * 2, rel=0.02)
    # A full stop, then a bar: the dot is at the lower left.
    dot = Text(".I", 2).vertices
    assert (dot[dot[:, 0] < dot[:, 0].min() + 0.1][:, 1] < -0.6).all()
    points = Text("L", 1).sample(4000, seed=1)
    assert (points[:, 1] < -0.35).mean() > 0.25, "an L is heavy below: not upside down"
    left = points[:, 0] < points[:, 0].min() + 0.2
    assert left.mean() > 0.5, "and on the left: not mirrored"


def test_flat_letters_face_the_viewer():
    mesh = Text("motes", 1)
    a, b, c = np.float64(mesh.vertices)[mesh.triangles].transpose(1, 0, 2)
    area = np.cross(b - a, c - a)[:, 2] / 2
    assert (area > 0).all() and area.sum() == pytest.approx(mesh.measure, rel=1e-5)


@pytest.mark.parametrize("text", ["motes", "8 &%", "O\nO"])
def test_letters_with_a_depth_are_closed_and_filled(text: str):
    flat, mesh = Text(text, 1), Text(text, 1, 0.25)
    assert mesh.measure == pytest.approx(0.25 * flat.measure, rel=1e-4) and mesh.solid
    points = mesh.sample(3000, seed=2)
    assert mesh.contains(points).all()
    assert abs(points[:, 2]).max() <= 0.126 and np.std(points[:, 2]) == pytest.approx(
        0.25 / 12**0.5, rel=0.05
    )
    holes = {"O\nO": (0, 0.28, 0)}
    if text in holes:
        assert not mesh.contains([holes[text], (0, -0.28, 0)]).any()


def test_a_pipe_is_no_font(tmp_path: Path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ArgumentError, match="font must be a TrueType"):
        Text("a", 1, font=tmp_path / "pipe")


def test_letters_of_a_font_file(tmp_path: Path):
    font = ImageFont.load_default(20)
    file = tmp_path / "some.ttf"
    file.write_bytes(font.font_bytes)
    assert Text("ab", 1, font=file) == Text("ab", 1) == Text("ab", 1, font=str(file))
    assert Text("ab", 1) != Text("ab", 1.01)
    for length, message in ((2000, "the font can draw"), (9, "font must be a TrueType")):
        file.write_bytes(font.font_bytes[:length])
        with pytest.raises(ArgumentError, match=message):
            Text("ab", 1, font=file)


def test_a_picture_becomes_its_opaque_part(disc: Path):
    mesh = Picture(disc, 4)
    low, high = spans(mesh)
    pixel = 4 / (2 * SIDE)
    np.testing.assert_allclose(
        (low, high), [(-20 * pixel, -20 * pixel, 0), (20 * pixel, 20 * pixel, 0)], atol=pixel / 4
    )
    assert mesh.measure == pytest.approx(np.pi * (20 * pixel) ** 2, rel=0.01)
    assert mesh.colors is not None
    left, right = mesh.colors[mesh.vertices[:, 0] < -pixel], mesh.colors[mesh.vertices[:, 0] > pixel]
    np.testing.assert_allclose(left, np.broadcast_to((1, 0, 0), left.shape), atol=1e-5)
    np.testing.assert_allclose(right, np.broadcast_to((0, 0, 1), right.shape), atol=1e-5)


def test_an_opaque_picture_becomes_its_bright_part(tmp_path: Path):
    ramp = np.broadcast_to(np.linspace(0, 255, 200).astype(np.uint8), (50, 200))
    Image.fromarray(np.ascontiguousarray(ramp)).save(tmp_path / "ramp.png")
    for threshold in (0.25, 0.5, 0.9):
        low, high = spans(Picture(tmp_path / "ramp.png", 2, threshold))
        assert low[0] == pytest.approx(2 * threshold - 1, abs=0.02) and high[0] == pytest.approx(1, abs=1e-6)
        np.testing.assert_allclose((low[1], high[1]), (-0.25, 0.25), atol=1e-6)
    whole = Picture(tmp_path / "ramp.png", 2, 0)
    assert whole.measure == pytest.approx(1, rel=5e-3)
    Image.fromarray(np.zeros((5, 5), np.uint8)).save(tmp_path / "black.png")
    with pytest.raises(ArgumentError, match="threshold must be lower"):
        Picture(tmp_path / "black.png", 2)


def test_a_large_picture_is_reduced(tmp_path: Path):
    pixels = np.zeros((900, 1501), np.uint8)
    pixels[300:600, 500:1000] = 255
    Image.fromarray(pixels).save(tmp_path / "large.png")
    mesh = Picture(tmp_path / "large.png", 1501)
    low, high = spans(mesh)
    np.testing.assert_allclose(low[:2], (500 - 750.5, 450 - 600), atol=1.6)
    np.testing.assert_allclose(high[:2], (1000 - 750.5, 450 - 300), atol=1.6)
    assert len(mesh.triangles) < 2 * 512 * 512 * 0.2


WRONG: list[tuple[Any, str]] = [
    (lambda: Text("", 1), "text must be"),
    (lambda: Text(" \n ", 1), "text must be"),
    (lambda: Text(7, 1), "text must be"),
    (lambda: Text("a", 0), "height must be above 0"),
    (lambda: Text("a", -1), "height"),
    (lambda: Text("a", "tall"), "height"),
    (lambda: Text("a", 1, -0.1), "depth"),
    (lambda: Text("a", 1, np.inf), "depth"),
    (lambda: Text("a", 1, font="no-such-font"), "font must be a TrueType"),
    (lambda: Text("a", 1, font="/"), "font must be a TrueType"),
    (lambda: Text("a", 1, font=3), "font must be a TrueType"),
    (lambda: Text("a", 1, font="a\0b"), "font must be a TrueType"),
    (lambda: Text("m" * 5000, 1), "text must be shorter"),
    (lambda: Text("\n".join("m" * 500), 1), "text must be shorter"),
    (lambda: Picture("none.png", 1), "path must be an existing file"),
    (lambda: Picture(__file__, 1), "path must be a picture"),
    (lambda: Picture(3, 1), "path must be a path"),
    (lambda: Picture(__file__, 0), "width must be above 0"),
    (lambda: Picture(__file__, 1, 1.5), "threshold"),
    (lambda: Picture(__file__, 1, "half"), "threshold"),
]


@pytest.mark.parametrize(("make", "message"), WRONG, ids=range(len(WRONG)))
def test_wrong_arguments_are_named(make: Any, message: str):
    with pytest.raises(ArgumentError, match=message):
        make()


def test_without_pillow_the_extra_is_named(monkeypatch: pytest.MonkeyPatch, disc: Path):
    monkeypatch.setitem(__import__("sys").modules, "PIL.Image", None)
    for make in (lambda: Text("a", 1), lambda: Picture(disc, 1)):
        with pytest.raises(MissingExtraError, match="image"):
            make()


BURST = """
import sys, motes
from motes.shapes import Picture, Text

world = motes.World(seed=1, dt=0.1, progress="off", roles="shared", space=(-1, 1))
s = world.system("letters")
with world:
    s.configure(velocity=(0, 0, 1))
    s.burst(Text("me", 1, 0.2), count=300)
    s.burst(Text("motes", 1 + float(sys.argv[2]) * world.rank), count=300)
    s.configure(color=motes.surface_color())
    s.burst(Picture(sys.argv[1], 2), count=300)
    s.move()
    world.step()
    digest = world.digest()
    if world.rank == 0:
        print(digest, flush=True)
"""


def test_the_same_births_on_any_ranks_and_other_fonts_are_noticed(disc: Path):
    one, three = (on_ranks(n, BURST, disc, 0) for n in (1, 3))
    assert one.lines == three.lines and len(one.lines) == 1
    differs = on_ranks(2, BURST, disc, 0.01)
    assert differs.code != 0 and "ScriptMismatchError" in differs.text
