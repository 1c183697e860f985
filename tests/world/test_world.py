"""One world in one process: births, distributions, views, counts, progress, misuse."""

from __future__ import annotations

import math
import re
import sys
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from launching import python

import motes
from motes import actions, shapes
from motes._run.progress import Progress, line
from motes._world.world import session_of

CAMERA = motes.Camera((0, 0, 5), (0, 0, 0))


def world_of(**arguments: Any) -> motes.World:
    """Make a world without progress output."""
    return motes.World(**{"seed": 1, "progress": "off", **arguments})


@pytest.fixture
def world():
    return world_of()


# --- births


@pytest.mark.parametrize("rate", [0, 0.5, 23.7, 24, 48, 1000 / 3])
@pytest.mark.parametrize("substeps", [1, 3])
def test_a_source_emits_by_the_formula(rate, substeps):
    world = world_of(substeps=substeps)
    s = world.system("a")
    with world:
        for frame in world.frames(50):
            s.source((0, 0, 0), rate=rate)
            world.step()
            exact = Fraction(rate) * (frame + 1) / 24
            assert s.count == s.born == math.floor(exact + Fraction(1, 10**9))


@pytest.mark.parametrize("substeps", [1, 3])
@pytest.mark.parametrize("dt", [1 / 24, 0.1, 1 / 7])
def test_a_source_of_the_frame_rate_emits_one_per_frame_forever(dt, substeps):
    world = motes.World(seed=1, dt=dt, substeps=substeps, progress="off")
    systems = [world.system(f"{k}") for k in (1, 2, 5)]
    with world:
        for frame in world.frames(1000):
            for k, s in zip((1, 2, 5), systems, strict=True):
                s.source((0, 0, 0), rate=k / dt)
            world.step()
            assert [s.born for s in systems] == [frame + 1, 2 * (frame + 1), 5 * (frame + 1)]


def test_ids_are_birth_numbers_in_the_order_of_calls(world):
    s = world.system("a")
    with world:
        for frame in world.frames(2):
            s.burst((1, 0, 0), count=3)
            s.emit(position=[(2, 0, 0), (2, 1, 0)])
            s.burst((3, 0, 0))
            world.step()
            p = s.gather()
            assert p.id.tolist() == list(range(6 * (frame + 1)))
            assert p.position[-6:, 0].tolist() == [1, 1, 1, 2, 2, 3]


def test_births_above_the_capacity_are_dropped_and_counted(world):
    s = world.system("a", capacity=10)
    with world:
        s.burst((0, 0, 0), count=7)
        s.burst((1, 0, 0), count=7)
        world.step()
        assert (s.count, s.dropped, s.born) == (10, 4, 10)
        s.kill_old(-1)  # all that were alive before; the next call comes after it
        s.burst((0, 0, 0), count=3)
        world.step()
        assert (s.count, s.dropped) == (0, 7), "the dead of this frame count until its end"
        s.burst((0, 0, 0), count=10)
        world.step()
        assert (s.count, s.dropped) == (10, 7)


def test_reading_in_the_middle_changes_no_capacity(world):
    s = world.system("a", capacity=100)
    with world:
        for _ in world.frames(2):
            s.burst((0, 0, 0), count=30)
            world.digest()
            s.burst((0, 0, 0), count=30)
            s.gather()
            world.step()
        assert (s.count, s.dropped) == (100, 20)


def test_births_take_part_in_what_follows_their_call(world):
    s = world.system("a")
    with world:
        s.burst((0, 0, 0))
        s.gravity((24, 0, 0))
        s.burst((0, 0, 0))
        s.move()
        s.burst((0, 0, 0))
        world.step()
        p = s.gather()
    assert p.velocity[:, 0].tolist() == pytest.approx([1, 0, 0])
    assert p.age.tolist() == pytest.approx([1 / 24, 1 / 24, 0])


def test_jitter_spreads_births_over_the_frame():
    world = world_of(dt=0.5)
    s = world.system("a")
    with world:
        s.configure(velocity=(2, 0, 0))
        s.source((0, 0, 0), rate=20_000, jitter=True)
        world.step()
        p = s.gather()
    assert 0 <= p.age.min() < 0.001
    assert 0.499 < p.age.max() < 0.5
    assert p.age.mean() == pytest.approx(0.25, abs=0.01)
    np.testing.assert_allclose(p.position[:, 0], 2 * p.age, rtol=1e-6)


# --- values of newborn particles


