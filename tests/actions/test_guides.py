"""Vector fields on grids, and paths: what they do, how their tables reach other ranks, what is refused."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from acting import after, cloud
from launching import command
from same_bits import widths
from standing import COMMAND_LINE, alike, on_ranks

import motes
from motes import actions
from motes.expressions import column

LOW, HIGH = (-2.0, -1.0, 0.0), (2.0, 1.0, 3.0)


def nodes(shape: tuple[int, int, int]) -> np.ndarray:
    """Return the positions of a grid's nodes."""
    axes = [
        np.linspace(a, b, n) if n > 1 else np.array([a]) for a, b, n in zip(LOW, HIGH, shape, strict=True)
    ]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def inside(p: np.ndarray) -> np.ndarray:
    return ((p >= np.float32(LOW)) & (p <= np.float32(HIGH))).all(axis=1)


def affine(p: np.ndarray) -> np.ndarray:
    """Return a field that trilinear interpolation reproduces exactly, products included."""
    x, y, z = p[..., 0], p[..., 1], p[..., 2]
    return np.stack([1 + x - 2 * y + z * x, 3 * z * y, x * y * z - 1], axis=-1)


# --- fields


@pytest.mark.parametrize("shape", [(2, 2, 2), (5, 3, 9), (33, 2, 4)])
def test_a_field_is_trilinear_between_its_nodes(shape: tuple[int, int, int]):
    state = cloud(3000, scale=1.5)
    stir = actions.Field(grid=affine(nodes(shape)), low=LOW, high=HIGH, strength=2)
    v = after(state, stir, dt=0.25).velocity
    p, start = np.float32(state["position"]), np.float32(state["velocity"])
    held = inside(p)
    assert 300 < held.sum() < 2700
    np.testing.assert_array_equal(v[~held], start[~held])
    wanted = start.astype(np.float64) + 2 * 0.25 * affine(p.astype(np.float64))
    np.testing.assert_allclose(v[held], wanted[held], atol=1e-4)


def test_a_field_with_drag_is_a_wind():
    state = cloud(2000, scale=1.5)
    grid = np.broadcast_to(np.float32([3, -1, 2]), (4, 5, 6, 3))
    for dt in (0.01, 0.5, 50):
        blown = after(state, actions.Field(grid=grid, low=LOW, high=HIGH, drag=0.7), dt=dt).velocity
        wind = after(state, actions.Wind(velocity=(3, -1, 2), drag=0.7), dt=dt).velocity
        held = inside(np.float32(state["position"]))
        np.testing.assert_allclose(blown[held], wind[held], atol=1e-5)
        np.testing.assert_array_equal(blown[~held], np.float32(state["velocity"])[~held])


def test_nodes_and_borders_belong_to_the_field():
    shape = (3, 4, 2)
    grid = np.random.default_rng(3).normal(0, 5, (*shape, 3)).astype(np.float32)
    places = nodes(shape).reshape(-1, 3)
    v = after({"position": places}, actions.Field(grid=grid, low=LOW, high=HIGH), dt=1.0).velocity
    np.testing.assert_allclose(v, grid.reshape(-1, 3), rtol=1e-5, atol=1e-5)
    beyond = np.nextafter(np.float32(HIGH), np.float32(9))
    v = after(
        {"position": [beyond, (0, 0, np.nextafter(np.float32(0), np.float32(-1)))]},
        actions.Field(grid=grid, low=LOW, high=HIGH),
    ).velocity
    assert (v == 0).all()


def test_an_axis_with_one_node_is_constant():
    grid = affine(nodes((5, 1, 1)))
    state = {"position": [(0.5, y, z) for y in (-1, 0.3, 1) for z in (0, 1.7, 3)]}
    v = after(state, actions.Field(grid=grid, low=LOW, high=HIGH), dt=1.0).velocity
    assert (v == v[0]).all() and (v[0] != 0).any()


