"""Sums over all particles: exact, and the same for any number of ranks, any threads and vector widths."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from same_bits import widths
from standing import COMMAND_LINE, on_ranks

import motes
from motes.expressions import column
from motes.shapes import Box, Sphere

SCENE = Path(__file__).parents[1] / "scenes" / "sums.py"


@cache
def alone(substeps: int = 1) -> list[str]:
    """Return the sums on one rank."""
    lines = on_ranks(1, SCENE, json.dumps({"substeps": substeps})).lines
    assert len(set(lines)) == len(lines) == 4
    return lines


SETTINGS = [{"roles": "shared", "space": (-2, 2)}, {"fan_out": 2, "substeps": 3, "axis": None}]


@pytest.mark.parametrize("ranks", [1, 2, 3, 5])
@pytest.mark.parametrize("settings", SETTINGS, ids=str)
def test_any_ranks(ranks: int, settings: dict[str, Any]):
    assert on_ranks(ranks, SCENE, json.dumps(settings)).lines == alone(settings.get("substeps", 1))


@pytest.mark.parametrize("ranks", [1, 2])
def test_any_threads(ranks: int):
    env = {"MOTES_THREADS": "3", "MOTES_GRAIN": "100"}
    assert on_ranks(ranks, SCENE, json.dumps({"space": (-2, 2)}), env=env).lines == alone()


@pytest.mark.parametrize("width", widths())
def test_any_vector_width(width: str):
    assert on_ranks(1, SCENE, "{}", env={"MOTES_SIMD": width}).lines == alone()


def emitted(count: int, seed: int) -> dict[str, NDArray[np.float32]]:
    """Return particles of all magnitudes."""
    rng = np.random.default_rng(seed)
    return {
        "position": rng.uniform(-1, 1, (count, 3)).astype(np.float32),
        "velocity": rng.normal(size=(count, 3)).astype(np.float32),
        "heat": (rng.uniform(-1, 1, count) * 10.0 ** rng.integers(-40, 38, count)).astype(np.float32),
    }


@pytest.fixture(scope="module")
def system():
    """Return a system of 20,000 particles in a world that stays open."""
    world = motes.World(seed=1, progress="off")
    made = world.system("gas", attributes={"heat": 0.0})
    with world:
        made.emit(**emitted(20_000, seed=2))
        world.step()
        yield made


def test_totals_are_those_of_fsum(system: motes.System):
    p = system.gather()
    heat = math.fsum(p.heat.tolist())
    assert system.total(column("heat")) == heat
    assert type(system.total(column("heat"))) is float
    assert heat != float(p.heat.astype(np.float64).sum()), "the sum needs more than double precision"
    squares = p.velocity * p.velocity
    speeds = np.sqrt(squares[:, 0] + squares[:, 1] + squares[:, 2])
    assert system.total(column("velocity").length()) == math.fsum(speeds.tolist())
    momentum = system.total(column("velocity"))
    assert momentum.tolist() == [math.fsum(p.velocity[:, i].tolist()) for i in range(3)]
    assert momentum.dtype == np.float64
    ball = Sphere((0, 0, 0), 0.7)
    inside = p.heat[ball.contains(p.position)]
    assert 0 < len(inside) < len(p)
    assert system.total(column("heat"), where=ball) == math.fsum(inside.tolist())
    assert system.total(1) == 20_000 and system.total((1, 0, -1)).tolist() == [20_000, 0, -20_000]


def test_totals_of_what_is_not_finite(system: motes.System):
    x = column("position").x
    assert math.isnan(system.total((x * 0 - 1).sqrt()))
    assert system.total(1 / (x * x * 0)) == math.inf
    assert system.total(-1 / (x * x * 0)) == -math.inf
    assert math.isnan(system.total(x / (x * x * 0))), "infinities of both signs"
    assert system.total(column("heat"), where=x > 5) == 0


@pytest.mark.parametrize(
    "edges",
    [np.linspace(-1, 1, 31), [-0.5, 0.1, 0.125, 0.9], [-np.inf, 0, np.inf], [-1e300, -1e-3, 1e-40, 2]],
    ids=str,
)
def test_histograms_are_those_of_numpy(system: motes.System, edges: Any):
    p = system.gather()
    x = p.position[:, 0]
    counts = system.histogram(column("position").x, edges)
    assert counts.dtype == np.int64
    assert counts.tolist() == np.histogram(x.astype(np.float64), np.asarray(edges))[0].tolist()
    hot = p.heat > 0
    heat = column("heat")
    weighted = system.histogram(column("position").x, edges, weights=heat / 2, where=heat > 0)
    bins = np.searchsorted(np.asarray(edges), x.astype(np.float64), side="right") - 1
    wanted = [math.fsum((p.heat[hot & (bins == i)] / np.float32(2)).tolist()) for i in range(len(counts))]
    assert weighted.tolist() == wanted


def test_tallies_are_those_of_numpy(system: motes.System):
    p = system.gather()
    low, high, shape = (-1, -0.5, 0.25), (0.5, 1, 0.75), (6, 5, 4)
    edges = [np.linspace(a, b, n + 1) for a, b, n in zip(low, high, shape, strict=True)]
    counts = system.tally(low, high, shape)
    wanted, _ = np.histogramdd(p.position.astype(np.float64), edges)
    assert counts.shape == shape and counts.dtype == np.int64
    assert np.array_equal(counts, wanted)
    below = system.tally(low, high, shape, where=column("heat") < 0)
    assert np.array_equal(below + system.tally(low, high, shape, where=column("heat") >= 0), counts)
    heat = system.tally(low, high, shape, weights=column("heat"))
    one = Box([e[2] for e in edges], [np.nextafter(np.float32(e[3]), -9, dtype=np.float32) for e in edges])
    assert heat.shape == shape and heat[2, 2, 2] == system.total(column("heat"), where=one) != 0


def test_a_cell_holds_its_lower_faces_only():
    world = motes.World(seed=1, progress="off")
    s = world.system("s")
    with world:
        s.emit(position=[(0, 0, 0), (1, 0, 0), (2, 0, 0), (2, 1, 1), (-1e-30, 0, 0)])
        assert s.tally((0, 0, 0), (2, 1, 1), (2, 1, 1)).tolist() == [[[1]], [[1]]]
        assert s.histogram(column("position").x, [0, 1, 2]).tolist() == [1, 3], "the last edge is closed"


def test_sums_see_what_a_script_would_read_there():
    world = motes.World(seed=1, progress="off")
    s = world.system("s")
    with world:
        s.configure(age=motes.Uniform(0, 2))
        s.burst(Box((0, 0, 0), (1, 1, 1)), count=1000)
        assert s.total(1) == 1000
        s.kill_old(1)  # the dead stay in memory, unseen, until the frame ends
        young = s.total(1)
        assert young == len(s.gather()) == s.histogram(column("age"), [0, np.inf]).sum() < 1000
        assert young == s.tally((0, 0, 0), (1, 1, 1), (1, 1, 1))[0, 0, 0]
        s.burst(Box((0, 0, 0), (1, 1, 1)), count=7)
        assert s.histogram(column("age"), [0, 1]).sum() > young


def test_a_million_cells():
    world = motes.World(seed=1, progress="off", threads=2)
    s = world.system("s")
    with world:
        s.configure(velocity=Sphere((0, 0, 0), 1))
        s.burst(Box((0, 0, 0), (1, 1, 1)), count=50_000)
        counts = s.tally((0, 0, 0), (1, 1, 1), (100, 100, 100))
        weighted = s.tally((0, 0, 0), (1, 1, 1), (100, 100, 100), weights=column("velocity").x)
        assert counts.sum() == 50_000 and np.array_equal(weighted != 0, counts != 0)
        assert math.isclose(weighted.sum(), s.total(column("velocity").x), rel_tol=1e-9)


def test_the_first_sum_that_names_a_copy_knows_where_particles_were_born():
    world = motes.World(seed=1, progress="off")
    s = world.system("s")
    with world:
        s.configure(velocity=(1, 0, 0))
        s.burst(Sphere((0, 0, 0), 1), count=100)
        born = s.total(column("position"))
        s.move()
        world.step()
        assert s.total(column("position_b")).tolist() == born.tolist() != s.total(column("position")).tolist()


def test_sums_in_callbacks_and_outside_the_world_are_refused():
    world = motes.World(seed=1, progress="off")
    s = world.system("s")
    with pytest.raises(motes.MotesError, match="total"):
        s.total(1)
    with pytest.raises(motes.MotesError, match="histogram"), world:
        s.burst((0, 0, 0), count=1)
        s.callback(lambda p: s.histogram(column("age"), [0, 1]))
        world.step()


OTHERS = """
import motes
from motes.expressions import column
world = motes.World(seed=1, progress="off")
s = world.system("s")
with world:
    s.burst((0, 0, 0), count=9)
    s.total(column("age"), where=column("age") > WHERE)
