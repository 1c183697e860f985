"""Films of killed processes are playable; another process continues them without a seam."""

from __future__ import annotations

import itertools
import os
import shutil
import subprocess
import sys
import threading
import time
from fractions import Fraction

import numpy as np
import pytest

av = pytest.importorskip("av")

from films import cut_off, decoded, go_on, moving, packets, partial, shown, whole  # noqa: E402
from hypothesis import given, settings  # noqa: E402
from hypothesis import strategies as st  # noqa: E402

from motes._film import growing  # noqa: E402
from motes._film.movie import Movie, writer_of  # noqa: E402
from motes._io import files  # noqa: E402
from motes._picture.frame import Frame  # noqa: E402
from motes._run import continuing  # noqa: E402
from motes._run.continuing import continued, place_of  # noqa: E402
from motes.errors import CheckpointError, MotesError  # noqa: E402

NTSC = 30000 / 1001

pytestmark = pytest.mark.usefixtures("children_import_tests")


@pytest.fixture(autouse=True)
def _nothing_is_continued():
    yield
    continued.end()


@pytest.mark.parametrize(
    ("suffix", "fps", "at", "size"),
    [
        (".mp4", 24, 31, (33, 35)),
        (".mkv", 24, 48, (48, 64)),
        (".mov", NTSC, 7, (48, 65)),
        (".mp4", 2.5, 5, (47, 64)),
        (".mkv", 2000, 60, (16, 16)),
    ],
)
def test_a_continued_film_is_the_uninterrupted_one(tmp_path, suffix, fps, at, size):
    same = {"fps": fps, "size": size}
    expected = whole(tmp_path / f"a{suffix}", 75, secure={at, 60}, **same)
    film = tmp_path / f"b{suffix}"
    cut_off(film, at + 9, secure={at}, **same)
    movie = go_on(film, at, 75, secure={60}, **same)
    assert (movie.frames, movie.written) == (75, 75)
    assert packets(film) == expected
    assert len(expected[0]) == 75
    if suffix != ".mkv":  # PyAV before 18 does not declare the rate of an mkv
        assert expected[2] == Fraction(fps).limit_denominator(60000)
    assert sorted(os.listdir(tmp_path)) == [f"a{suffix}", f"b{suffix}"]
    assert shown(film) == pytest.approx([k / fps for k in range(75)], abs=6e-4)


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(
    st.sampled_from([".mp4", ".mkv", ".mov"]),
    st.sampled_from([3, 7.5, 24]),
    st.sets(st.integers(1, 40), min_size=1, max_size=5),
    st.integers(0, 12),
    st.data(),
)
def test_any_film_goes_on_behind_any_secured_frame(tmp_path_factory, suffix, fps, secure, more, data):
    folder = tmp_path_factory.mktemp("film")
    count = 45
    expected = whole(folder / f"a{suffix}", count, secure=secure, fps=fps, size=(16, 18))
    film = folder / f"b{suffix}"
    at = data.draw(st.sampled_from(sorted(secure)))
    cut_off(film, at + more, secure=secure, fps=fps, size=(16, 18))
    go_on(film, at, count, secure=secure, fps=fps, size=(16, 18))
    assert packets(film) == expected


def test_a_segment_depends_on_its_frames_alone(tmp_path):
    """A second of film has the same bytes at any position in any film, and on any number of cores."""
    second = [frame.pixels for frame in moving(24, height=256)]
    other = [255 - pixels for pixels in second]
    for name, parts in {"a": [second, other, second], "b": [other, second]}.items():
        with Movie(tmp_path / f"{name}.mp4") as movie:
            for pixels in itertools.chain(*parts):
                movie.write(pixels)
    a = [data for _, _, data in packets(tmp_path / "a.mp4")[0]]
    b = [data for _, _, data in packets(tmp_path / "b.mp4")[0]]
    assert a[:24] == a[48:72] == b[24:]
    assert a[24:48] == b[:24]
    script = "import sys\nfrom films import *\nfrom motes._film.movie import Movie\n"
    script += "with Movie(sys.argv[1]) as movie:\n"
    script += "    for frame in moving(24, height=256): movie.write(frame)\n"
    argv = ["taskset", "-c", str(min(os.sched_getaffinity(0))), sys.executable, "-c", script]
    if shutil.which("taskset"):
        subprocess.run([*argv, str(tmp_path / "c.mp4")], check=True, timeout=60)
        assert [data for _, _, data in packets(tmp_path / "c.mp4")[0]] == a[:24]


@pytest.mark.parametrize("fps", [24, 2.5, 0.2])
def test_a_segment_begins_every_second_and_behind_what_is_secured(tmp_path, fps):
    film = whole(tmp_path / "a.mp4", 60, secure={31}, fps=fps)[0]
    keys = {number for number, (_, key, _) in enumerate(film) if key}
    assert {31, *range(0, 60, max(1, round(fps)))} <= keys