def test_what_newborns_get_by_default(world):
    s = world.system("a", attributes={"heat": 0.5, "wind": (1, 2, 3)})
    with world:
        s.burst((1, 2, 3))
        world.step()
        p = s.gather()
    assert p.position.tolist() == [[1, 2, 3]]
    assert p.velocity.tolist() == p.rotational_velocity.tolist() == [[0, 0, 0]]
    assert p.up.tolist() == [[0, 1, 0]]
    assert p.color.tolist() == p.size.tolist() == [[1, 1, 1]]
    assert (p.alpha[0], p.mass[0], p.age[0], p.lifetime[0]) == (1, 1, 0, np.inf)
    assert p.heat.tolist() == [0.5]
    assert p.wind.tolist() == [[1, 2, 3]]
    assert p.id.dtype == np.uint64
    assert p.position.dtype == np.float32


def test_distributions(world):
    n = 40_000
    s = world.system("a", attributes={"heat": 0.0})
    with world:
        s.configure(
            velocity=motes.Normal((1, 2, 3), (0.5, 1, 2)),
            color=motes.Uniform((0, 0.25, 0.5), (1, 0.75, 0.5)),
            mass=motes.Uniform(2, 4),
            alpha=motes.Normal(0.5, 0.1),
            heat=motes.Uniform(-1, 1),
            rotational_velocity=shapes.Sphere((0, 0, 0), 2, 1),
            size=0.5,
        )
        s.configure(lifetime=3)  # each call adds settings
        s.burst(shapes.Box((0, 1, 2), (1, 3, 5)), count=n)
        world.step()
        p = s.gather()
    margin = 5 / math.sqrt(n)  # five sigma of a mean
    np.testing.assert_allclose(p.velocity.mean(0), (1, 2, 3), atol=2 * margin)
    np.testing.assert_allclose(p.velocity.std(0), (0.5, 1, 2), rtol=0.02)
    third = ((p.velocity - p.velocity.mean(0)) / p.velocity.std(0)) ** 3
    assert np.abs(third.mean(0)).max() < 4 * margin, "not skew"
    assert np.abs(np.corrcoef(p.velocity.T) - np.eye(3)).max() < margin
    assert p.color.min(0) == pytest.approx([0, 0.25, 0.5], abs=1e-3)
    assert p.color.max(0) == pytest.approx([1, 0.75, 0.5], abs=1e-3)
    np.testing.assert_allclose(p.color.mean(0), (0.5, 0.5, 0.5), atol=margin)
    assert p.mass.mean() == pytest.approx(3, abs=2 * margin)
    assert p.alpha.std() == pytest.approx(0.1, rel=0.02)
    assert abs(p.heat.mean()) < margin
    turn = np.linalg.norm(p.rotational_velocity, axis=1)
    assert 1 - 1e-5 < turn.min() < turn.max() < 2 + 1e-5
    assert (turn**3).mean() == pytest.approx(4.5, rel=0.02), "uniform by volume"
    np.testing.assert_allclose(p.position.mean(0), (0.5, 2, 3.5), atol=3 * margin)
    assert set(p.lifetime) == {3}
    assert np.unique(p.size) == 0.5


def test_columns_with_one_value_take_no_memory(world):
    s = world.system("a")
    with world:
        s.configure(color=(1, 0, 0), lifetime=5, velocity=(0, 1, 0))
        s.burst(shapes.Box((0, 0, 0), (1, 1, 1)), count=100_000)
        world.step()
        assert session_of(world).engine.memory_bytes(0) < 100_000 * (8 + 12) * 1.6, "ids and positions"
        s.gravity((0, -1, 0))
        s.move()
        world.step()
        moved = session_of(world).engine.memory_bytes(0)
        assert moved < 100_000 * (8 + 12 + 12 + 4) * 1.6, "velocities and ages are there now"
        with s.local() as p:
            assert p.color.tolist()[:1] == [[1, 0, 0]]
        assert session_of(world).engine.memory_bytes(0) > moved


# --- reading and writing


def test_views_of_local_particles(world):
    s = world.system("a", attributes={"heat": 0.5})
    with world:
        s.burst(shapes.Box((0, 0, 0), (1, 1, 1)), count=5)
        with s.local() as p:
            assert len(p) == 5
            assert p.position.shape == (5, 3)
            p.heat[:] = p.id
            p.velocity[2] = (1, 2, 3)
            with pytest.raises(ValueError, match="read-only"):
                p.id[0] = 9
            with pytest.raises(AttributeError, match="no attribute 'nonsense'; there are id, position"):
                _ = p.nonsense
            kept = p.position
        with pytest.raises(motes.MotesError, match="inside `with"):
            _ = p.position
        with pytest.raises(ValueError, match="read-only"):
            kept[0, 0] = 1
        world.step()
        q = s.gather()
    assert q.heat.tolist() == [0, 1, 2, 3, 4]
    assert q.velocity[q.id == 2].tolist() == [[1, 2, 3]]
    assert kept.shape == (5, 3), "memory that a script still holds lives on"


