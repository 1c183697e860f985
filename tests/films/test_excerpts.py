"""Frames and ranges that are drawn by themselves are those of the whole run, on any number of ranks."""

from __future__ import annotations

import hashlib
import json
import os
import random
import shutil
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from films import decoded, packets
from standing import on_ranks

import motes
from motes import cli, shapes
from motes._film import parts
from motes._picture.frame import Frame
from motes._run.excerpt import Excerpt, missing
from motes.errors import ArgumentError, MotesError

SHOT = Path(__file__).parents[1] / "scenes" / "shot.py"
FRAMES = 60


def digests(result: Any) -> dict[int, str]:
    """Return the digests of the pictures that a run of the shot has printed."""
    assert result.code == 0, result.text
    rows = [json.loads(line) for line in result.out.splitlines() if line.startswith("{")]
    return {row["frame"]: row["digest"] for row in rows}


def files_in(place: Path) -> dict[str, int]:
    """Return all files below a folder, with the times of their last change."""
    return {str(path): path.stat().st_mtime_ns for path in place.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[int, str]]:
    """Return the folder of the whole run, with checkpoints every 16 frames, and its pictures' digests."""
    place = tmp_path_factory.mktemp("shot")
    pictures = digests(on_ranks(2, SHOT, place))
    assert len(pictures) == len(set(pictures.values())) == FRAMES
    return place, pictures


def still(place: Path, ranks: int, frame: int, to: Path, **env: str) -> Any:
    """Do what `motes frame` does."""
    told = {"MOTES_FRAMES": f"{frame}:{frame + 1}", "MOTES_STILL": str(to)}
    return on_ranks(ranks, SHOT, place, env=told | env)


@pytest.mark.parametrize("ranks", [1, 2, 3, 4])
def test_frames_drawn_by_themselves_are_those_of_the_whole_run(
    whole: tuple[Path, dict[int, str]], ranks: int, tmp_path: Path
) -> None:
    place, pictures = whole
    before = files_in(place)
    for frame in random.Random(ranks).sample(range(FRAMES), 3):
        result = still(place, ranks, frame, tmp_path / "still.npy")
        assert result.code == 0, result.text
        near = f"continues with frame {frame // 16 * 16}," in result.err
        assert near == (frame >= 16), result.err
        drawn = Frame(0, 0, np.load(tmp_path / "still.npy"))
        assert drawn.digest() == pictures[frame], f"frame {frame}"
    assert files_in(place) == before, "a still changes nothing else"


def test_a_picture_is_compared_with_the_log(whole: tuple[Path, dict[int, str]], tmp_path: Path) -> None:
    place, pictures = whole
    log = place / "log" / "frames.jsonl"
    text = log.read_text()
    try:
        log.write_text(text.replace(pictures[50], "0" * 64))
        result = still(place, 1, 50, tmp_path / "still.png")
        assert result.code != 0 and not (tmp_path / "still.png").exists()
        assert "frame 50 differs from the one that" in result.err and "--anyway" in result.err
        assert still(place, 1, 50, tmp_path / "still.png", MOTES_ANYWAY="1").code == 0
        assert still(place, 1, 49, tmp_path / "still.png").code == 0
    finally:
        log.write_text(text)


def test_a_film_of_four_ranges_is_the_film(whole: tuple[Path, dict[int, str]], tmp_path: Path) -> None:
    """Ranges end within a second, at a cut that a checkpoint makes (48), and two share one second."""
    place, pictures = whole
    drawn: dict[int, str] = {}
    for ranks, (first, end) in enumerate([(0, 13), (13, 20), (20, 48), (48, 60)], 1):
        drawn |= digests(on_ranks(ranks, SHOT, place, env={"MOTES_FRAMES": f"{first}:{end}"}))
    assert drawn == pictures
    rows = (place / "log.000020-000048" / "frames.jsonl").read_text().splitlines()
    assert [json.loads(row)["frame"] for row in rows] == list(range(16, 48))
    assert cli.main(["movie", str(place), "-o", str(tmp_path / "joined.mp4")]) == 0
    assert packets(tmp_path / "joined.mp4") == packets(place / "film.mp4")
    films = parts.parts_of(place / "film.mp4")
    with pytest.raises(MotesError, match=r"frames 13 to 19 are missing"):
        parts.join([films[0], *films[2:]], tmp_path / "gap.mp4")
    with pytest.raises(MotesError, match=r"both have the same frames"):
        parts.join([*films[:2], *films[1:]], tmp_path / "gap.mp4")
    parts.seam_of(films[1]).unlink()
    with pytest.raises(MotesError, match=r"film.000013-000020.mp4.seam, which its job wrote, is missing"):
        parts.join(films, tmp_path / "gap.mp4")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["joined.mp4"]