def test_continuing_twice_and_at_the_same_place_again(tmp_path):
    expected = whole(tmp_path / "a.mkv", 70, secure={10, 40})
    film = tmp_path / "b.mkv"
    cut_off(film, 30, secure={10})
    movie = Movie(film)
    writer_of(movie).continue_at(10)  # as if killed before it writes a frame
    writer_of(movie)._film.close()
    movie = Movie(film)
    writer_of(movie).continue_at(10)
    for frame in moving(35, first=10):
        movie.write(frame)
        if movie.written == 40:
            writer_of(movie).secure()
    writer_of(movie).abandon()
    writer_of(movie)._thread.join()
    go_on(film, 40, 70)
    assert packets(film) == expected


@pytest.mark.parametrize("suffix", [".mp4", ".mkv", ".mov"])
def test_a_film_that_was_finished_goes_on(tmp_path, suffix):
    """The run was killed after the movie's last frame; at the checkpoint the movie was shorter."""
    expected = whole(tmp_path / f"a{suffix}", 60, secure={30})
    film = tmp_path / f"b{suffix}"
    whole(film, 44, secure={30})
    assert not partial(film).exists()
    go_on(film, 30, 60)
    assert packets(film) == expected


@pytest.mark.parametrize("suffix", [".mp4", ".mkv", ".mov"])
def test_a_film_is_read_up_to_where_it_was_torn(tmp_path, suffix):
    film = tmp_path / f"a{suffix}"
    cut_off(film, 40, secure={10, 25})
    data = partial(film).read_bytes()
    sizes = [len(data) * k // 23 for k in range(12, 23)]
    for size in sizes:
        partial(film).write_bytes(data[:size])
        copy = growing.GrowingFilm.continued(film, Fraction(24), 10)
        assert copy.frames == 10
        copy.close()
    assert len(packets(partial(film))[0]) == 10


def test_what_cannot_be_continued(tmp_path):
    film = tmp_path / "a.mp4"
    with pytest.raises(
        CheckpointError, match=r"a.mp4 cannot be continued after its first 10 frames: neither"
    ):
        writer_of(Movie(film)).continue_at(10)
    cut_off(film, 40, secure={10})
    before = partial(film).read_bytes()
    cases = {
        50: r"a.partial.mp4 holds 40 frames, and can be cut only after 40 of them",
        20: r"a.partial.mp4 holds 40 frames, and can be cut only after 10 of them",
    }
    for count, message in cases.items():
        with pytest.raises(CheckpointError, match=message):
            writer_of(Movie(film)).continue_at(count)
    partial(film).write_bytes(before[:300])
    with pytest.raises(CheckpointError, match=r"after its first 10 frames: .*a.partial.mp4"):
        writer_of(Movie(film)).continue_at(10)
    partial(film).write_bytes(b"nothing of a film" * 99)
    with pytest.raises(CheckpointError, match=r"a.partial.mp4 is damaged"):
        writer_of(Movie(film)).continue_at(10)
    partial(film).write_bytes(b"")
    with pytest.raises(CheckpointError, match=r"a.partial.mp4 is damaged"):
        writer_of(Movie(film)).continue_at(10)
    assert os.listdir(tmp_path) == ["a.partial.mp4"]


def test_a_film_that_is_being_written_is_not_continued(tmp_path, monkeypatch):
    monkeypatch.setattr(growing, "_PATIENCE_S", 0.2)
    movie = Movie(tmp_path / "a.mp4")
    for frame in moving(5):
        movie.write(frame)
    writer_of(movie).secure()
    with pytest.raises(CheckpointError, match=r"another process is writing .*a.partial.mp4"):
        writer_of(Movie(tmp_path / "a.mp4")).continue_at(5)
    with pytest.raises(MotesError, match=r"is already being written; it can no longer be continued"):
        writer_of(movie).continue_at(5)
    movie.close()
    assert len(packets(tmp_path / "a.mp4")[0]) == 5


@pytest.mark.parametrize("other", [{"size": (64, 64)}, {"fps": 25}])
def test_a_film_of_other_settings_is_not_continued(tmp_path, other):
    film = tmp_path / "a.mp4"
    cut_off(film, 10, secure={10})
    with pytest.raises(CheckpointError, match=r"its first 10 frames have a different size, rate"):
        go_on(film, 10, 20, **other)
    assert len(packets(partial(film))[0]) == 10, "what there was is kept"


def test_a_process_that_is_about_to_be_gone_is_waited_for(tmp_path):
    film = tmp_path / "a.mp4"
    cut_off(film, 30, secure={26})
    dying = os.open(partial(film), os.O_RDONLY)
    assert not files.is_locked_elsewhere(dying)
    threading.Timer(0.3, os.close, (dying,)).start()
    start = time.monotonic()
    writer_of(Movie(film)).continue_at(26)
    assert time.monotonic() - start > 0.25


def test_another_rank_takes_a_film_over(tmp_path):
    expected = whole(tmp_path / "a.mp4", 40, secure={26})
    film = tmp_path / "b.mp4"
    other = Movie(film)
    for k in range(30):
        other.write(Frame(k, 0.0, None, home=0, rank=1))
        if k == 25:
            writer_of(other).secure()
            writer_of(other).note_secured()
    lost = Movie(tmp_path / "lost.mp4")
    for frame in moving(30):
        lost.write(frame)
        if lost.written == 26:
            writer_of(lost).secure()
    shutil.copy(partial(lost.path), partial(film))  # as a killed process leaves it
    writer_of(lost).abandon()
    assert list(writer_of(other)._unsecured) == [26, 27, 28, 29]
    missing = writer_of(other).take_over()
    assert missing == [26, 27, 28, 29]
    assert (other.written, writer_of(other).first_unsaved()) == (30, 26)
    for frame in moving(4, first=26):
        writer_of(other).write_again(frame.index, frame)
        writer_of(other).write_again(frame.index, frame)  # written only once
    assert other.written == 30
    for frame in moving(10, first=30):
        other.write(frame)
    other.close()
    assert packets(film) == expected


def test_a_movie_finds_by_itself_where_it_goes_on(tmp_path, monkeypatch):
    expected = whole(tmp_path / "a.mp4", 40, secure={26})
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    film = tmp_path / "link" / "b.mp4"
    cut_off(film, 30, secure={26})
    monkeypatch.chdir(tmp_path)
    known = {place_of(tmp_path / "real" / "b.mp4"): 26, place_of("none.mp4"): 0}
    continued.begin(100, known, draws=True)
    movie, away, new, none = (
        Movie("link/b.mp4"),
        Movie("link/b.mp4"),
        Movie("real/new.mp4"),
        Movie("none.mp4"),
    )
    assert (movie.written, away.written, new.written) == (26, 26, 0)
    assert writer_of(movie).secure() == 26
    for k, frame in enumerate(moving(14, first=26), 27):
        movie.write(frame)
        new.write(frame)
        none.write(frame)
        away.write(Frame(frame.index, 0.0, None, home=0, rank=1))
        assert (movie.written, away.written) == (k, k)
    for one in (movie, new, none):
        one.close()
    assert packets(film) == expected
    assert len(packets(tmp_path / "real" / "new.mp4")[0]) == 14
    assert len(packets(tmp_path / "none.mp4")[0]) == 14
    continued.end()
    with Movie(film) as movie:  # a later world in this process starts a new film
        movie.write(next(moving(1)))
    assert len(packets(film)[0]) == 1


def test_a_film_that_is_gone_is_told_at_the_first_write(tmp_path):
    continued.begin(100, {place_of(tmp_path / "a.mp4"): 26}, draws=True)
    movie = Movie(tmp_path / "a.mp4")
    with pytest.raises(
        CheckpointError, match=r"a.mp4 cannot be continued after its first 26 frames: neither"
    ):
        movie.write(next(moving(1)))


@pytest.mark.parametrize("suffix", [".mp4", ".mkv"])
def test_a_film_to_which_nothing_is_added_is_finished(tmp_path, suffix):
    """The run was killed after the film's last frame, before the film was closed."""
    expected = whole(tmp_path / f"a{suffix}", 30, secure={30})
    film = tmp_path / f"b{suffix}"
    cut_off(film, 30, secure={30})
    known = {place_of(film): 30, place_of(tmp_path / "gone.mp4"): 9}
    for draws in (False, True):
        continued.begin(100, known, draws=draws)
        with Movie(film) as movie:
            assert (movie.written, continuing.frames_of_movies()[writer_of(movie).place]) == (30, 30)
        assert film.exists() == draws
        Movie(tmp_path / "gone.mp4").close()  # a film that was moved away in the meantime
    assert place_of(film) not in {movie.place for movie in continuing._held.values()}
    assert packets(film) == expected
    assert not partial(film).exists()
    before = film.read_bytes()
    Movie(film).close()  # already complete
    assert film.read_bytes() == before
    movie = Movie(film)
    writer_of(movie).continue_at(30)
    movie.close()
    assert packets(film) == expected


def test_a_stop_within_a_second_changes_the_film_until_that_second_ends(tmp_path):
    """The stopped film has one extra key frame; from the next second on, the bits are the same."""
    at, count = 31, 80
    uninterrupted = whole(tmp_path / "a.mp4", count)[0]
    film = tmp_path / "b.mp4"
    cut_off(film, at, secure={at})  # as a stop does, through its checkpoint
    go_on(film, at, count)
    stopped = packets(film)[0]
    assert stopped[:24] == uninterrupted[:24] and stopped[48:] == uninterrupted[48:]
    assert stopped[at:48] != uninterrupted[at:48]
    keys = [{k for k, (_, key, _) in enumerate(one) if key} for one in (uninterrupted, stopped)]
    assert keys[1] - keys[0] == {at}
    same_pictures = zip(decoded(tmp_path / "a.mp4"), decoded(film), strict=True)
    assert max(float(np.abs(a - b).mean()) for a, b in same_pictures) < 3, "of 255: what the codec loses"
