"""`World.seek`: any frame at once, forwards and back, is that of an undisturbed run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from standing import on_ranks

import motes
from motes import shapes
from motes.errors import ArgumentError, MotesError

FRAMES = 20


class Film:
    """A world whose particles meet, with ribbons, a moving camera and an open shutter."""

    def __init__(self, checkpoint: motes.Checkpoint | None = None, **settings: Any) -> None:
        camera = motes.Camera(motes.Curve([(0, (-3, 1, 6)), (1, (3, 2, 5))]), (0, 0, 0))
        renderer = motes.Renderer(64, 48, camera=camera, shutter=1)
        self.world = motes.World(
            seed=3, space=(-2, 2), renderer=renderer, progress="off", checkpoint=checkpoint, **settings
        )
        self.dust = self.world.system("dust", sprite=motes.Sprite("disc", pixels=4))
        self.tails = self.world.system("tails", sprite=motes.Sprite("ribbon", width=0.1, length=0.2))
        self.pictures: dict[int, str] = {}

    def record(self, frame: int) -> None:
        """Record a frame's actions."""
        self.dust.configure(velocity=shapes.Sphere((0, 0, 0), 1), color=(0.5, 0.4, 0.1 + 0.02 * frame))
        self.dust.source(shapes.Sphere((0, 0, 0), 1), rate=500)
        self.dust.gravitate(-0.02, max_radius=0.4)
        self.dust.move()
        self.tails.configure(velocity=shapes.Sphere((0, 0, 0), 2))
        self.tails.source((0, 0, 0), rate=40)
        self.tails.gravity((0, -3, 0))
        self.tails.move()

    def frames(self, n: int, **seeks: int) -> list[int]:
        """Run to frame n; return the loop's frames. `seeks`: f12=3 goes to frame 3 before frame 12, once."""
        visited = []
        for frame in self.world.frames(n):
            if (to := seeks.pop(f"f{frame}", None)) is not None:
                self.world.seek(to)
                continue
            visited.append(frame)
            if frame == 6:
                self.dust.sprite = motes.Sprite("disc", pixels=9)
            self.record(frame)
            if picture := self.world.render():
                self.pictures[frame] = picture.digest()
        return visited


@pytest.fixture(scope="module")
def undisturbed() -> tuple[dict[int, str], str]:
    """Return the digests of pictures and of the last particles."""
    film = Film()
    with film.world:
        film.frames(FRAMES)
        return film.pictures, film.world.digest()


def test_forwards_frames_are_stepped(undisturbed: tuple[dict[int, str], str]) -> None:
    film = Film()
    with film.world:
        film.world.seek(12)
        assert film.frames(13) == list(range(13))
        assert list(film.pictures) == [12]
        assert film.frames(FRAMES) == list(range(13, FRAMES))
        assert film.world.digest() == undisturbed[1]
    assert film.pictures.items() <= undisturbed[0].items()


def test_back_to_the_start_and_forwards_again(undisturbed: tuple[dict[int, str], str]) -> None:
    film = Film()
    with film.world:
        assert film.frames(FRAMES, f15=4, f9=9) == [*range(15), *range(9), *range(9, FRAMES)]
        assert film.world.digest() == undisturbed[1]
        film.world.seek(7)
        assert film.frames(8) == list(range(8))
    assert film.pictures == undisturbed[0]


@pytest.mark.parametrize("every", [5, "auto"])
def test_through_checkpoints(undisturbed: tuple[dict[int, str], str], tmp_path: Path, every: Any) -> None:
    film = Film(motes.Checkpoint(tmp_path, every=every, keep=9, seconds=0))
    with film.world:
        film.frames(FRAMES)
        film.pictures.clear()
        film.world.seek(13)
        first = 10 if every == 5 else 13
        assert film.frames(15) == list(range(first, 15))
        assert list(film.pictures) == [13, 14]
        film.world.seek(17)
        first = 15 if every == 5 else 17
        assert film.frames(18) == list(range(first, 18))
        film.world.seek(FRAMES)
        assert film.world.digest() == undisturbed[1]
    assert film.pictures.items() <= undisturbed[0].items()