def test_frames_that_do_not_exist(whole: tuple[Path, dict[int, str]], tmp_path: Path) -> None:
    place, _ = whole
    result = still(place, 2, FRAMES, tmp_path / "still.png")
    assert result.code != 0
    assert "frame 60 does not exist: the script has frames 0 to 59" in result.err
    result = on_ranks(1, SHOT, place, env={"MOTES_FRAMES": "58:70"})
    assert sorted(digests(result)) == [58, 59]
    assert "motes: frames 60 to 69 do not exist: the script has frames 0 to 59" in result.err
    assert missing(Excerpt(3, 4, None), 0) == "frame 3 does not exist: the script has no frame"
    assert missing(Excerpt(3, None, None), 4) == missing(Excerpt(3, 4, None), 4) == ""


def test_without_usable_checkpoints_an_excerpt_starts_at_the_first_frame(
    whole: tuple[Path, dict[int, str]], tmp_path: Path
) -> None:
    place, pictures = whole
    kept = place / "checkpoints"
    aside = shutil.copytree(kept, tmp_path / "aside")
    try:
        for world in kept.glob("*/world.bin"):
            world.write_bytes(b"damaged")
        result = still(place, 1, 18, tmp_path / "still.npy")
        assert result.code == 0 and "frame 16 is skipped" in result.err, result.text
        assert Frame(0, 0, np.load(tmp_path / "still.npy")).digest() == pictures[18]
    finally:
        shutil.rmtree(kept)
        aside.rename(kept)


@pytest.mark.parametrize("text", ["5:3", "5", "-1:3", "a:b", "1:2:3", "3:3", "1.5:4", "9" * 30 + ":"])
def test_ranges_of_frames_are_checked(text: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["run", "-n", "1", f"--frames={text}", str(SHOT)]) == 2
    assert "--frames must be frames such as 400:500, which are 400 to 499" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (["-3", "-o", "a.png"], "NUMBER must be a frame's number: frames count from 0, got -3"),
        (["3"], "add `-o still.png`"),
        (["3", "-o", "a.bmp"], "--output must be a name ending in .png, .jpg, .webp, .exr or .npy"),
        (["3", "-o", "a.png", "--steering", "nowhere"], "--steering must be the steer.jsonl"),
    ],
)
def test_arguments_of_frame_are_checked(
    given: list[str], said: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["frame", str(SHOT), *given]) == 2
    assert said in capfd.readouterr().err


def test_a_full_disk_is_told_on_all_ranks(whole: tuple[Path, dict[int, str]], tmp_path: Path) -> None:
    (tmp_path / "still.png").mkdir()
    result = still(whole[0], 2, 3, tmp_path / "still.png")
    assert result.code != 0 and "Is a directory" in result.err


# --- previews


def mean_light(**sprite: Any) -> float:
    renderer = motes.Renderer(201, 160, camera=motes.Camera((0, 0, 5), (0, 0, 0)), linear=True)
    world = motes.World(seed=1, renderer=renderer, progress="off")
    system = world.system("s", sprite=motes.Sprite(**sprite))
    with world:
        system.configure(color=(0.3, 0.2, 0.1))
        system.burst(shapes.Box((-1.5, -1.2, 0), (1.5, 1.2, 0)), count=60)
        return float(world.render().linear.mean())


