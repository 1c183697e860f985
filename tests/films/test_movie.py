"""Movies are complete or absent, and hold the frames that were written."""

from __future__ import annotations

import base64
import importlib.util
import os
import re
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

import motes
from motes._film import growing, segment
from motes._film.movie import Movie, writer_of
from motes._picture.frame import Frame
from motes.errors import ArgumentError, MotesError

av = pytest.importorskip("av")


def frames(count: int, *, height: int = 48, width: int = 64) -> list[Frame]:
    """Return frames of one colour each, all different."""
    colours = np.random.default_rng(1).integers(30, 220, (count, 3), np.uint8)
    return [Frame(k, k / 24, np.broadcast_to(colours[k], (height, width, 3)).copy()) for k in range(count)]


def read(path) -> tuple[list[np.ndarray], float]:
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert stream.codec_context.name == "h264"
        assert stream.codec_context.pix_fmt == "yuv420p"
        rate = float(stream.average_rate)
        # Older PyAV assumes BT.601 for any movie unless it is given two different colour spaces.
        told = {"format": "rgb24", "src_colorspace": "ITU709", "dst_colorspace": "ITU601"}
        decoded = [frame.reformat(**told) for frame in container.decode(stream)]
        return [frame.to_ndarray() for frame in decoded], rate


@pytest.mark.parametrize("suffix", [".mp4", ".mkv", ".mov"])
def test_frames_come_back(tmp_path, suffix):
    written = frames(12)
    path = tmp_path / "new" / f"a{suffix}"
    with Movie(path, fps=25, crf=1) as movie:
        for frame in written:
            movie.write(frame)
            assert not path.exists()
    assert os.listdir(path.parent) == [path.name]
    shown, rate = read(path)
    assert rate == 25
    assert len(shown) == 12
    for frame, picture in zip(written, shown, strict=True):
        assert np.abs(picture.astype(int) - frame.pixels).max() <= 4


def test_odd_sizes_are_made_even(tmp_path):
    written = frames(2, height=33, width=35)
    with Movie(tmp_path / "a.mp4") as movie:
        for frame in written:
            movie.write(frame)
    shown, _ = read(tmp_path / "a.mp4")
    assert shown[0].shape == (34, 36, 3)
    assert np.abs(shown[0].astype(int) - written[0].pixels[0, 0]).max() < 20, "of the frame's colour"


def test_fractional_rates(tmp_path):
    with Movie(tmp_path / "a.mp4", fps=24000 / 1001) as movie:
        for frame in frames(3):
            movie.write(frame)
    assert read(tmp_path / "a.mp4")[1] == pytest.approx(24000 / 1001)


