"""Ranks wait for a rank that takes long to close a movie, but not for one that is stuck. Real jobs."""

from __future__ import annotations

import re

import pytest
from launching import mpirun, said
from standing import on_ranks

pytest.importorskip("av")

# The image generator takes `seconds` to close its movie: in the middle of the run, or after the last frame.
SCENE = """
import sys, time
import motes
from motes._film.movie import writer_of
from motes._io import files

seconds, roles, where = float(sys.argv[1]), sys.argv[2], sys.argv[3]
sync = files.sync

def slow(path):
    time.sleep(seconds)
    sync(path)

files.sync = slow
renderer = motes.Renderer(64, 48, camera=motes.Camera((0, 1, 8), (0, 1, 0)))
world = motes.World(seed=1, space=(-1, 1), roles=roles, renderer=renderer, progress="off")
sparks = world.system("sparks")
with world, motes.Movie(sys.argv[4]) as movie:
    for frame in world.frames(4):
        sparks.burst((0.5, 0, 0))
        sparks.move()
        movie.write(world.render())
        if frame == 1 and where == "middle":
            movie.close()
            movie = motes.Movie(sys.argv[4] + ".mp4")
            files.sync = sync
        if frame == 2 and where == "secured":
            writer_of(movie).secure()
            files.sync = sync
    if where == "stuck" and world.rank == 0:
        time.sleep(60)
world.say(f"done {sparks.count}")
"""


@pytest.mark.parametrize("where", ["end", pytest.param("middle", marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("ranks", "roles"),
    [
        pytest.param(2, "auto", marks=pytest.mark.slow),
        (3, "auto"),
        pytest.param(3, "shared", marks=pytest.mark.slow),
    ],
)
def test_closing_a_movie_does_not_count_as_a_stall(tmp_path, ranks, roles, where):
    film = tmp_path / "a.mp4"
    # Closing syncs twice, the file and its directory, which takes longer than the limit.
    result = on_ranks(ranks, SCENE, 1.5, roles, where, film, timeout=60, env={"MOTES_STALL_S": "2"})
    assert result.code == 0, result.text
    assert result.out.splitlines() == ["done 4"]
    assert film.stat().st_size > 0
    assert re.findall(r"motes: rank 0 .* is still (.*); the other ranks are waiting", result.err) == [
        "closing a.mp4"
    ]


@pytest.mark.slow
def test_securing_a_movie_does_not_count_as_a_stall(tmp_path):
    film = tmp_path / "a.mp4"
    result = on_ranks(3, SCENE, 3.0, "auto", "secured", film, timeout=60, env={"MOTES_STALL_S": "0.25"})
    assert result.code == 0, result.text
    assert result.out.splitlines() == ["done 4"]
    assert re.findall(r"motes: rank 0 .* is still (.*); the other ranks are waiting", result.err) == [
        "securing a.mp4"
    ]


def test_a_rank_that_is_stuck_is_not_waited_for(tmp_path):
    result = mpirun(3, SCENE, 0, "auto", "stuck", tmp_path / "a.mp4", timeout=50, env={"MOTES_STALL_S": "3"})
    assert result.code == 1, result.text
    (report,) = said(result.err, "*** motes: ")
    assert re.search(r"waited \d+ s for rank \d", report), result.text


def test_a_quick_close_says_nothing(tmp_path):
    result = on_ranks(3, SCENE, 0, "auto", "end", tmp_path / "a.mp4", timeout=50)
    assert (result.code, result.err) == (0, ""), result.text
