"""Reading in the middle of a frame changes no result; what is written there counts."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from launching import mpirun

import motes
from motes.shapes import Plane, Sphere

SCENE = Path(__file__).parent / "scenes" / "reads.py"
WAYS = ["l01234", "g1,a4", "s01234", "g01234,l01234,d01234,a5"]
SETTINGS = [
    ("--births", "calculators", "--roles", "shared"),
    ("--combine", "one_by_one"),
    ("--combine", "overlapped", "--roles", "shared"),
]


@cache
def without_reads(substeps: int) -> list[str]:
    lines = mpirun(1, SCENE, "", "--substeps", substeps).lines
    assert len(lines) == 7
    assert int(lines[-1].split()[2]) > 1000, "children live"
    assert int(lines[-1].split()[3]) > 0, "and some were dropped"
    return lines


@pytest.mark.parametrize("ranks", [pytest.param(1, marks=pytest.mark.slow), 3])
@pytest.mark.parametrize("way", WAYS)
def test_reads_change_no_bit(way, ranks):
    assert mpirun(ranks, SCENE, way).lines == without_reads(1)


@pytest.mark.parametrize("ranks, way", [(1, "g01234,l01234,d01234"), (3, "l1,d2,g3,s4"), (5, "l01234")])
def test_reads_change_no_bit_with_substeps(ranks, way):
    assert mpirun(ranks, SCENE, way, "--substeps", 3).lines == without_reads(3)


@pytest.mark.parametrize("settings", SETTINGS, ids=" ".join)
@pytest.mark.parametrize("ranks", [pytest.param(2, marks=pytest.mark.slow), 5])
def test_reads_change_no_bit_however_ranks_share_the_work(ranks, settings):
    assert mpirun(ranks, SCENE, "l0123,d3,g4", *settings).lines == without_reads(1)


WRITES = """
import sys
import numpy as np
import motes
from motes.shapes import Sphere

world = motes.World(seed=1, dt=0.1, substeps=3, space=(-1, 1), progress="off")
s = world.system("s")
with world:
    for frame in world.frames(4):
        if frame == 0:
            s.configure(velocity=Sphere((0, 0, 0), 1))
            s.burst(Sphere((0, 0, 0), 1), count=500)
        s.random_acceleration(Sphere((0, 0, 0), 9))
        with s.local() as p:
            WRITE
        s.damping((0.5, 0.5, 0.5))
        s.move()
        world.step()
        world.say(world.digest())
"""
WRITTEN = [
    "p.velocity[p.position[:, 0] > 0.9] *= 2",  # some ranks have no such particle
    "p.velocity[:, 1] += np.float32(1)",
    "np.add.at(p.velocity, np.arange(len(p)), np.float32(1))",
    "np.copyto(p.age, 5)",
    "p.age.fill(5)",
    "v = p.velocity[:]; v -= np.float32(1)",
]


@pytest.mark.parametrize(
    "write", [*WRITTEN[:2], *(pytest.param(each, marks=pytest.mark.slow) for each in WRITTEN[2:])]
)
def test_what_is_written_between_substeps_counts_on_any_number_of_ranks(write):
    one = mpirun(1, WRITES.replace("WRITE", write)).lines
    assert one != mpirun(1, WRITES.replace("WRITE", "p.velocity")).lines
    assert mpirun(4, WRITES.replace("WRITE", write)).lines == one


def test_a_preview_that_is_written_behind_its_back_raises():
    world = motes.World(seed=1, dt=0.1, substeps=2, progress="off")
    s = world.system("s")
    with world:
        s.burst(Sphere((0, 0, 0), 1), count=5)
        s.gravity((0, -1, 0))
        with pytest.raises(motes.MotesError, match="write into the view itself"), s.local() as p:
            memoryview(p.velocity)  # what NumPy does not see
            np.asarray(p.velocity)[:] = 3


def test_a_preview_shows_the_living_after_all_substeps():
    world = motes.World(seed=1, dt=0.25, substeps=5, progress="off")
    s = world.system("s")
    with world:
        s.configure(age=motes.Uniform(0, 1))
        s.burst(Sphere((0, 9, 0), 1), count=200)
        world.step()
        s.gravity((0, -2, 0))
        s.kill_old(0.5)
        with s.local() as p:
            assert 0 < len(p) < 200
            np.testing.assert_allclose(p.velocity[:, 1], -0.5, rtol=1e-6)
        assert len(s.recorded) == 2
        s.bounce(Plane((0, 0, 0), (0, 1, 0)))
        world.step()
        assert len(s.gather()) < 200