def test_particles_without_a_place_are_left_alone():
    grid = np.ones((2, 2, 2, 3))
    found = after(
        {"position": [(0, 0, 1)]},
        actions.Set(attribute="position", value=column("velocity") + 1e30),
        actions.Field(grid=grid, low=LOW, high=HIGH),
    )
    assert (found.velocity == 0).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"grid": np.ones((2, 2, 2))}, "grid must be finite numbers of shape"),
        ({"grid": np.ones((2, 2, 2, 2))}, "grid must be finite numbers of shape"),
        ({"grid": np.ones((0, 2, 2, 3))}, "grid must be finite numbers of shape"),
        ({"grid": "x"}, "grid must be finite numbers of shape"),
        (
            {"grid": np.where(np.arange(24).reshape(2, 2, 2, 3) == 5, np.nan, 0)},
            r"grid\[0, 0, 1, 2\] must be finite, got nan",
        ),
        ({"high": (2, -1, 3)}, r"high must be above low = \(-2.0, -1.0, 0.0\) in each component"),
        ({"low": (1e8, 0, 0), "high": (1e8 + 1, 1, 1)}, "high must be above low"),
        ({"drag": -1}, "drag must be a finite number >= 0"),
        ({"strength": float("nan")}, "strength must be a finite number"),
    ],
)
def test_wrong_fields_are_refused(arguments: dict[str, Any], message: str):
    with pytest.raises(motes.ArgumentError, match=message):
        actions.Field(**{"grid": np.ones((2, 2, 2, 3)), "low": LOW, "high": HIGH, **arguments})


def test_the_engine_refuses_tables_that_do_not_fit():
    core = motes._core
    numbers = {"low": LOW, "high": HIGH, "strength": 1, "drag": -1}
    eight = core.keep_table(np.ones((4, 8), np.float32), (4, 1, 1))
    for wrong in (
        lambda: core.Action("field", numbers, []),
        lambda: core.Action("field", numbers, [], table=eight),
        lambda: core.Action("field", numbers, [], table=12345),
        lambda: core.Action("gravity", {"acceleration": (0, 0, 0)}, [], table=eight),
        lambda: core.keep_table(np.ones(7, np.float32), (2, 1, 1)),
        lambda: core.keep_table(np.full(8, np.inf, np.float32), (1, 1, 1)),
        lambda: core.keep_table(np.ones(0, np.float32), (0, 1, 1)),
    ):
        with pytest.raises((motes.ArgumentError, ValueError)):
            wrong()


# --- paths


POINTS = [(0, 0, 0), (4, 0, 0), (4, 4, 0)]


def steered(x: np.ndarray, v: np.ndarray, points: Any, dt: float, **options: Any) -> np.ndarray:
    """Return the velocities after `follow_path`, by its formula in float64."""
    speed, strength = options["speed"], options.get("strength", 2)
    ends = np.array([*points, points[0]] if options.get("loop") else points, np.float64)
    ways = np.diff(ends, axis=0)
    lengths = np.linalg.norm(ways, axis=1)
    starts = np.concatenate([[0], np.cumsum(lengths)])
    a = min(options.get("look_ahead", 0.5), starts[-1])
    result = v.copy()
    for i, place in enumerate(x):
        along = np.clip(((place - ends[:-1]) * ways).sum(axis=1) / lengths, 0, lengths)
        near = ends[:-1] + ways * (along / lengths)[:, None]
        far = np.linalg.norm(place - near, axis=1)
        best = int(np.argmin(far))
        if far[best] > options.get("radius", np.inf):
            continue
        way = starts[best] + along[best] + a
        way = way % starts[-1] if options.get("loop") else min(way, starts[-1])
        k = min(int(np.searchsorted(starts, way, side="right")) - 1, len(ways) - 1)
        d = ends[k] + ways[k] * (way - starts[k]) / lengths[k] - place
        w = speed * d / max(float(np.linalg.norm(d)), a)
        result[i] = v[i] + (w - v[i]) * min(strength * dt, 1)
    return result