def test_local_runs_what_was_recorded_so_far(world):
    s = world.system("a")
    with world:
        s.configure(velocity=(24, 0, 0))
        s.burst((0, 0, 0))
        s.move()
        with s.local() as p:
            assert p.position[0, 0] == pytest.approx(1)
        s.move()
        world.step()
        assert s.gather().position[0, 0] == pytest.approx(2)


def test_gather_is_sorted_and_a_copy(world):
    s = world.system("a")
    with world:
        s.burst(shapes.Sphere((0, 0, 0), 1), count=200)
        s.sink(shapes.Plane((0, 0, 0), (0, 1, 0)))
        world.step()
        p = s.gather()
        assert p
        assert 0 < len(p) == s.count < 200
        assert (np.diff(p.id.astype(np.int64)) > 0).all()
        p.position[:] = 7
        assert (s.gather(to="all").position < 2).all()
        assert "velocity" in dir(p)
        with pytest.raises(AttributeError, match="nonsense"):
            _ = p.nonsense
    empty = motes.Particles(None)
    assert not empty
    assert len(empty) == 0


def test_the_recorded_list(world):
    s = world.system("a")
    with world:
        s.gravity((0, -1, 0))
        s.apply([actions.Move(), actions.KillOld(age_limit=2)])
        assert s.recorded == [
            actions.Gravity(acceleration=(0, -1, 0)),
            actions.Move(),
            actions.KillOld(age_limit=2),
        ]
        s.recorded.clear()
        assert len(s.recorded) == 3
        world.step()
        assert s.recorded == []


def test_actions_do_what_they_say(world):
    s = world.system("a")
    with world:
        s.emit(position=[(0, 0, 0)] * 4, velocity=[(1, 0, 0), (2, 0, 0), (3, 0, 0), (0, 0, 0)])
        s.damping((0.5, 1, 1), min_speed=1.5, max_speed=2.5)
        world.step()
        kept = 1 - 0.5 / 24
        assert s.gather().velocity[:, 0].tolist() == pytest.approx([1, 2 * kept, 3, 0])
        s.random_velocity(shapes.Box((5, 5, 5), (6, 6, 6)))
        world.step()
        assert ((s.gather().velocity >= 5) & (s.gather().velocity <= 6)).all()
        with s.local() as p:
            p.position[p.id == 1] = (0, 9, 0)
        s.sink(shapes.Box((-1, 8, -1), (1, 10, 1)), inside=False)
        world.step()
        assert s.gather().id.tolist() == [1]


def test_orientations_turn_with_move(world):
    s = world.system("a")
    with world:
        s.configure(rotational_velocity=(24, 0, 0))
        s.burst((0, 0, 0))
        s.move(rotational=False)
        s.move()
        world.step()
        assert s.gather().up.tolist() == [[1, 1, 0]]


# --- facts, pictures, misuse


def test_facts_of_a_world_of_one():
    world = world_of(dt=0.25, space=(-1, 1))
    s = world.system("a")
    assert (world.rank, world.size, world.calculators, world.seed) == (0, 1, (0,), 1)
    assert world.role == {"manager", "image_generator", "calculator"}
    assert (s.count, s.born, world.frame, world.timings) == (0, 0, 0, {})
    with pytest.raises(motes.MotesError, match="inside"):
        _ = s.cuts
    with world:
        for frame in world.frames(3):
            assert (world.frame, world.time) == (frame, frame * 0.25)
            world.step()
            assert s.cuts.shape == (0,)
        assert {"t_create_s", "t_act_s", "t_exchange_s", "t_render_s", "t_frame_s"} <= set(world.timings)
        assert all(seconds >= 0 for seconds in world.timings.values())
    assert repr(s).startswith("<System 'a'")


def test_a_frame_with_a_picture_is_the_same_as_without():
    digests = []
    for picture in (True, False):
        world = world_of(renderer=motes.Renderer(32, 24, camera=CAMERA))
        s = world.system("a")
        with world:
            for _ in world.frames(3):
                s.source(shapes.Box((-1, -1, -1), (1, 1, 1)), rate=500)
                s.random_acceleration(shapes.Sphere((0, 0, 0), 9))
                s.move()
                frame = world.render() if picture else world.step()
            digests.append(world.digest())
        if picture:
            assert frame.pixels.shape == (24, 32, 3)
            assert frame.pixels.any()
            assert (frame.index, frame.time) == (2, 3 * (1 / 24))
    assert digests[0] == digests[1]


