"""A film that is not closed yet: players can open its partial file, and all ranks know its state."""

from __future__ import annotations

import contextlib
import os
import random
import resource
import subprocess
import sys
import time

import numpy as np
import pytest

av = pytest.importorskip("av")

from films import cut_off, go_on, moving, packets, partial, shown, whole  # noqa: E402
from launching import mpirun  # noqa: E402
from standing import on_ranks  # noqa: E402

from motes._film.movie import Movie, writer_of  # noqa: E402
from motes._picture.frame import Frame  # noqa: E402
from motes._run import continuing  # noqa: E402
from motes._run.continuing import open_movies  # noqa: E402
from motes.errors import MotesError  # noqa: E402

pytestmark = pytest.mark.usefixtures("children_import_tests")


def test_what_was_secured_is_in_the_file(tmp_path):
    film = tmp_path / "a.mp4"
    movie = Movie(film)
    assert writer_of(movie).secure() == 0
    for count, frame in enumerate(moving(13), 1):
        movie.write(frame)
        if count in (5, 6, 13):
            assert writer_of(movie).secure() == count
            assert len(packets(partial(film))[0]) == count
    assert writer_of(movie).secure() == 13  # again, without new frames
    movie.close()
    assert len(packets(film)[0]) == 13


def test_securing_waits_for_the_disk(tmp_path, monkeypatch):
    synced, sync = [], os.fsync

    def slow(file):
        time.sleep(0.2)
        sync(file)
        with contextlib.suppress(OSError):
            synced.append(os.fstat(file).st_size)

    with Movie(tmp_path / "a.mp4") as movie:
        for frame in moving(5):
            movie.write(frame)
        monkeypatch.setattr(os, "fsync", slow)
        writer_of(movie).secure()
        assert partial(movie.path).stat().st_size in synced
        monkeypatch.undo()