"""


def test_ranks_that_ask_for_different_sums_are_told():
    failed = on_ranks(3, OTHERS.replace("WHERE", "world.rank // 2"))
    assert failed.code != 0 and "different arguments: s, " in failed.err, failed.text
    other = OTHERS.replace("s.total(", "if world.rank == 1: s.gather()\n    s.total(").replace("WHERE", "0")
    failed = on_ranks(3, other)
    assert failed.code != 0 and "gather here, total there" in failed.err, failed.text


RECORDED = """
import motes
from motes.expressions import column
world = motes.World(seed=1, progress="off")
s = world.system("s")
with world:
    for frame in world.frames(3):
        s.burst((0, frame, 0), count=9)
        s.gravity((0, -1, 0))
        s.set(velocity=column("velocity") + s.total(column("position").y))
        s.move()
        print(world.frame, s.total(column("position")))
        world.step()
"""


def test_a_recording_computes_what_its_sums_read(tmp_path: Path):
    script = tmp_path / "script.py"
    script.write_text(RECORDED)
    recorded = on_ranks(1, COMMAND_LINE, "record", "-o", tmp_path / "x.motes", script)
    assert recorded.lines[:3] == on_ranks(1, script).lines


def test_near_names_are_suggested(system: motes.System):
    with pytest.raises(TypeError, match="'wieghts'; did you mean 'weights'"):
        system.histogram(column("heat"), [0, 1], wieghts=1)