@pytest.mark.parametrize(
    "options",
    [
        {"speed": 3.0},
        {"speed": 3.0, "strength": 40.0, "look_ahead": 2.0},
        {"speed": 1.0, "radius": 1.5},
        {"speed": 2.0, "loop": True, "look_ahead": 1.25},
        {"speed": 2.0, "loop": True, "look_ahead": 99.0, "radius": 3.0},
    ],
)
def test_particles_are_steered_as_the_formula_says(options: dict[str, Any]):
    state = cloud(1500)
    x, v = (np.float64(np.float32(state[name])) for name in ("position", "velocity"))
    found = after(state, actions.FollowPath(points=POINTS, **options), dt=0.1).velocity
    wanted = steered(x, v, POINTS, 0.1, **options)
    wrong = np.abs(found - wanted).max(axis=1) > 1e-4
    assert wrong.mean() < 0.002  # equally near two points of the path, up to rounding
    if "radius" in options:
        assert 0.05 < (found == np.float32(v)).all(axis=1).mean() < 0.95


def test_particles_arrive_at_the_end_and_go_round_a_loop():
    def run(loop: bool) -> np.ndarray:
        world = motes.World(seed=1, dt=0.05, progress="off")
        s = world.system("s")
        places = []
        with world:
            for frame in world.frames(200):
                if frame == 0:
                    s.emit(position=[(0, 0.3, 0), (2, -0.5, 1)])
                s.follow_path(POINTS, speed=4, strength=8, loop=loop)
                s.move()
                world.step()
                places.append(s.gather().position.copy())
        return np.array(places)

    straight, around = run(False), run(True)
    assert np.linalg.norm(straight[-1] - (4, 4, 0), axis=1).max() < 0.01
    ahead = np.diff(around[100:, 0], axis=0)
    assert np.linalg.norm(ahead, axis=1).mean() > 0.1  # still moving at about 4 m/s
    assert around[100:, 0].max() < 4.6 and around[100:, 0].min() > -0.6
    crossed = np.diff(np.sign(around[:, 0, 0] - 2)) != 0
    assert crossed.sum() >= 4


def test_a_smooth_path_goes_through_its_points_and_bends_less():
    corner, close = {"position": [POINTS[1]]}, {"speed": 1, "look_ahead": 1e-2, "strength": 1e3}
    sharp = after(corner, actions.FollowPath(points=POINTS, **close)).velocity[0]
    smooth = after(corner, actions.FollowPath(points=POINTS, smooth=True, **close)).velocity[0]
    np.testing.assert_allclose(sharp, (0, 1, 0), atol=1e-3)
    # The tangent points from the previous to the next point.
    np.testing.assert_allclose(smooth, (0.7, 0.7, 0), atol=0.12)
    for point in POINTS[:2]:
        near = {"position": [point]}
        held = after(near, actions.FollowPath(points=POINTS, speed=1, radius=1e-4, smooth=True)).velocity
        assert (held != 0).any()


def test_of_two_places_that_are_equally_near_the_first_counts():
    places = np.array([(2.0, 2.0, 0), (3.0, 1.0, 0), (1.0, 3.0, 1)])
    found = after({"position": places}, actions.FollowPath(points=POINTS, speed=2), dt=0.1).velocity
    np.testing.assert_allclose(found, steered(places, np.zeros((3, 3)), POINTS, 0.1, speed=2.0), atol=1e-6)


