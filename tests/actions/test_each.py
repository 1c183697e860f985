"""Actions whose numbers are expressions, ids in expressions, and vectors with curves as components."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest
from acting import after, born, cloud

import motes
from motes import actions, shapes
from motes.errors import ArgumentError
from motes.expressions import choose, column

FALL = motes.Curve([(0, 0), (1, -10)])


def state() -> dict[str, Any]:
    dice = np.random.default_rng(3)
    sizes = {"size": dice.uniform(0.1, 2, (500, 3)), "rotational_velocity": dice.normal(0, 2, (500, 3))}
    return {**cloud(500), **sizes}


SAME: list[tuple[actions.Action, actions.Action]] = [
    (actions.Gravity((1, -9.8, 2)), actions.Gravity((1, -9.8 + 0 * column("size").x, 2))),
    (actions.Wind((1, 2, 3), 0.7), actions.Wind((1, 2, 3), 0.7 + 0 * column("size").x)),
    (actions.Wind((1, 2, 3), 900), actions.Wind((1, 2 + 0 * column("size").y, 3), 900)),
    (actions.Damping((0.5, 0.7, 0.1), 1, 4), actions.Damping((0.5, 0.7, 0.1), 1 + 0 * column("age"), 4)),
    (
        actions.RotationalDamping((0.5, 0.7, 0.1)),
        actions.RotationalDamping((0.5, 0.7 + 0 * column("age"), 0.1)),
    ),
]


@pytest.mark.parametrize(("numbers", "expression"), SAME)
def test_expressions_of_constants_give_the_bits_of_numbers(numbers: Any, expression: Any):
    given = state()
    plain, each = after(given, numbers, frames=3), after(given, expression, frames=3)
    assert plain.velocity.tobytes() == each.velocity.tobytes()
    assert plain.rotational_velocity.tobytes() == each.rotational_velocity.tobytes()
    moved = plain.velocity, plain.rotational_velocity
    assert any(
        (now != np.float32(given[name])).any()
        for now, name in zip(moved, ("velocity", "rotational_velocity"), strict=True)
    )


def test_each_particle_has_its_own_numbers():
    given = state()
    v, size = given["velocity"], np.float64(given["size"])
    p = after(given, actions.Gravity(column("size") * (0, -3, 1)))
    np.testing.assert_allclose(p.velocity, v + 0.1 * size * (0, -3, 1), atol=1e-5)
    p = after(given, actions.Wind((2, 0, 0), drag=3 / column("size").x), dt=0.5)
    part = 1 - np.exp(-0.5 * 3 / size[:, :1])
    np.testing.assert_allclose(p.velocity, v + (np.array((2, 0, 0)) - v) * part, atol=1e-5)
    p = after(given, actions.Damping(column("size") / 4, min_speed=column("size").y))
    fast = np.linalg.norm(v, axis=1) >= size[:, 1]
    np.testing.assert_allclose(
        p.velocity, np.where(fast[:, None], v - v * (1 - size / 4) * 0.1, v), atol=1e-5
    )
    p = after(given, actions.Gravity((0, -1, 0) * column("size"), where=shapes.Sphere((0, 0, 0), 2)))
    inside = np.linalg.norm(given["position"], axis=1) < 2
    assert ((p.velocity != np.float32(v)).any(axis=1) == inside).all()
    inside = choose(shapes.Sphere((0, 0, 0), 2), 1, 0)  # a shape of the expression, and one of where
    both = after(given, actions.Gravity((0, inside, 0), where=shapes.Box((0, -9, -9), (9, 9, 9))))
    wanted = (np.linalg.norm(given["position"], axis=1) < 2) & (given["position"][:, 0] > 0)
    assert ((both.velocity != np.float32(v)).any(axis=1) == wanted).all()


@pytest.mark.parametrize(
    "action",
    [
        actions.Gravity((0, 1 / column("age"), 0)),
        actions.Wind((column("age") / column("age"), 0, 0), 1),
        actions.Wind((1, 1, 1), column("age") / column("age")),
        actions.Wind((1, 1, 1), column("age") - 1),
        actions.Damping((0.5, 0.5, column("age") / column("age"))),
        actions.Damping((0.5, 0.5, 0.5), max_speed=column("age") / column("age")),
    ],
)
def test_numbers_that_are_not_usable_change_nothing(action: actions.Action):
    given = state()
    assert after(given, action).velocity.tobytes() == np.float32(given["velocity"]).tobytes()


def test_such_actions_are_values():
    first = actions.Wind((1, 0, 0), drag=2 / column("size").x)
    again = actions.Wind((1, 0, 0), drag=2 / column("size").x)
    other = actions.Wind((1, 0, 0), drag=3 / column("size").x)
    assert first == again and hash(first) == hash(again) and first != other
    assert first != actions.Wind((1, 0, 0), drag=2)
    assert pickle.loads(pickle.dumps(first)) == first and copy.deepcopy(first) == first
    assert "column('size')" in repr(first) and eval(repr(first), {**vars(actions), "column": column}) == first


WRONG: list[tuple[Any, str]] = [
    (lambda s: s.gravity(column("nothing")), "column"),
    (lambda s: s.gravity(column("age")), "acceleration must be a vector"),
    (lambda s: s.gravity((0, column("size"), 0)), "component"),
    (lambda s: s.gravity((0, column("age"), 0, 1)), "acceleration"),
    (lambda s: s.gravity((0, column("age"), "down")), "acceleration"),
    (lambda s: s.gravity(column("size") > 1), "acceleration|comparison"),
    (lambda s: s.gravity((0, 1 / (0 * column("age") + 1) / 0, 0)), "no division by 0"),
    (lambda s: s.wind((0, 0, 0), column("velocity")), "drag must be one number"),
    (lambda s: s.wind((0, column("age"), 0), -1), "drag must be"),
    (lambda s: s.damping((1, 1, 1), min_speed=column("size")), "min_speed must be one number"),
    (lambda s: s.damping(column("age")), "damping must be a vector"),
]


@pytest.mark.parametrize(("record", "message"), WRONG, ids=range(len(WRONG)))
def test_wrong_expressions_are_named(record: Any, message: str):
    world = motes.World(progress="off")
    s = world.system("all")
    with world, pytest.raises(ArgumentError, match=message):
        record(s)


# --- ids


def started(first: int, count: int, *recorded: actions.Action) -> motes.Particles:
    """Return particles with ids from `first` on, after some actions."""
    world = motes.World(seed=3, dt=0.1, progress="off", births="calculators")
    s = world.system("all", capacity=first + count + 1)
    with world:
        if first:
            s.burst((0, 0, 0), count=first)
            s.sink(shapes.Plane((0, 9, 0), (0, 1, 0)))
            world.step()
        s.burst((0, 0, 0), count=count)
        s.apply(list(recorded))
        world.step()
        return s.gather()


def test_ids_are_columns_of_expressions():
    ids = np.arange(100)
    p = started(0, 100, actions.Set("mass", 2 * column("id") + 1), actions.Set("alpha", column("id") % 7))
    assert p.mass.tolist() == (2 * ids + 1).tolist() and p.alpha.tolist() == (ids % 7).tolist()
    p = started(0, 100, actions.Gravity((0, column("id"), 0), where=column("id") > 50))
    np.testing.assert_allclose(p.velocity[:, 1], np.where(ids > 50, ids * 0.1, 0), rtol=1e-6)
    p = started(0, 100, actions.Law(set={"mass": column("id") % 3, "alpha": column("id")}))
    assert p.mass.tolist() == (ids % 3).tolist() and p.alpha.tolist() == ids.tolist()
    p = started(0, 100, actions.Law(set={"mass": motes.expressions.a.id}))
    assert p.mass.tolist() == ids.tolist()
    world = motes.World(progress="off")
    s = world.system(
        "all",
        sprite=motes.Sprite(
            "image", image=np.zeros((2, 4, 4), np.uint8), tiles=(2, 1), pick=column("id") % 2
        ),
    )
    with world:
        s.burst((0, 0, 0), count=10)
        world.step()
        assert s.total(column("id")) == 45 and s.total(1, where=column("id") < 3) == 3
        assert s.histogram(column("id") % 2, [0, 1, 2]).tolist() == [5, 5]


def test_large_ids_keep_their_remainders_and_comparisons():
    first, count = 2**24 - 3, 9
    ids = first + np.arange(count)
    sets = [
        ("mass", column("id") % 7, ids % 7),
        ("alpha", np.mod(column("id"), 2**24), ids % 2**24),
        ("age", choose(column("id") < 2**24 + 1, 1, 0), ids < 2**24 + 1),
        ("lifetime", choose(column("id") >= 2**24 + 3, 1, 0), ids >= 2**24 + 3),
    ]
    more = [
        ("mass", choose(column("id") == 2**24 + 1, 1, 0), ids == 2**24 + 1),
        ("alpha", choose(column("id") > 2**24 + 1, 1, 0), ids > 2**24 + 1),
        ("age", choose(column("id") != 2**24 + 2, 1, 0), ids != 2**24 + 2),
        ("lifetime", choose(column("id") <= 2**24, 1, 0), ids <= 2**24),
    ]
    for chosen in (sets, more):
        p = started(first, count, *(actions.Set(name, value) for name, value, _ in chosen))
        assert p.id.tolist() == ids.tolist()
        for name, _, wanted in chosen:
            assert getattr(p, name).tolist() == wanted.astype(float).tolist(), name


def test_pairs_have_no_ids():
    world = motes.World(progress="off")
    s = world.system("all")
    with world:
        with pytest.raises(ArgumentError, match="not read ids"):
            s.interact(1, velocity=(column("id"), 0, 0))
        with pytest.raises(ArgumentError, match="attribute must be one of"):
            s.set(id=3)


# --- curves as components


def test_vectors_may_have_curves_as_components():
    world = motes.World(
        seed=1,
        dt=0.25,
        progress="off",
        renderer=motes.Renderer(8, 8, camera=motes.Camera((FALL, 2, 5), (0, 0, 0))),
    )
    s = world.system("all")
    camera, light = world.renderer.camera, motes.Light((1, FALL, 0), (1, 1, 1), 1)
    with world:
        assert camera.position(0.5) == (-5.0, 2.0, 5.0) and light.position(1) == (1.0, -10.0, 0.0)
        for frame in world.frames(4):
            s.configure(
                velocity=(0, FALL, 1), color=motes.Uniform((0, 0, 0), (motes.Curve([(0, 0), (1, 1)]), 1, 1))
            )
            s.burst((0, 0, 0), count=1)
            s.gravity((frame, FALL * 2, [5][0]))
            world.step()
        p = s.gather()
    at = np.arange(4) * 0.25
    added = np.cumsum((2 * 0.25 * FALL_AT(at))[::-1])[::-1]
    np.testing.assert_allclose(p.velocity[:, 1], FALL_AT(at) + added, atol=1e-5)
    assert (p.color[0] == (0, p.color[0, 1], p.color[0, 2])).all()
    moving = motes.Curve([(0, (1, 2, 3)), (1, (2, 3, 4))]) + (0, FALL, 0)
    assert moving(1) == (2.0, -7.0, 4.0) and ((FALL, 1) * FALL)(1) == (100.0, -10.0)


def FALL_AT(times: Any) -> np.ndarray:  # noqa: N802
    return np.array([FALL(float(t)) for t in times])


def test_components_and_expressions_mix():
    p = after(
        {"position": [(0, 0, 0)] * 2, "mass": [1, 2]}, actions.Gravity((column("mass"), FALL + 1, 0)), dt=1.0
    )
    np.testing.assert_allclose(p.velocity, [(1, 1, 0), (2, 1, 0)])


WRONG_PARTS: list[tuple[Any, str]] = [
    (lambda: actions.Gravity((0, motes.Curve([(0, (0, 0, 0))]), 0)), r"vector\[1\]"),
    (lambda: actions.Gravity((0, FALL)) and actions.Gravity((FALL,)), "acceleration must be 3 numbers"),
    (lambda: actions.Gravity((0, FALL, "x")), "acceleration must be 3 numbers"),
    (lambda: actions.Gravity((0, motes.Curve([(0, 1), (1, 1e300)]), 0)), "acceleration"),
    (lambda: actions.Wind((0, FALL, 0), (1, FALL)), "drag must be a number"),
    (lambda: motes.Camera((FALL, 0, 0, 0), (0, 0, 0)), "position"),
    (lambda: born(shapes.Point((0, 0, 0)), 1, velocity=(FALL, 0, 0, 0)), "velocity"),
    (lambda: born(shapes.Point((0, 0, 0)), 1, mass=(FALL, 0, 0)), "mass"),
]


@pytest.mark.parametrize(("make", "message"), WRONG_PARTS, ids=range(len(WRONG_PARTS)))
def test_wrong_components_are_named(make: Any, message: str):
    with pytest.raises(ArgumentError, match=message):
        make()
