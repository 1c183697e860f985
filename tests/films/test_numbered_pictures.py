"""`motes movie`: makes a film of numbered pictures, and reports what is wrong with them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import motes
from motes.cli import main

pytest.importorskip("av")
GREYS = (20, 90, 160, 230)


def picture(path: Path, grey: int, size: tuple[int, int] = (64, 48)) -> None:
    path.parent.mkdir(exist_ok=True)
    motes.Frame(0, 0.0, np.full((size[1], size[0], 3), grey, np.uint8)).save(path)


def series(folder: Path, numbers: tuple[int, ...] = (8, 9, 10, 11), name: str = "snow.") -> Path:
    """Write pictures numbered without leading zeros, so names and numbers sort differently."""
    for number, grey in zip(numbers, GREYS, strict=False):
        picture(folder / f"{name}{number}.png", grey)
    return folder


def shown(film: Path) -> list[int]:
    """Return the mean grey of each picture of a film, rounded to the nearest grey that was written."""
    import av

    with av.open(str(film)) as movie:
        means = [frame.to_ndarray(format="gray").mean() for frame in movie.decode(video=0)]
    return [min(GREYS, key=lambda grey: abs(grey - mean)) for mean in means]


def test_pictures_come_in_the_order_of_their_numbers(tmp_path, capsys):
    folder = series(tmp_path / "frames")
    (folder / "notes.txt").touch()
    (folder / "cover.png").touch()
    assert main(["movie", str(folder), "--fps", "30", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    film = tmp_path / "frames.mp4"
    assert facts == {
        **{"film": str(film), "pictures": 4, "width": 64, "height": 48, "fps": 30.0},
        "seconds": pytest.approx(4 / 30),
    }
    assert shown(film) == list(GREYS)
    import av

    with av.open(str(film)) as movie:
        assert movie.streams.video[0].average_rate == 30


def test_the_film_has_the_name_that_it_is_given(tmp_path, monkeypatch, capsys):
    series(tmp_path / "frames")
    assert main(["movie", str(tmp_path / "frames"), "-o", str(tmp_path / "a.mkv")]) == 0
    assert "4 pictures of 64x48, 0.17 s" in capsys.readouterr().out
    assert shown(tmp_path / "a.mkv") == list(GREYS)
    monkeypatch.chdir(tmp_path / "frames")
    assert main(["movie", "."]) == 0
    assert (tmp_path / "frames.mp4").is_file()


def test_missing_pictures_are_named_held_or_skipped(tmp_path, capsys):
    folder = series(tmp_path / "frames", (0, 1, 5, 7))
    assert main(["movie", str(folder)]) == 2
    assert "pictures are missing between 0 and 7: 2 to 4, 6; --gaps hold" in capsys.readouterr().err
    assert not (tmp_path / "frames.mp4").exists()
    assert main(["movie", str(folder), "--gaps", "hold"]) == 0
    a, b, c, d = GREYS
    assert shown(tmp_path / "frames.mp4") == [a, b, b, b, b, c, c, d]
    assert main(["movie", str(folder), "--gaps", "skip"]) == 0
    assert shown(tmp_path / "frames.mp4") == [a, b, c, d]


def test_many_gaps_are_counted(tmp_path, capsys):
    for number in range(0, 20, 2):
        picture(tmp_path / "frames" / f"{number}.png", 9)
    assert main(["movie", str(tmp_path / "frames")]) == 2
    assert ": 1, 3, 5, 7, 9 and 4 more gaps;" in capsys.readouterr().err


def test_pictures_that_differ_in_size_are_named(tmp_path, capsys):
    folder = series(tmp_path / "frames")
    picture(folder / "snow.12.png", 9, (32, 48))
    assert main(["movie", str(folder)]) == 2
    said = capsys.readouterr().err
    assert "snow.8.png has 64x48 pixels" in said and "snow.12.png 32x48" in said
    assert not list(tmp_path.glob("*.mp4"))


def test_one_series_is_chosen(tmp_path, capsys):
    folder = series(series(tmp_path / "frames"), (0, 1), "rain")
    assert main(["movie", str(folder)]) == 2
    assert "several series of pictures: 'rain' (2), 'snow.' (4); choose one with" in capsys.readouterr().err
    assert main(["movie", str(folder), "--series", "snwo."]) == 2
    assert "did you mean 'snow.'?" in capsys.readouterr().err
    assert main(["movie", str(folder), "--series", "rain"]) == 0
    assert shown(tmp_path / "frames.mp4") == list(GREYS[:2])


@pytest.mark.parametrize(
    "head", [b"", b"\x89PNG\r\n\x1a\n", b"GIF89a" + bytes(40), bytes(12) + b"IHDR" + bytes(20)]
)
def test_what_is_no_picture_is_said_before_a_film_is_begun(tmp_path, capsys, head):
    folder = series(tmp_path / "frames")
    (folder / "snow.12.png").write_bytes(head)
    assert main(["movie", str(folder)]) == 2
    assert "snow.12.png is not a PNG picture" in capsys.readouterr().err
    assert not list(tmp_path.glob("*.mp4"))


def test_a_damaged_picture_ends_the_film_with_its_name(tmp_path, capsys):
    folder = series(tmp_path / "frames")
    whole = (folder / "snow.10.png").read_bytes()
    (folder / "snow.10.png").write_bytes(whole[:40])
    assert main(["movie", str(folder)]) == 2
    assert "snow.10.png cannot be read" in capsys.readouterr().err
    assert not (tmp_path / "frames.mp4").exists()


@pytest.mark.parametrize(
    ("names", "says"),
    [
        ([], "has no numbered pictures"),
        (["a.png"], "has no numbered pictures"),
        (["a1.png", "a01.png"], "have the same number"),
    ],
)
def test_directories_without_a_clear_order_are_refused(tmp_path, capsys, names, says):
    (tmp_path / "frames").mkdir()
    for name in names:
        picture(tmp_path / "frames" / name, 9)
    assert main(["movie", str(tmp_path / "frames")]) == 2
    assert says in capsys.readouterr().err
    assert main(["movie", str(tmp_path / "nowhere")]) == 2
    assert "nowhere is not a directory" in capsys.readouterr().err
    assert main(["movie", str(tmp_path / "snow.mp4")]) == 2
    assert "has no films of ranges of snow.mp4, such as snow.000400-000500.mp4" in capsys.readouterr().err


def test_clear_pixels_are_shown_over_a_colour_and_never_dropped_silently(tmp_path, capsys):
    images = pytest.importorskip("PIL.Image")
    (tmp_path / "frames").mkdir()
    for number, alpha in enumerate((255, 0)):
        rgba = np.full((48, 64, 4), (230, 230, 230, alpha), np.uint8)
        images.fromarray(rgba).save(tmp_path / "frames" / f"a{number}.png")
    assert main(["movie", str(tmp_path / "frames")]) == 2
    assert "a1.png has transparent pixels, which a film cannot have: --background" in capsys.readouterr().err
    assert main(["movie", str(tmp_path / "frames"), "--background", "5a5a5a"]) == 0
    assert shown(tmp_path / "frames.mp4") == [230, 90]
    with pytest.raises(SystemExit):
        main(["movie", str(tmp_path / "frames"), "--background", "black"])
    assert "must be six hexadecimal digits, such as 202020, got 'black'" in capsys.readouterr().err
