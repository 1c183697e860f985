"""What a checkpoint holds besides particles: births that can be made again, no frame that failed."""

from __future__ import annotations

import pytest
from launching import python, said
from standing import on_ranks

from motes._checkpoint import folder

BORN_OF_MESHES = """
import os, sys, motes
from motes import column, shapes
world = motes.World(seed=1, progress="off", checkpoint=motes.Checkpoint(sys.argv[1], every=2))
s = world.system("s")
with world:
    for frame in world.frames(8):
        if frame == int(os.environ.get("KILL", -1)):
            os._exit(9)
        if frame == 0:
            corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
            solid = motes.Mesh(corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], solid=True)
            s.configure(velocity=motes.Mesh(corners, [(0, 1, 2)]))
            s.burst(solid | shapes.Sphere((3, 0, 0), 1), count=50)
            s.burst(solid.at((5, 0, 0)), count=50)
        s.move()
        world.step()
    s.set(color=column("position_b"))
    s.set(size=column("velocity_b"))
    world.step()
    print("digest", world.digest(), s.total(column("position_b").x))
"""


def test_births_of_meshes_are_made_again_where_another_run_goes_on(tmp_path):
    """Which never constructs these meshes."""
    whole = on_ranks(1, BORN_OF_MESHES, tmp_path / "a")
    assert python(BORN_OF_MESHES, tmp_path / "b", env={"KILL": "6"}).code == 9
    again = on_ranks(2, BORN_OF_MESHES, tmp_path / "b")
    assert said(again.err, "motes: goes on with frame 4")
    assert set(said(again.out, "digest")) == set(said(whole.out, "digest")), again.text


FAILS_AT_THE_END = """
import resource, sys, motes
from motes import shapes
world = motes.World(seed=1, progress="off", checkpoint=motes.Checkpoint(sys.argv[1], every=2))
s, sparks = world.system("s"), world.system("sparks")
with world:
    for frame in world.frames(3):
        s.source(shapes.Sphere((0, 0, 0), 1), rate=2400)
        if frame == 2 and "calculator" in world.role:
            now = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
            resource.setrlimit(resource.RLIMIT_AS, (now + 400_000_000, resource.RLIM_INFINITY))
        if frame == 2:
            s.spawn(into=sparks, on="birth", count=1_000_000)
        s.move()
        world.step()
"""


@pytest.mark.parametrize("ranks", [1, 3])
def test_a_frame_that_failed_is_in_no_checkpoint(tmp_path, ranks):
    """Also where the last one did so after all had agreed on it: there is no memory for the children."""
    result = on_ranks(ranks, FAILS_AT_THE_END, tmp_path)
    assert result.code != 0
    assert "MemoryError" in result.err, result.text
    assert [frame for frame, _ in folder.whole(tmp_path)] == [2]
