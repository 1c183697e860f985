"""Reading in the middle of a frame does not change results; writing there takes effect."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from standing import on_ranks

import motes
from motes.expressions import column
from motes.shapes import Plane, Sphere

SCENE = Path(__file__).parents[1] / "scenes" / "reads.py"
WAYS = ["l01234", "g1,a4", "s01234", "g01234,l01234,d01234,a5"]
SETTINGS = [
    ("--births", "calculators", "--roles", "shared"),
    ("--combine", "one_by_one"),
    ("--combine", "overlapped", "--roles", "shared"),
]


@cache
def without_reads(substeps: int) -> list[str]:
    lines = on_ranks(1, SCENE, "", "--substeps", substeps).lines
    assert len(lines) == 7
    assert int(lines[-1].split()[2]) > 1000, "children live"
    assert int(lines[-1].split()[3]) > 0, "and some were dropped"
    return lines


@pytest.mark.parametrize("ranks", [pytest.param(1, marks=pytest.mark.slow), 3])
@pytest.mark.parametrize("way", WAYS)
def test_reads_change_no_bit(way, ranks):
    assert on_ranks(ranks, SCENE, way).lines == without_reads(1)


@pytest.mark.parametrize("ranks, way", [(1, "g01234,l01234,d01234"), (3, "l1,d2,g3,s4"), (5, "l01234")])
def test_reads_change_no_bit_with_substeps(ranks, way):
    assert on_ranks(ranks, SCENE, way, "--substeps", 3).lines == without_reads(3)


@pytest.mark.parametrize("settings", SETTINGS, ids=" ".join)
@pytest.mark.parametrize("ranks", [pytest.param(2, marks=pytest.mark.slow), 5])
def test_reads_change_no_bit_however_ranks_share_the_work(ranks, settings):
    assert on_ranks(ranks, SCENE, "l0123,d3,g4", *settings).lines == without_reads(1)


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
    one = on_ranks(1, WRITES.replace("WRITE", write)).lines
    assert one != on_ranks(1, WRITES.replace("WRITE", "p.velocity")).lines
    assert on_ranks(4, WRITES.replace("WRITE", write)).lines == one


def test_a_preview_that_is_written_behind_its_back_raises():
    world = motes.World(seed=1, dt=0.1, substeps=2, progress="off")
    s = world.system("s")
    with world:
        s.burst(Sphere((0, 0, 0), 1), count=5)
        s.gravity((0, -1, 0))
        with pytest.raises(motes.MotesError, match="write into the view itself"), s.local() as p:
            memoryview(p.velocity)  # bypasses the checks of the view
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


def filled(substeps: int) -> tuple[motes.World, motes.System]:
    """Return a world with one system, not yet open."""
    world = motes.World(seed=1, dt=0.1, substeps=substeps, progress="off")
    return world, world.system("s")


def burst(s: motes.System) -> None:
    s.configure(velocity=Sphere((0, 0, 0), 1))
    s.burst(Sphere((0, 0, 0), 1), count=50)
    s.gravity((0, -1, 0))


@pytest.mark.parametrize("substeps", [1, 3])
def test_what_is_recorded_while_a_read_is_open_runs_behind_what_it_wrote(substeps):
    digests = []
    for inside in (False, True):
        world, s = filled(substeps)
        with world:
            burst(s)
            with s.local() as p:
                p.velocity[:, 0] += np.float32(1)
                if inside:
                    s.damping((0.5, 0.5, 0.5))
            if not inside:
                s.damping((0.5, 0.5, 0.5))
            s.move()
            world.step()
            digests.append(world.digest())
    assert digests[0] == digests[1]


@pytest.mark.parametrize("substeps", [1, 3])
def test_birth_values_that_a_read_names_first_are_those_of_births(substeps):
    world, s = filled(substeps)
    with world:
        burst(s)
        with s.local() as p:
            assert len(p) == 50
        squares = column("velocity_b").x ** 2
        assert s.total(squares) > 1, "they were born with velocities"
        with s.local() as p:
            at_birth = np.sum(p.velocity_b[:, 0].astype(float) ** 2)
            p.velocity[:] = 0
        s.move()
        world.step()
        assert s.total(squares) == pytest.approx(at_birth)


def test_birth_values_that_are_recorded_while_a_read_is_open_are_those_of_births():
    world, s = filled(2)
    with world:
        burst(s)
        with s.local() as p:
            s.set(velocity=column("velocity_b"))
            p.velocity[:] = 0
        world.step()
        assert s.total(column("velocity").x ** 2) > 1


def test_a_sum_of_birth_values_leaves_an_open_read_as_it_is():
    world, s = filled(2)
    with world:
        burst(s)
        with s.local() as p:
            p.age[:] = 7
            s.total(column("velocity_b"))
            p.age[:] += 1
        world.step()
        assert s.total(1, where=column("age") == 8) == 50


FAILS = """
import os, sys
import motes
from motes.shapes import Sphere

world = motes.World(seed=1, dt=0.1, substeps=int(sys.argv[1]), progress="off")
s = world.system("s")

calls = []

def act(p):
    calls.append(p)
    if world.rank == int(sys.argv[2]) and len(calls) == 1 + ("writes" in sys.argv):
        raise KeyError("no such thing")

with world:
    s.burst(Sphere((0, 0, 0), 1), count=500)
    s.gravity((0, -1, 0))
    s.callback(act)
    for _ in range(2):
        try:
            with s.local() as p:
                if "writes" in sys.argv:
                    p.age[:] += 1
                    s.gravity((0, -1, 0))
        except KeyError:
            os.write(1, b"caught\\n")
        except RuntimeError as error:
            assert "no such thing" in str(error)
    s.move()
    world.step()
    print("went on")
"""


@pytest.mark.parametrize("how", [(1,), (2,), (2, "writes")])
@pytest.mark.parametrize("ranks, rank", [(1, 0), (3, 2)])
def test_a_list_that_fails_while_it_is_read_does_not_run_again(how, ranks, rank):
    """Half of the list has run. (With sub-steps, a write makes it run again when the block ends.)"""
    result = on_ranks(ranks, FAILS, how[0], rank, *how[1:])
    assert result.code != 0
    assert result.out.count("caught") == 1
    assert "went on" not in result.out
    assert "no such thing" in result.err
    assert "terminate" not in result.text and "Aborted" not in result.text


@pytest.mark.parametrize("read", [False, True])
@pytest.mark.parametrize("substeps, wanted", [(1, [10]), (2, [10, 10, 7])])
def test_a_birth_behind_a_callback_is_none_of_its_particles(read, substeps, wanted):
    """This holds in the birth's sub-step, with or without a read in between."""
    seen = []
    world, s = filled(substeps)
    with world:
        s.burst(Sphere((0, 0, 0), 1), count=10)
        world.step()
        s.callback(lambda p: seen.append(len(p)))
        if read and substeps == 1:
            s.total(1)
        s.burst(Sphere((0, 0, 0), 1), count=7)
        world.step()
    assert sorted(seen, reverse=True) == wanted


def test_birth_values_that_come_into_use_while_they_are_shown_are_no_writing():
    world, s = filled(3)
    with world:
        burst(s)
        with s.local() as p:
            assert not p.velocity_b.any()
            assert s.total(column("velocity_b").x ** 2) > 1
        world.step()