def test_equal_points_count_once():
    doubled = [POINTS[0], POINTS[0], *POINTS[1:], POINTS[2]]
    state = cloud(200)
    one, two = (after(state, actions.FollowPath(points=p, speed=2)).velocity for p in (POINTS, doubled))
    np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"points": [(0, 0, 0)]}, "points must be finite numbers of shape"),
        ({"points": np.zeros((5000, 3))}, "2 <= n <= 4096"),
        ({"points": [(0, 0, 0), (0, 0, 0)]}, "points must be at least two different points"),
        ({"points": [(0, 0, 0), (0, np.nan, 0)]}, "points must be finite numbers within 1e15"),
        ({"speed": -1}, "speed must be a finite number >= 0"),
        ({"look_ahead": 0}, "look_ahead must be a finite number >= 1e-06"),
        ({"radius": -1}, "radius must be a number >= 0"),
        ({"loop": 1}, "loop must be True or False"),
    ],
)
def test_wrong_paths_are_refused(arguments: dict[str, Any], message: str):
    with pytest.raises(motes.ArgumentError, match=message):
        actions.FollowPath(**{"points": POINTS, "speed": 1, **arguments})


# --- equality, pickles, and tables on other ranks


def test_both_are_values():
    grid = np.random.default_rng(1).normal(0, 1, (2, 3, 4, 3))
    for make in (
        lambda: actions.Field(grid=grid, low=LOW, high=HIGH),
        lambda: actions.FollowPath(points=POINTS, speed=2, where=column("age") > 1),
    ):
        one, same = make(), make()
        assert one == same and hash(one) == hash(same)
        assert pickle.loads(pickle.dumps(one)) == one
    assert actions.Field(grid=grid, low=LOW, high=HIGH) != actions.Field(grid=grid + 1, low=LOW, high=HIGH)
    assert repr(actions.Field(grid=grid, low=(0, 0, 0), high=(1, 1, 1))).startswith(
        "Field(grid=<array of shape (2, 3, 4, 3)>"
    )
    kept = actions.Field(grid=grid, low=LOW, high=HIGH)
    before = after({"position": [(0, 0, 1)]}, kept).velocity
    grid[:] = 99
    np.testing.assert_array_equal(after({"position": [(0, 0, 1)]}, kept).velocity, before)
    moving = actions.Field(
        grid=np.ones((2, 2, 2, 3)), low=LOW, high=HIGH, strength=motes.Curve([(0, 2), (1, 4)])
    )
    assert moving._at_time(0.5).strength == 3


SCRIPT = """
import sys
import numpy as np
import motes
from motes.expressions import column
from motes.shapes import Sphere

grid = np.sin(np.arange(7 * 6 * 5 * 3.0)).reshape(7, 6, 5, 3) * 9
stir = motes.actions.Field(grid=grid, low=(-2, -2, -2), high=(2, 2, 2), where=column("age") > 0.1)
world = motes.World(seed=3, progress="off", digest=True)
s = world.system("s")
with world:
    for frame in world.frames(8):
        s.burst(Sphere((0, 0, 0), 1.5), count=500)
        s.apply(stir)
        s.field(grid[:2] + world.size * {unequal}, (-3, -3, -3), (3, 3, 3), drag=0.5)
        s.follow_path([(0, 0, 0), (2, 1, 0), (0, 2, 1)], 3, smooth=True, radius=1, loop=True)
        s.move()
        world.step()
        digest = world.digest()
        if world.rank == 0:
            print(digest)
"""


def test_the_same_bits_on_any_ranks_and_in_any_build():
    script = SCRIPT.format(unequal=0)
    alone = alike(script)
    assert len(set(alone)) == 8
    assert on_ranks(1, script, env={"MOTES_SIMD": widths()[0]}).lines == alone


def test_ranks_with_different_arrays_are_told():
    result = on_ranks(3, SCRIPT.format(unequal="(world.rank == 1)"))
    assert result.code != 0
    assert "ScriptMismatchError" in result.text


def test_scene_files_carry_the_tables(tmp_path: Path, motes_replay: Path):
    script, scene = tmp_path / "stirred.py", tmp_path / "stirred.motes"
    script.write_text(SCRIPT.format(unequal=0))
    assert on_ranks(1, COMMAND_LINE, "record", script, "-o", scene).lines
    replayed = command([motes_replay, scene, "--digest", "--no-images"]).lines
    assert [line.split()[1] for line in replayed] == on_ranks(1, script).lines