def test_a_film_that_cannot_be_read_again_does_not_become_the_whole_one(tmp_path):
    movie = Movie(tmp_path / "a.mp4")
    for frame in moving(60):
        movie.write(frame)
    writer_of(movie).secure()
    os.truncate(partial(movie.path), partial(movie.path).stat().st_size // 2)
    with pytest.raises(MotesError, match=r"a.mp4 could not be written: .*of 60 frames could be read back"):
        movie.close()
    assert os.listdir(tmp_path) == ["a.partial.mp4"]


KILLED = """
import sys, time
from films import moving
from motes._film.movie import Movie, writer_of

movie = Movie(sys.argv[1], fps=6)
for frame in moving(100_000, height=32, width=32):
    movie.write(frame)
    if frame.index % 50 == 49:
        print(writer_of(movie).secure(), flush=True)
"""


@pytest.mark.parametrize(
    "number", [*range(4), *(pytest.param(n, marks=pytest.mark.slow) for n in range(4, 30))]
)
def test_a_killed_process_leaves_a_film(tmp_path, number):
    film = tmp_path / f"a{('.mp4', '.mkv', '.mov')[number % 3]}"
    argv = [sys.executable, "-c", KILLED, str(film)]
    with subprocess.Popen(argv, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as child:
        try:
            safe = int(child.stdout.readline())
            time.sleep(random.Random(number).uniform(0, 0.5))
        finally:
            child.kill()
        safe = max([safe, *(int(line) for line in child.stdout if line.endswith(b"\n"))])
    assert not film.exists()
    times = shown(partial(film))
    assert len(times) >= safe
    assert times == pytest.approx([k / 6 for k in range(len(times))], abs=6e-4)
    go_on(film, safe, safe + 3, fps=6, size=(32, 32))
    assert len(shown(film)) == safe + 3
    assert os.listdir(tmp_path) == [film.name]


@pytest.mark.parametrize("moment", ["before", "behind"])
def test_a_process_that_is_killed_while_it_closes_a_film(tmp_path, moment):
    """The kill comes before the complete film gets its name, or before the partial film is removed."""
    film = tmp_path / "a.mp4"
    script = (
        "import os, sys\nfrom films import moving\nfrom motes._film.movie import Movie\n"
        "replace = os.replace\n"
        "def killed(draft, path):\n"
        "    if 'partial' in str(path) or sys.argv[2] == 'behind': replace(draft, path)\n"
        "    if 'partial' not in str(path): os.kill(os.getpid(), 9)\n"
        "os.replace = killed\n"
        "with Movie(sys.argv[1]) as movie:\n"
        "    for frame in moving(30): movie.write(frame)\n"
    )
    ended = subprocess.run([sys.executable, "-c", script, str(film), moment], timeout=60)
    assert ended.returncode == -9
    assert film.exists() == (moment == "behind")
    assert len(shown(partial(film))) == 30
    assert len(os.listdir(tmp_path)) == 2
    go_on(film, 24, 40)
    assert len(shown(film)) == 40
    assert os.listdir(tmp_path) == ["a.mp4"]


def test_two_films_of_one_name_do_not_mix(tmp_path):
    film = tmp_path / "a.mp4"
    first, second = Movie(film), Movie(film)
    for movie, count in ((first, 30), (second, 50)):
        for frame in moving(count):
            movie.write(frame)
        writer_of(movie).secure()
    first.close()
    assert len(packets(film)[0]) == 30
    assert partial(film).exists()
    second.close()
    assert len(packets(film)[0]) == 50
    assert os.listdir(tmp_path) == ["a.mp4"]


def full_disk(bytes_):
    resource.setrlimit(resource.RLIMIT_FSIZE, (bytes_, bytes_))


FULL = """
import sys
import numpy as np
from films import moving
from motes.errors import MotesError
from motes._film.movie import Movie

try:
    with Movie(sys.argv[1]) as movie:
        for frame in moving(200): movie.write(frame)
except MotesError as error:
    print(error)
"""


def test_a_full_disk_is_told_and_leaves_what_there_is(tmp_path):
    """The disk is full while segments are written, or while they are joined into the complete film."""
    whole(tmp_path / "whole.mp4", 200, secure=())
    cut_off(tmp_path / "b.mp4", 200, secure=())
    size, most = (tmp_path / "whole.mp4").stat().st_size, partial(tmp_path / "b.mp4").stat().st_size
    for number, limit in enumerate([20, size // 3, most - 1, min(size, most) - 1]):
        film = tmp_path / f"{number}.mp4"
        done = subprocess.run(
            [sys.executable, "-c", FULL, str(film)],
            preexec_fn=lambda limit=limit: full_disk(limit),
            capture_output=True,
            text=True,
            timeout=60,
        )
        assert "could not be written: [Errno 27] File too large" in done.stdout, done.stderr
        assert not film.exists()
        left = [name for name in os.listdir(tmp_path) if name.startswith((f"{number}.", f".{number}."))]
        assert left == ([f"{number}.partial.mp4"] if limit > 20 else [])
        if limit > 20:
            count = len(shown(partial(film)))
            assert count == 200 or (count >= 24 and count % 24 == 0), "whole segments, and no torn one"


def test_every_rank_counts_the_pictures_wherever_they_are(tmp_path):
    here, there = Movie(tmp_path / "a.mp4"), Movie(tmp_path / "there" / "a.mp4")
    for k, frame in enumerate(moving(6)):
        stepped = Frame(k, 0.0, None, home=None)
        elsewhere = Frame(k, 0.0, None, home=0, rank=1)
        for movie, picture in ((here, frame), (there, elsewhere)):
            movie.write(stepped)
            movie.write(picture)
        if k == 3:
            assert (writer_of(here).secure(), writer_of(there).secure()) == (4, 4)
            writer_of(here).note_secured()
            writer_of(there).note_secured()
    assert (here.written, there.written) == (6, 6)
    assert (here.frames, there.frames) == (6, 0)
    assert list(writer_of(here)._unsecured) == list(writer_of(there)._unsecured) == [4, 5]
    here.close()
    there.close()
    assert os.listdir(tmp_path) == ["a.mp4"]


JOB = """
import sys
import motes
from motes._film.movie import writer_of
from motes._run.continuing import frames_of_movies

film, failing = sys.argv[1], int(sys.argv[2])
renderer = motes.Renderer(64, 48, camera=motes.Camera((0, 0, 5), (0, 0, 0)))
with motes.World(seed=1, space=(-1, 1), renderer=renderer, progress="off") as world:
    sparks = world.system("sparks")
    movie = motes.Movie(film, fps=5)
    for frame in world.frames(24):
        sparks.burst(motes.shapes.Sphere((0, 0, 0), 1), count=20)
        movie.write(world.step() if frame % 3 == 2 else world.render())
        if frame == 9:
            assert writer_of(movie).secure() == 7
            writer_of(movie).note_secured()
        if frame == 20 and world.rank == failing:
            raise KeyError("of the script")
    assert frames_of_movies() == {writer_of(movie).place: 16}
    sys.stdout.write(f"{movie.written} {list(writer_of(movie)._unsecured)}\\n")
    movie.close()
    assert frames_of_movies() == {}
"""


def test_all_ranks_of_a_job_agree_on_how_far_a_film_is(tmp_path):
    film, ranks = tmp_path / "a.mp4", 3
    result = on_ranks(ranks, JOB, film, -1)
    assert result.code == 0, result.text
    told = f"16 {[frame for frame in range(10, 24) if frame % 3 != 2]}"
    assert result.lines == [told] * ranks
    assert len(shown(film)) == 16
    assert os.listdir(tmp_path) == ["a.mp4"]


@pytest.mark.parametrize("failing", [0, 1])
def test_a_job_that_fails_leaves_a_film(tmp_path, failing):
    film = tmp_path / "a.mp4"
    result = mpirun(3, JOB, film, failing)
    assert result.code != 0
    assert "of the script" in result.err
    (left,) = (name for name in os.listdir(tmp_path) if not name.startswith("."))
    assert len(shown(tmp_path / left)) >= 7


def test_open_movies_are_known_in_the_order_of_their_creation(tmp_path):
    before, held = open_movies(), dict(continuing._held)
    first, second, third = (Movie(tmp_path / f"{name}.mp4") for name in "bac")
    assert open_movies() == [*before, *map(writer_of, (first, second, third))]
    second.write(Frame(0, 0.0, None, home=0, rank=1))
    second.close()
    assert open_movies() == [*before, *map(writer_of, (first, third))]
    third.write(Frame(0, 0.0, None, home=0, rank=1))
    del first, third  # the script dropped a movie that has frames: all ranks still know it
    assert [movie.path.name for movie in open_movies()[len(before) :]] == ["c.mp4"]
    open_movies()[-1].close()
    assert open_movies() == before
    assert continuing._held == held


def test_pixels_of_no_frame_are_counted(tmp_path):
    with Movie(tmp_path / "a.mp4") as movie:
        movie.write(np.zeros((16, 16, 3), np.uint8))
        assert (movie.written, list(writer_of(movie)._unsecured)) == (1, [-1])
