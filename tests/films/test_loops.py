"""Films to show: .webm, loops as .gif and .webp, and films of at most so many kilobytes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from films import moving
from PIL import Image, ImageSequence

import motes
from motes import cli
from motes._film import growing
from motes.errors import ArgumentError, MotesError


def write(path: Path, count: int = 12, **options: Any) -> list[np.ndarray[Any, Any]]:
    """Write a film; return its pictures."""
    pictures = list(moving(count))
    with motes.Movie(path, **options) as movie:
        for picture in pictures:
            movie.write(picture)
    return [picture.pixels for picture in pictures]


def read(path: Path) -> tuple[list[np.ndarray[Any, Any]], float]:
    """Return a film's pictures and its length, s."""
    if path.suffix in (".gif", ".webp"):
        with Image.open(path) as film:
            assert film.info["loop"] == 0
            frames, length = [], 0.0
            for frame in ImageSequence.Iterator(film):
                frame.load()
                frames.append(np.asarray(frame.convert("RGB")).astype(float))
                length += frame.info["duration"] / 1000
            return frames, length
    with av.open(str(path)) as film:
        frames = [frame.to_ndarray(format="rgb24").astype(float) for frame in film.decode(video=0)]
        return frames, len(frames) / float(film.streams.video[0].average_rate)


@pytest.mark.parametrize(("suffix", "most"), [(".webm", 6), (".gif", 12), (".webp", 8)])
def test_films_to_show(suffix: str, most: float, tmp_path: Path) -> None:
    path = tmp_path / f"film{suffix}"
    pictures = write(path, fps=24)
    assert [one.name for one in tmp_path.iterdir()] == [path.name]
    frames, length = read(path)
    assert len(frames) == 12 and length == pytest.approx(12 / 24, abs=0.011)
    for got, wanted in zip(frames, pictures, strict=True):
        assert got.shape == wanted.shape
        assert np.abs(got - wanted).mean() < most


def test_a_loop_survives_a_kill_as_a_film_without_loss(tmp_path: Path) -> None:
    pictures = list(moving(30))
    with pytest.raises(ZeroDivisionError), motes.Movie(tmp_path / "a.gif") as movie:
        for picture in pictures:
            movie.write(picture)
        1 / 0  # noqa: B018
    partial = growing.partial_path(tmp_path / "a.gif")
    assert [one.name for one in tmp_path.iterdir()] == [partial.name] == ["a.partial.mkv"]
    with av.open(str(partial)) as film:
        for frame, picture in zip(film.decode(video=0), pictures, strict=False):
            assert (frame.to_ndarray(format="rgb24") == picture.pixels).all()


@pytest.mark.parametrize("suffix", [".mp4", ".webm", ".gif", ".webp"])
def test_kilobytes_are_kept(suffix: str, tmp_path: Path) -> None:
    write(tmp_path / f"whole{suffix}")
    size = (tmp_path / f"whole{suffix}").stat().st_size / 1000
    write(tmp_path / f"large{suffix}", kilobytes=2 * size)
    assert (tmp_path / f"large{suffix}").stat().st_size / 1000 == pytest.approx(size, abs=0.01)
    write(tmp_path / f"small{suffix}", kilobytes=0.5 * size)
    small = (tmp_path / f"small{suffix}").stat().st_size / 1000
    assert (0.4 if suffix == ".mp4" else 0.2) * size < small <= 0.5 * size
    frames, _ = read(tmp_path / f"small{suffix}")
    assert len(frames) == 12
    if suffix in (".webm", ".webp"):
        return  # a quarter of these small pictures needs less
    with pytest.raises(
        MotesError, match=r"cannot be as small as 1 kilobytes: the least is \d+, at a quarter"
    ):
        write(tmp_path / f"none{suffix}", kilobytes=1)
    assert not (tmp_path / f"none{suffix}").exists()


@pytest.mark.parametrize(
    ("name", "value"), [("kilobytes", 0), ("kilobytes", "5"), ("kilobytes", float("nan")), ("fps", 51)]
)
def test_arguments_are_checked(name: str, value: Any, tmp_path: Path) -> None:
    with pytest.raises(ArgumentError, match=name):
        motes.Movie(tmp_path / "a.gif", **{name: value})
    with pytest.raises(ArgumentError, match=r"\.mp4, \.mkv, \.mov, \.webm, \.gif or \.webp"):
        motes.Movie(tmp_path / "a.avi")


def test_contact_sheets(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    for k, picture in enumerate(moving(30)):
        picture.save(tmp_path / "frames" / f"f.{k:03}.png")
    write(tmp_path / "film.mp4", count=30)
    for source in ("frames", "film.mp4"):
        target = tmp_path / "sheet.png"
        assert cli.main(["movie", str(tmp_path / source), "--sheet", "4x3", "-o", str(target)]) == 0
        with Image.open(target) as sheet:
            assert sheet.size == (4 + 4 * (64 + 4), 4 + 3 * (48 + 4))
            last = np.asarray(sheet)[-4 - 24 : -4, -4 - 64 : -4].astype(float)
        assert np.abs(last - list(moving(30))[-1].pixels[24:]).mean() < (0.1 if source == "frames" else 4)
    for given, said in [
        (["--sheet", "0x3", "-o", "a.png"], "must be columns x rows"),
        (["--sheet", "4x3"], "add `-o sheet.png`"),
        (["--sheet", "4x3", "-o", "a.mp4"], "--output must be a name ending in .png"),
    ]:
        with pytest.raises(SystemExit) if "0x3" in given else _nothing():
            assert cli.main(["movie", str(tmp_path / "frames"), *given]) == 2
        assert said in capfd.readouterr().err


class _nothing:
    def __enter__(self) -> None: ...
    def __exit__(self, *_: object) -> None: ...
