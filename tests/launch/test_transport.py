"""Messages with a real MPI: over TCP, and without single-copy transfers by the kernel.

In both cases a large message progresses only while both ends call MPI. Also pictures in memory shared by the
ranks of a host, which need no message.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from launching import command, mpirun
from standing import on_ranks

from motes import analysis
from motes._launch import starting

PIXELS_TRAVEL = {"MOTES_SHARED_PICTURES": "0"}
BOTH_ENDS = [{"OMPI_MCA_btl": "self,tcp"}, {"OMPI_MCA_smsc": "^cma"}]

FILM = """
import sys
import motes
from motes import Camera, Renderer, Sprite
from motes.shapes import Box

camera = Camera((0, 2, 12), (0, 2, 0))
renderer = Renderer(640, 360, camera=camera, path="tiles")
with motes.World(
    seed=3, roles="shared", renderer=renderer, progress="off", log=sys.argv[1]
) as world:
    sparks = world.system("sparks", sprite=Sprite(blend="add", pixels=5))
    sparks.configure(velocity=Box((-9, -1, -1), (9, 3, 1)))
    for frame in world.frames(4):
        sparks.burst(Box((-6, 0, -2), (6, 4, 2)), count=20_000)
        sparks.gravity((0, -9.81, 0))
        sparks.move()
        picture = world.render()
        if picture:
            print(frame, picture.digest(), flush=True)
"""


def test_mpi_leaves_memory_alone_that_was_given_back(abandoned_waits: Path):
    result = command(starting.command(2, [str(abandoned_waits)]), env=BOTH_ENDS[0], timeout=60)
    assert result.lines == ["memory is as it was"], result.text


@pytest.mark.parametrize("env", [{}, *BOTH_ENDS], ids=["usual", "tcp", "no copies"])
def test_messages_travel_while_a_rank_computes(progress_program: Path, tmp_path: Path, env):
    argv = starting.command(2, [str(progress_program), str(tmp_path / "sign")])
    result = command(argv, env=env, timeout=90)
    assert result.lines == ["messages travelled"], result.text


@pytest.mark.parametrize("env", BOTH_ENDS, ids=["tcp", "no copies"])
@pytest.mark.parametrize("ranks", [2, 3])
def test_a_film_is_the_same_whatever_carries_it(tmp_path, ranks, env):
    alone = on_ranks(1, FILM, tmp_path)
    assert len(alone.lines) == 4, alone.text
    assert mpirun(ranks, FILM, tmp_path, env={**env, **PIXELS_TRAVEL}).lines == alone.lines


def test_ranks_of_one_host_draw_into_memory_that_they_share(tmp_path):
    shared = on_ranks(3, FILM, tmp_path / "shared")
    sent = on_ranks(3, FILM, tmp_path / "sent", env=PIXELS_TRAVEL)
    assert len(shared.lines) == 4 and shared.lines == sent.lines, shared.text + sent.text
    pixels = 640 * 360 * 3 * 2 / 3  # bytes of the ranks other than the image generator
    shared_bytes, sent_bytes = (
        analysis.open_run(tmp_path / name).frames["render_bytes"] for name in ("shared", "sent")
    )
    assert (sent_bytes - shared_bytes > pixels / 2).all()
