"""`sort`: the drawing order, on one rank and on several; nothing else changes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from standing import on_ranks

import motes
from motes import actions
from motes.errors import ArgumentError
from motes.expressions import column
from motes.shapes import Box

EYE, LOOK = (0, 1, 9), (0.5, -0.25, -3)

SCENE = """
import sys
import numpy as np
import motes
from motes.expressions import column
from motes.shapes import Box, Plane, Sphere

SORTS = "sorts" in sys.argv
world = motes.World(seed=4, dt=0.1, substeps=2, space=(-2, 2), roles="shared", progress="off")
dust, chips = world.system("dust", attributes={"heat": 0.0}), world.system("chips")
eye, look = np.array((0, 1, 9)), np.array((0.5, -0.25, -3))

def in_order(p):
    if not SORTS:
        return
    distance = (p.position.astype(np.float64) - eye) @ look
    wanted = np.lexsort((p.id, -distance))
    assert (wanted == np.arange(len(p))).all(), (world.rank, world.frame)

with world:
    for frame in world.frames(8):
        dust.configure(velocity=Sphere((0, 0, 0), 3), lifetime=motes.Uniform(0.2, 0.6))
        dust.source(Box((-2, 0, -2), (2, 2, 2)), rate=4000)
        dust.burst((0, 1, 1))  # two at one place: the id decides
        dust.burst((0, 1, 1))
        dust.set(heat=column("age") * 2)
        dust.spawn(into=chips, on="death", count=2)
        dust.spawn(into=chips, on="collision", count=1, inherit_velocity=0.5)
        if SORTS:
            dust.sort(eye, look=look)
        dust.bounce(Plane((0, 0, 0), (0, 1, 0)))
        dust.move()
        dust.kill_expired()
        if frame % 3 == 2:
            with dust.local() as p:
                in_order(p)
        dust.gravity((0, -5, 0))
        world.step()
        with dust.local() as p:  # what other ranks sent is in order too
            in_order(p)
        world.say(f"{frame} {world.digest()} {dust.count} {chips.count}")
    assert dust.count > 500 and chips.count > 500
"""


def test_one_two_three_and_five_ranks_sort_and_nothing_else_changes():
    alone = on_ranks(1, SCENE).lines
    assert len(alone) == 8
    for ranks in (1, 2, 3, 5):
        assert on_ranks(ranks, SCENE, "sorts", timeout=60).lines == alone, f"{ranks} ranks"


def sorted_views(**wish: Any) -> tuple[dict[str, np.ndarray], motes.Particles]:
    """Return columns as `local` shows them after a sort, and the particles from `gather`."""
    world = motes.World(seed=2, progress="off")
    system = world.system("only", attributes={"heat": 0.0, "wind": (0, 0, 0)})
    with world:
        system.configure(velocity=Box((-1, -1, -1), (1, 1, 1)), color=(1, 0, 0))
        system.burst(Box((-1, -1, -1), (1, 1, 1)), count=1500)
        system.set(heat=column("position").x, wind=column("velocity") * 2)
        system.sort(EYE, look=LOOK, **wish)
        with system.local() as p:
            columns = ("id", "position", "velocity", "heat", "wind", "color")
            seen = {name: np.array(getattr(p, name)) for name in columns}
        return seen, system.gather()


def test_all_columns_follow_their_particle():
    seen, gathered = sorted_views()
    np.testing.assert_array_equal(gathered.id, np.arange(1500))
    assert (seen["id"] != gathered.id).mean() > 0.9
    for name, values in seen.items():
        np.testing.assert_array_equal(values, getattr(gathered, name)[seen["id"].astype(int)])
    distance = (seen["position"].astype(np.float64) - EYE) @ LOOK
    assert (np.diff(distance) <= 0).all(), "far ones first"


@pytest.mark.parametrize("count", [300, 5000])
def test_hardly_different_and_equal_distances(count: int):
    dice = np.random.default_rng(8)
    z = dice.choice(np.float32([-300, -0.5, -0.0, 0, 1, 2, 1000]), count)
    position = np.stack([dice.integers(0, count // 2, count), np.zeros(count), z], axis=1)
    world = motes.World(progress="off")
    system = world.system("only")
    with world:
        system.emit(position=position)
        system.sort((0, 0, 0), look=(1e-12, 0, 1))
        with system.local() as p:
            found, ids = p.position.astype(np.float64), p.id.astype(int)
    distance = found[:, 0] * 1e-12 + found[:, 2]
    assert len(np.unique(distance)) > count / 3
    assert (np.lexsort((ids, -distance)) == np.arange(count)).all()


def test_those_for_which_the_condition_does_not_hold_keep_their_places():
    chosen = column("position").y > 0.25
    seen, gathered = sorted_views(where=chosen)
    rises = gathered.position[:, 1] > 0.25
    places = np.flatnonzero(rises)  # without a sort, ids are in order
    np.testing.assert_array_equal(seen["id"][~rises], gathered.id[~rises])
    np.testing.assert_array_equal(np.sort(seen["id"][places]), places)
    distance = (seen["position"].astype(np.float64) - EYE) @ LOOK
    assert (np.diff(distance[places]) <= 0).all()


def test_wrong_arguments_are_named():
    for given, message in (
        ({"eye": (0,), "look": LOOK}, "eye must be 3 numbers"),
        ({"eye": EYE, "look": (0, 0, 0)}, "look must not be zero"),
        ({"eye": EYE, "look": (0, float("nan"), 1)}, "look must be 3 finite numbers"),
    ):
        with pytest.raises(ArgumentError, match=message):
            actions.Sort(**given)