def test_a_notebook_shows_a_closed_movie(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    movie = Movie("out/a film.mp4")
    movie.write(frames(1)[0])
    assert movie._repr_html_() is None  # not before the movie is complete
    movie.close()
    shown = movie._repr_html_()
    content = base64.b64decode(re.search('src="data:video/mp4;base64,([^"]*)"', shown)[1])
    assert content == Path("out/a film.mp4").read_bytes()
    monkeypatch.setattr("motes._film.page.MOST_BYTES", 10)
    assert 'src="out/a%20film.mp4"' in movie._repr_html_()
    Path("out/a film.mp4").unlink()
    assert movie._repr_html_() is None
    with pytest.raises(KeyError), Movie("b.mp4") as broken:
        broken.write(frames(1)[0])
        raise KeyError
    assert broken._repr_html_() is None


def test_plain_arrays_may_be_reused(tmp_path):
    canvas = np.empty((32, 32, 3), np.uint8)
    with Movie(tmp_path / "a.mp4", crf=1) as movie:
        for value in (50, 100, 150):
            canvas[:] = value
            movie.write(canvas)
    assert [int(picture.mean().round()) for picture in read(tmp_path / "a.mp4")[0]] == pytest.approx(
        [50, 100, 150], abs=2
    )


def test_frames_of_another_rank_touch_nothing(tmp_path):
    threads = threading.active_count()
    with Movie(tmp_path / "new" / "a.mp4") as movie:
        for k in range(3):
            movie.write(Frame(k, 0.0, None, home=0, rank=1))
    assert not list(tmp_path.iterdir())
    assert threading.active_count() == threads


def test_leaving_by_an_exception_keeps_the_partial_film(tmp_path):
    with pytest.raises(KeyError), Movie(tmp_path / "a.mp4") as movie:
        for frame in frames(30):
            movie.write(frame)
        raise KeyError
    writer_of(movie)._thread.join()
    assert os.listdir(tmp_path) == ["a.partial.mp4"]
    assert len(read(tmp_path / "a.partial.mp4")[0]) == 30
    with Movie(tmp_path / "a.mp4") as movie:  # the next movie starts empty
        movie.write(frames(1)[0])
    assert os.listdir(tmp_path) == ["a.mp4"]
    assert len(read(tmp_path / "a.mp4")[0]) == 1


def test_closing_twice_and_writing_after(tmp_path):
    movie = Movie(tmp_path / "a.mp4")
    movie.write(frames(1)[0])
    movie.close()
    movie.close()
    assert len(read(tmp_path / "a.mp4")[0]) == 1
    with pytest.raises(MotesError, match="is closed"):
        movie.write(frames(1)[0])


def test_an_error_of_the_encoder_reaches_the_script(tmp_path):
    (tmp_path / "file").touch()
    movie = Movie(tmp_path / "file" / "a.mp4")
    with pytest.raises(MotesError, match=r"a.mp4 could not be written"):
        for frame in frames(8):
            movie.write(frame)


def test_an_error_at_the_end_reaches_close(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(growing.files.os, "replace", full)
    movie = Movie(tmp_path / "a.mp4")
    movie.write(frames(1)[0])
    with pytest.raises(MotesError, match="No space left"):
        movie.close()
    assert not list(tmp_path.iterdir())  # not even the partial film could be renamed


def test_the_queue_is_bounded(tmp_path, monkeypatch):
    go = threading.Event()
    picture = segment.picture
    monkeypatch.setattr(segment, "picture", lambda pixels: go.wait() and picture(pixels))
    movie = Movie(tmp_path / "a.mp4")
    for frame in frames(5):
        movie.write(frame)  # one is being encoded, four are queued: no call has to wait for the encoder
    sixth = threading.Thread(target=movie.write, args=frames(1))
    sixth.start()
    sixth.join(0.3)
    assert sixth.is_alive(), "the sixth frame waits for a place in the queue"
    go.set()
    sixth.join()
    movie.close()
    assert len(read(tmp_path / "a.mp4")[0]) == 6


def test_all_frames_have_one_size(tmp_path):
    with Movie(tmp_path / "a.mp4") as movie:
        movie.write(frames(1)[0])
        with pytest.raises(ArgumentError, match=r"size of the first frame"):
            movie.write(frames(1, height=50)[0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"path": "a.avi"}, "path must be a name ending in .mp4, .mkv, .mov, .webm, .gif or .webp"),
        ({"fps": 0}, "fps must be a finite number in 0.001..10000, got 0"),
        ({"fps": float("nan")}, "fps must be a finite number in 0.001..10000, got nan"),
        ({"crf": 99}, "crf must be a finite number in 0..51, got 99"),
        ({"preset": "quick"}, "preset must be 'ultrafast' or 'superfast'"),
    ],
)
def test_wrong_arguments(arguments, message):
    with pytest.raises(ArgumentError, match=message):
        Movie(**{"path": "a.mp4", **arguments})


def test_without_pyav_every_rank_is_told_what_to_install(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(motes.MissingExtraError, match=r'pip install "\.\[video\]"'):
        Movie("a.mp4")


SCRIPT = """
import sys
import numpy as np
from motes._picture.frame import Frame
from motes._film.movie import Movie
movie = Movie(sys.argv[1])
for k in range(10):
    movie.write(Frame(k, 0.0, np.full((32, 32, 3), 10 * k, np.uint8)))
if sys.argv[2] == "raise":
    raise KeyError("of the script")
"""


@pytest.mark.parametrize(("end", "code"), [("fall off", 0), ("raise", 1)])
def test_a_script_that_forgets_to_close_ends_and_keeps_its_movie(tmp_path, end, code):
    argv = [sys.executable, "-c", SCRIPT, str(tmp_path / "a.mp4"), end]
    ended = subprocess.run(argv, capture_output=True, text=True, timeout=60)
    assert ended.returncode == code, ended.stderr
    assert len(read(tmp_path / "a.mp4")[0]) == 10