def test_what_seek_refuses(tmp_path: Path) -> None:
    film = Film(log=tmp_path / "log")
    with pytest.raises(MotesError, match="inside `with world:`"):
        film.world.seek(0)
    with film.world:
        for bad in (-1, 1.5, "3", None, 2**63):
            with pytest.raises(ArgumentError, match="frame"):
                film.world.seek(bad)  # type: ignore[arg-type]
        film.frames(3)
        with pytest.raises(ArgumentError, match="in a world with a log"):
            film.world.seek(1)
        film.world.seek(3)
        film.dust.move()
        with pytest.raises(MotesError, match="after actions of frame 3 were recorded"):
            film.world.seek(4)
        film.world.step()
    film = Film()
    with film.world:
        film.dust.burst((0, 0, 0), count=5)
        film.frames(3)
        with pytest.raises(ArgumentError, match="cannot start again: the script recorded births or actions"):
            film.world.seek(0)
        for frame in film.world.frames(5):
            film.world.seek(frame)  # changes nothing
            film.record(frame)
            film.world.step()
    film = Film()
    with pytest.raises(MotesError, match="`continue` with the loop's next iteration"), film.world:
        for frame in film.world.frames(5):
            if frame == 3:
                film.world.seek(1)
            film.world.step()


SOUGHT = """
import json, sys, motes
from motes import shapes

balancer = motes.balance.Pairwise(min_particles=5)
renderer = motes.Renderer(48, 32, camera=motes.Camera((0, 0, 6), (0, 0, 0)))
world = motes.World(seed=1, space="fit", progress="off", roles="shared", renderer=renderer, balancer=balancer,
                    checkpoint=motes.Checkpoint(sys.argv[1], every=6, keep=9) if sys.argv[1] != "-" else None)
dust = world.system("dust")
grains = world.system("grains", axis="y")
goes = json.loads(sys.argv[2])
with world:
    for frame in world.frames(16):
        if goes and frame == goes[0][0]:
            world.seek(goes.pop(0)[1])
            continue
        dust.configure(velocity=(1, 0, 0))
        dust.source(shapes.Sphere((0.2 * frame, 0, 0), 1), rate=2000)
        dust.gravitate(0.01, max_radius=0.3)
        dust.kill_old(0.3)
        dust.move()
        grains.source(shapes.Sphere((0, 0.1 * frame, 0), 0.5), rate=500)
        grains.collide(0.1)
        grains.move()
        picture = world.render()
        digest = world.digest()
        if picture:
            print(json.dumps([frame, picture.digest(), digest]))
"""


@pytest.mark.parametrize("ranks", [1, 2, 3, 5])
def test_on_any_number_of_ranks(ranks: int, tmp_path: Path) -> None:
    """Cuts that balancing has planned, neighbour lists and ghosts of later frames are forgotten."""
    whole = dict(map(_row, on_ranks(1, SOUGHT, "-", "[]").lines))
    assert len(whole) == 16
    for place in ("-", tmp_path / "checkpoints"):
        result = on_ranks(ranks, SOUGHT, place, json.dumps([(14, 7), (11, 2), (5, 9)]))
        assert result.code == 0, result.text
        rows = list(map(_row, result.lines))
        assert [frame for frame, _ in rows] == [*range(14), *range(7, 11), *range(2, 5), *range(9, 16)]
        assert dict(rows) == whole


def _row(line: str) -> tuple[int, tuple[str, str]]:
    frame, picture, particles = json.loads(line)
    return frame, (picture, particles)


def test_a_frame_stepped_for_a_seek_is_marked_as_left_out() -> None:
    film = Film()
    with film.world:
        film.world.seek(1)
        for _ in film.world.frames(2):
            picture = film.world.render()
            assert picture.left_out == (not picture)
    assert np.asarray(picture).shape == (48, 64, 3)