@pytest.mark.parametrize(
    "sprite",
    [
        {"kind": "point"},
        {"pixels": 1},
        {"pixels": 2},
        {"pixels": 5, "blend": "alpha"},
        {"kind": "sphere", "pixels": 8, "blend": "opaque"},
        {"kind": "image", "image": np.full((9, 9, 4), 255, np.uint8), "pixels": 9},
        {"height": 0.05},
        {"pixels": None},
    ],
)
def test_a_preview_has_half_the_size_and_the_same_light(
    sprite: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = mean_light(**sprite)
    monkeypatch.setenv("MOTES_PREVIEW", "1")
    assert mean_light(**sprite) == pytest.approx(whole, rel=0.06)


def test_the_size_of_a_preview(whole: tuple[Path, dict[int, str]], tmp_path: Path) -> None:
    result = still(whole[0], 2, 40, tmp_path / "still.npy", MOTES_PREVIEW="1")
    assert result.code == 0, result.text  # it is not compared with the log
    assert np.load(tmp_path / "still.npy").shape == (32, 48, 3)


def test_a_digest_is_that_of_the_pixels() -> None:
    pixels = np.zeros((2, 3, 3), np.uint8)
    assert Frame(0, 0, pixels).digest() == hashlib.sha256(b"2x3x3\n" + bytes(18)).hexdigest()


def test_a_movie_of_a_still_writes_nothing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("MOTES_FRAMES", "3:4")
    monkeypatch.setenv("MOTES_STILL", str(tmp_path / "still.png"))
    with motes.Movie(tmp_path / "film.mp4") as film:
        film.write(np.zeros((8, 8, 3), np.uint8))
    assert not list(tmp_path.iterdir())


def test_pieces_of_a_film_of_every_second_frame(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A film's own frames count, not those of the world."""

    def pictures() -> list[Frame]:
        generator = np.random.default_rng(1)
        return [Frame(k, 0, generator.integers(0, 255, (16, 16, 3)).astype(np.uint8)) for k in range(40)]

    def write(first: int, end: int) -> None:
        with motes.Movie(tmp_path / "film.mp4", fps=8) as film:
            for picture in pictures()[::2]:
                shown = first <= picture.index < end
                film.write(picture if shown else Frame(picture.index, 0, None, home=None, left_out=True))

    write(0, 40)
    for first, end in [(0, 3), (3, 4), (4, 17), (17, 40)]:
        monkeypatch.setenv("MOTES_FRAMES", f"{first}:{end}")
        write(first, end)
    films = parts.parts_of(tmp_path / "film.mp4")
    assert [path.name for path in films] == [
        "film.000000-000003.mp4",
        *[f"film.{a:06}-{b:06}.mp4" for a, b in [(4, 17), (17, 40)]],
    ]  # frame 3 is not in the film
    parts.join(films, tmp_path / "joined.mp4")
    assert packets(tmp_path / "joined.mp4") == packets(tmp_path / "film.mp4")
    assert len(decoded(tmp_path / "joined.mp4")) == 20
    with pytest.raises(ArgumentError, match="MOTES_FRAMES"):
        monkeypatch.setenv("MOTES_FRAMES", "nonsense")
        motes.Movie(tmp_path / "film.mp4")


@pytest.mark.slow
@pytest.mark.timeout(500)
def test_any_frame_of_a_long_film_comes_soon(tmp_path: Path) -> None:
    """Ten frames on each number of ranks, from checkpoints as dense as `every="auto"` makes them."""
    count = 160
    options = {"OPTIONS": json.dumps({"frames": count, "every": "auto"})}
    pictures = digests(on_ranks(2, SHOT, tmp_path, env=options, timeout=200))
    for ranks in (1, 2, 3, 4):
        seconds = []
        for frame in random.Random(ranks).sample(range(count), 10):
            start = time.monotonic()
            result = still(tmp_path, ranks, frame, tmp_path / "still.npy", **options)
            seconds.append(time.monotonic() - start)
            assert result.code == 0, result.text
            assert Frame(0, 0, np.load(tmp_path / "still.npy")).digest() == pictures[frame], frame
        crowded = max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1), ranks / (os.cpu_count() or 1))
        print(ranks, "ranks, s:", sorted(seconds))
        assert sorted(seconds)[5] < 2 * crowded