def test_misuse_is_reported(world):
    s = world.system("a")
    with pytest.raises(motes.MotesError, match="inside `with world:`"):
        s.gravity((0, 0, 0))
    with pytest.raises(motes.MotesError, match="inside `with world:`"):
        world.step()
    with pytest.raises(motes.MotesError, match="inside `with world:`"):
        world.digest()
    with world:
        with pytest.raises(motes.ArgumentError, match="renderer"):
            world.render()
        late = world.system("late")
        late.burst((0, 0, 0))
        world.step()
        assert late.count == 1
    late = (lambda: s.burst((0, 0, 0)), lambda: world.system("b"), lambda: world.frames(5))
    for call in (world.step, world.digest, s.gather, *late):
        with pytest.raises(motes.MotesError):
            call()
    with pytest.raises(motes.MotesError, match="runs once"), world:
        pass


@pytest.mark.parametrize("steps", [0, 2])
def test_each_turn_of_the_loop_is_one_frame(steps):
    with world_of() as world, pytest.raises(motes.MotesError, match="frame 0 must end with one"):
        for _ in world.frames(3):
            for _ in range(steps):
                world.step()


def test_an_exception_leaves_the_block_as_it_is():
    world = world_of()
    with pytest.raises(ZeroDivisionError), world:
        _ = 1 / 0
    with pytest.raises(motes.MotesError):
        world.step()


def test_say_prints_once(capsys, world):
    world.say("hello")
    assert capsys.readouterr().out == "hello\n"


def test_a_seed_that_was_drawn_is_announced(capsys):
    seeds = set()
    for _ in range(2):
        world = motes.World(progress="lines")
        assert world.seed is None
        with world:
            pass
        told = re.search(r"^seed (\d+)$", capsys.readouterr().err, re.MULTILINE)
        assert told is not None
        assert int(told[1]) == world.seed
        seeds.add(world.seed)
    assert len(seeds) == 2


# --- progress


ROW = {
    "frame": 119,
    "particles": 1_931_000,
    "imbalance": 1.0753,
    "slowest_rank": 5,
    "exchanged": 4012,
    "dropped": 0,
}


def test_a_line_of_progress():
    wanted = "frame 120/300  40%  2.1 fps  eta 1:26  1.93 M particles  LB 0.93  slowest r5  moved 4 012"
    assert line(ROW, total=300, fps=2.1) == wanted
    assert line({**ROW, "particles": 12, "dropped": 3}, total=0, fps=2.1, host="b3") == (
        "frame 120  2.1 fps  12 particles  LB 0.93  slowest r5(b3)  moved 4 012  dropped 3"
    )


def test_progress_shows_at_most_one_line_a_second(capsys, monkeypatch):
    now = [1000.0]
    clock = SimpleNamespace(monotonic=lambda: now[0])
    monkeypatch.setattr(sys.modules[Progress.__module__], "time", clock)  # only its clock, not the process's
    progress = Progress("lines")
    for frame in range(40):
        now[0] += 0.1
        progress.update({**ROW, "frame": frame}, total=40)
    progress.update({**ROW, "frame": 40}, total=40, last=True)
    shown = [int(text.split("/")[0].split()[1]) for text in capsys.readouterr().err.splitlines()]
    assert shown[-1] == 41
    assert 4 <= len(shown) <= 6
    assert all(b - a >= 10 for a, b in zip(shown[:-2], shown[1:-1], strict=True))


def test_progress_ways(capsys, monkeypatch):
    rows: list[dict[str, Any]] = []
    for way in ("off", rows.append):
        world = motes.World(seed=1, progress=way)
        with world:
            for _ in world.frames(4):
                world.step()
    assert [row["frame"] for row in rows] == [0, 1, 2, 3]
    assert {"frame", "particles", "exchanged", "imbalance", "t_frame_s"} <= set(rows[0])
    assert capsys.readouterr().err == ""
    monkeypatch.setenv("MOTES_PROGRESS", "off")
    motes.World(progress="lines")
    monkeypatch.setenv("MOTES_PROGRESS", "loud")
    with pytest.raises(motes.ArgumentError, match="MOTES_PROGRESS must be lines, bar or off, got 'loud'"):
        motes.World()


def test_the_last_frame_of_a_run_is_shown(capsys):
    world = motes.World(seed=1, progress="lines")
    with world:
        for _ in world.frames(3):
            world.step()
    shown = capsys.readouterr().err.splitlines()
    assert shown[-1].startswith("frame 3/3  100%"), shown


def test_an_unknown_instruction_set_is_refused():
    script = "import motes\nmotes.shapes.Box((0, 0, 0), (1, 1, 1)).sample(1)"
    result = python(script, env={"MOTES_SIMD": "mmx"})
    assert result.code != 0
    wanted = "MOTES_SIMD must be sse2, avx2, avx512 or neon, got 'mmx'"
    assert wanted in result.err.splitlines()[-1], result.text
