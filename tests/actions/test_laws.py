"""Laws written as expressions: what they compute, what they remember, and what they refuse."""

from __future__ import annotations

import copy
import pickle
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from random_lists import HEADER, expressions, scalars
from standing import alike, on_ranks

import motes
from motes import ArgumentError, actions, shapes
from motes import expressions as ex

A, B = ex.a, ex.b
DT = 0.01
Array = NDArray[Any]


def crowd(count: int = 300, seed: int = 1) -> dict[str, Array]:
    """Draw random particles in a cube with edges of 2 m."""
    rng = np.random.default_rng(seed)
    return {
        "position": rng.uniform(-1, 1, (count, 3)).astype(np.float32),
        "velocity": rng.normal(0, 1, (count, 3)).astype(np.float32),
        "mass": rng.uniform(0.5, 2, count).astype(np.float32),
        "heat": rng.uniform(0, 1, count).astype(np.float32),
    }


def played(
    record: Any, particles: dict[str, Array], *, steps: int = 1, substeps: int = 1, threads: int = 1
) -> motes.Particles:
    """Emit particles, call `record` in each step, and return the particles."""
    facts: dict[str, Any] = {"dt": DT * substeps, "substeps": substeps, "threads": threads}
    with motes.World(seed=3, progress="off", **facts) as world:
        system = world.system("one", attributes={"heat": 0, "wind": (0, 0, 0)})
        system.emit(**particles)
        world.step()
        for _ in range(steps):
            record(system)
            world.step()
        return system.gather()


def pairs_of(x: Array, radius: float) -> tuple[Array, Array, Array, Array]:
    """Return a, b, distance and normal of all pairs within the radius, in float64."""
    d = x[None].astype(float) - x[:, None].astype(float)
    r = np.sqrt((d * d).sum(-1))
    a, b = np.nonzero((r < radius) & ~np.eye(len(x), dtype=bool))
    with np.errstate(invalid="ignore"):
        return a, b, r[a, b], np.nan_to_num(d[a, b] / r[a, b][:, None])


def summed(values: Array, a: Array, count: int) -> Array:
    """Sum the values of all pairs of each a."""
    out = np.zeros((count, *values.shape[1:]))
    np.add.at(out, a, values)
    return out


def test_a_spring_and_dashpot_is_what_numpy_says():
    p, radius = crowd(), 0.3
    got = played(
        lambda s: s.interact(
            radius,
            acceleration=ex.normal
            * (-50 * (radius - ex.r) + 2 * ex.dot(ex.relative_velocity, ex.normal))
            / A.mass,
        ),
        p,
    )
    a, b, r, n = pairs_of(p["position"], radius)
    assert len(a) > 1000
    v = p["velocity"].astype(float)
    along = ((v[b] - v[a]) * n).sum(-1)
    pull = n * ((-50 * (radius - r) + 2 * along) / p["mass"][a])[:, None]
    np.testing.assert_allclose(got.velocity, v + DT * summed(pull, a, len(v)), rtol=1e-4, atol=1e-4)


def test_all_results_come_from_what_was_before():
    p = crowd()
    got = played(
        lambda s: s.interact(
            0.3,
            velocity=ex.where(B.heat > 0.5, B.velocity * 0.01, ex.cross(ex.normal, (0, 0, 0.1))),
            spin=(0, 0, 1),
            set={"heat": B.heat * B.mass, "wind": ex.length(B.position) * A.velocity},
        ),
        p,
    )
    a, b, _, n = pairs_of(p["position"], 0.3)
    count, v = len(p["mass"]), p["velocity"].astype(float)
    change = np.where((p["heat"] > 0.5)[b][:, None], v[b] * 0.01, np.cross(n, (0, 0, 0.1)))
    np.testing.assert_allclose(got.velocity, v + summed(change, a, count), rtol=1e-4, atol=1e-5)
    np.testing.assert_array_equal(got.spin[:, 2], np.bincount(a, minlength=count))
    np.testing.assert_allclose(got.heat, summed((p["heat"] * p["mass"])[b], a, count), rtol=1e-5)
    wind = np.linalg.norm(p["position"][b], axis=-1)[:, None] * v[a]
    np.testing.assert_allclose(got.wind, summed(wind, a, count), rtol=1e-4, atol=1e-5)


def test_where_says_who_changes_and_all_are_seen():
    p = crowd()
    got = played(lambda s: s.interact(0.3, set={"heat": 1.0}, where=A.mass > 1), p)
    a, _, _, _ = pairs_of(p["position"], 0.3)
    counted = np.bincount(a, minlength=len(p["mass"]))
    np.testing.assert_array_equal(got.heat, np.where(p["mass"] > 1, counted, p["heat"]))


def test_particles_at_the_same_place_have_no_normal():
    place = {"position": np.zeros((3, 3), np.float32)}
    got = played(lambda s: s.interact(0.5, velocity=ex.normal + (1, 0, 0), set={"heat": ex.r}), place)
    np.testing.assert_array_equal(got.velocity, [[2, 0, 0]] * 3)
    np.testing.assert_array_equal(got.heat, 0)


def test_what_is_not_finite_adds_nothing():
    p = {"position": np.array([[0, 0, 0], [0, 0, 0], [0.1, 0, 0]], np.float32)}
    got = played(lambda s: s.interact(0.5, velocity=(1 / ex.r, 0, ex.r / 0.1)), p)
    np.testing.assert_allclose(got.velocity, [[10, 0, 1], [10, 0, 1], [20, 0, 2]], rtol=1e-5)
    got = played(lambda s: s.law(velocity=A.velocity / A.heat, set={"wind": A.position / A.heat}), p)
    np.testing.assert_array_equal(got.velocity, 0)
    np.testing.assert_array_equal(got.wind, 0)


@pytest.mark.parametrize("widths", [{"n": 1}, {"n": 1, "way": 3, "x": 3, "y": 3, "z": 3}])
@pytest.mark.parametrize("skin", [0, 9])
def test_pairs_remember_while_they_are_within_the_radius(
    skin: float, widths: dict[str, int], monkeypatch: pytest.MonkeyPatch
):
    """Two particles meet, part and meet again: the count restarts, even if a list keeps the pair."""
    monkeypatch.setenv("MOTES_SKIN", str(skin))
    place = {
        "position": np.array([[0, 0, 0], [0.35, 0, 0], [5, 0, 0]], np.float32),
        "velocity": np.array([[0, 0, 0], [-1, 0, 0], [0, 0, 0]], np.float32),
    }
    last = list(widths)[-1]
    counts = []

    def record(s: motes.System) -> None:
        then = {name: getattr(A.state, name) + 1 for name in widths}
        read = getattr(A.state, last)
        s.interact(0.3, set={**then, "heat": ex.length(read) / np.sqrt(widths[last])}, state=widths)
        s.move()

    with motes.World(seed=1, dt=0.1, progress="off") as world:
        system = world.system("two", attributes={"heat": 0})
        system.emit(**place)
        for frame in range(14):
            record(system)
            if frame == 8:
                system.set(velocity=A.velocity * -1)
            world.step()
            heat = system.gather().heat
            assert heat[0] == heat[1], "both see the same"
            counts.append(round(float(heat[0])))
    assert counts == [0, 0, 1, 2, 3, 4, 5, 0, 0, 0, 0, 0, 0, 1]


def test_other_systems_are_seen_and_do_not_change():
    p = crowd(200)
    fox = {"position": p["position"][:40] * 0.9, "mass": p["mass"][:40]}
    with motes.World(seed=3, dt=DT, progress="off") as world:
        prey, foxes = (
            world.system("prey", attributes={"heat": 0}),
            world.system("foxes", attributes={"teeth": 0}),
        )
        prey.emit(**p)
        foxes.emit(**fox, teeth=np.arange(40))
        world.step()
        prey.interact(0.4, acceleration=-1 * ex.normal, set={"heat": B.teeth + A.mass * B.mass}, other=foxes)
        world.step()
        got, others = prey.gather(), foxes.gather()
    d = fox["position"][None].astype(float) - p["position"][:, None].astype(float)
    r = np.sqrt((d * d).sum(-1))
    a, b = np.nonzero(r < 0.4)
    fled = p["velocity"] - DT * summed(d[a, b] / r[a, b][:, None], a, 200)
    np.testing.assert_allclose(got.velocity, fled, rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(got.heat, summed(b + (p["mass"][a] * fox["mass"][b]), a, 200), rtol=1e-5)
    np.testing.assert_array_equal(others.velocity, 0)


BETWEEN = """
import hashlib
import numpy as np
import motes
from motes import expressions as ex
from motes import shapes

fast = {0!r}
dice = np.random.default_rng(2)
world = motes.World(
    seed=1, dt=0.02, substeps=20, periodic={{"y": (-1, 1)}}, space=(-1, 1), roles="shared", progress="off",
    balancer=motes.balance.PrefixCuts(threshold=0.01, min_particles=1),
)
prey, foxes = world.system("prey", axis="x"), world.system("foxes", axis="yz")
law = 20 * (0.25 - ex.r) * ex.normal + ex.b.velocity - ex.a.state.seen
with world:
    for frame in world.frames(6):
        if frame == 0:
            prey.emit(position=dice.uniform(-1, 1, (200, 3)), velocity=dice.uniform(-1, 1, (200, 3)))
            prey.emit(position=[(9, 0, 0)], velocity=[(fast, 0, 0)])
        if frame in (0, 3):
            foxes.emit(position=dice.uniform(-1, 1, (90, 3)), velocity=dice.uniform(-4, 4, (90, 3)))
        if frame == 4:
            foxes.sink(shapes.Box((-1, -1, -1), (-0.5, 1, 1)))
            prey.sink(shapes.Box((0, -1, -1), (1, 0, 1)))
        seen = {{"seen": ex.normal + 0.5 * ex.a.state.seen}}
        prey.interact(0.25, acceleration=law, set=seen, state={{"seen": 3}}, other=foxes)
        foxes.interact(0.2, acceleration=ex.normal, other=prey)
        foxes.interact(0.1, acceleration=-9 * ex.normal)
        prey.move()
        foxes.move()
        world.step()
        p, f = prey.gather(to="all"), foxes.gather(to="all")
        near = p.id != 200
        found = np.concatenate([p.position[near], p.velocity[near], f.position, f.velocity])
        print(hashlib.sha256(found.tobytes()).hexdigest()) if world.rank == 0 else None
"""


def test_lists_of_two_systems_are_kept_and_change_no_bit():
    """A fast particle far away limits lists to one sub-step."""
    kept = alike(BETWEEN.format(0), ranks=(1, 2, 3, 5))
    assert len(set(kept)) == 6
    assert on_ranks(3, BETWEEN.format(900)).lines == kept


def test_a_law_of_one_particle():
    p = crowd()
    swapped = {
        "position": A.velocity,
        "velocity": A.position,
        "heat": ex.where(shapes.Sphere((0, 0, 0), 1), 1, 0),
    }
    got = played(lambda s: s.law(set=swapped), p)
    np.testing.assert_array_equal(got.position, p["velocity"])
    np.testing.assert_array_equal(got.velocity, p["position"])
    np.testing.assert_array_equal(got.heat, np.linalg.norm(p["position"].astype(float), axis=-1) <= 1)
    got = played(
        lambda s: s.law(acceleration=-A.position, velocity=(0, 1, 0), where=ex.column("mass") > 1), p
    )
    change = np.where((p["mass"] > 1)[:, None], -p["position"] * DT + (0, 1, 0), 0)
    np.testing.assert_allclose(got.velocity, p["velocity"] + change, rtol=1e-5, atol=1e-6)


def test_the_bits_do_not_depend_on_the_order_in_memory():
    p = crowd(500)
    order = np.random.default_rng(2).permutation(500)

    def record(s: motes.System) -> None:
        slip = A.state.slip + ex.relative_velocity * DT
        s.interact(0.25, acceleration=A.state.slip * 20 - ex.normal, set={"slip": slip}, state={"slip": 3})
        s.move()

    one = played(record, p, steps=3, substeps=4)
    np.testing.assert_array_equal(one.velocity, played(record, p, steps=3, substeps=4, threads=3).velocity)
    with motes.World(seed=3, dt=DT * 4, substeps=4, progress="off") as world:
        system = world.system("one", attributes={"heat": 0, "wind": (0, 0, 0)})
        system.emit(**p)
        world.step()
        system.sort((9, 9, 9), (1, 0.3, 0.2))
        with system.local() as view:
            assert len(view.position) == 500
        for _ in range(3):
            record(system)
            world.step()
        other = system.gather()
    assert sorted(order) == list(range(500))
    np.testing.assert_array_equal(one.velocity, other.velocity)


@settings(max_examples=20, deadline=None)
@given(st.integers(2, 60), st.floats(0.01, 3), st.integers(0, 99))
def test_neighbours_are_counted_at_any_radius(count: int, radius: float, seed: int):
    p = crowd(count, seed)
    got = played(lambda s: s.interact(radius, set={"heat": 1}), p)
    x = p["position"]
    d = x[None] - x[:, None]
    r2 = d[..., 0] * d[..., 0] + d[..., 1] * d[..., 1] + d[..., 2] * d[..., 2]
    near = (r2 < np.float32(radius) * np.float32(radius)) & ~np.eye(count, dtype=bool)
    np.testing.assert_array_equal(got.heat, near.sum(1))


def divides_by_columns(text: str) -> bool:
    """Return whether no divisor is the literal 0, which laws refuse at the call."""
    return re.search(r"[/%] -?0\.?0*\b(?!\.?[0-9])", text) is None


@settings(max_examples=30, deadline=None)
@given(st.lists(expressions(scalars()).filter(divides_by_columns), min_size=1, max_size=4))
@example(["column('heat') + 1", "(column('heat') + 1) * 2"])  # one result is an operand of the other
def test_laws_compute_what_set_does(texts: list[str]):
    """Laws share common subexpressions and reuse planes; `set` evaluates each expression by itself."""
    names = ["alpha", "heat", "lifetime", "mass"][: len(texts)]
    space: dict[str, Any] = {}
    exec(HEADER, space)  # noqa: S102 (as the lists of the slow suite do)
    values = {name: eval(text, space) for name, text in zip(names, texts, strict=True)}  # noqa: S307
    p = crowd(40)
    law = played(lambda s: s.law(set=values), p)
    for name, value in values.items():
        alone = played(lambda s, name=name, value=value: s.set(**{name: value}), p)
        np.testing.assert_array_equal(getattr(law, name), getattr(alone, name))


WRONG: list[tuple[dict[str, Any], str]] = [
    ({}, "acceleration"),
    ({"acceleration": ex.r}, "acceleration"),
    ({"acceleration": B.wings}, "wings"),
    ({"acceleration": A.wings * ex.r}, "wings"),
    ({"acceleration": ex.normal * A.state.slip}, "state"),
    ({"acceleration": ex.normal / 0}, "division by 0"),
    ({"acceleration": ex.normal * (ex.r % 0)}, "division by 0"),
    ({"acceleration": ex.where(shapes.Sphere((0, 0, 0), 1), (1, 0, 0), (0, 0, 0))}, "shape"),
    ({"velocity": "fast"}, "velocity"),
    ({"velocity": (1, 2, 3, 4)}, "velocity"),
    ({"set": {"heat": ex.normal}}, "heat"),
    ({"set": {"b.heat": 1}}, "only a can change"),
    ({"set": {"slip": 1}}, "slip"),
    ({"set": {"position": ex.normal}}, "position"),
    ({"set": 3}, "set"),
    ({"set": {"velocity": ex.normal}, "acceleration": ex.normal}, "velocity"),
    ({"set": {"slip": 1}, "state": {"slip": 2}}, "slip"),
    ({"set": {"slip": 1}, "state": ["slip"]}, "state"),
    ({"set": {"heat": 1}, "state": {"heat": 1}}, "heat"),
    ({"set": {"s0": 1}, "state": {f"s{i}": 3 for i in range(33)}}, "96"),
    ({"set": {"heat": 1}, "other": 3}, "other"),
    ({"set": {"heat": 1}, "where": B.heat > 0}, "b.heat"),
]


@pytest.mark.parametrize(("wrong", "said"), WRONG)
def test_wrong_laws_are_refused_at_the_call(wrong: dict[str, Any], said: str):
    with motes.World(seed=1, progress="off") as world:
        system = world.system("one", attributes={"heat": 0})
        with pytest.raises(ArgumentError, match=said):
            system.interact(1.0, **wrong)
        assert not system.recorded
        world.step()


@pytest.mark.parametrize("radius", [0, -1, np.nan, np.inf, "wide"])
def test_wrong_radii_are_refused(radius: Any):
    with motes.World(seed=1, progress="off") as world, pytest.raises(ArgumentError, match="radius"):
        world.system("one").interact(radius, velocity=ex.normal)


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (B.position, "b.position"),
        (ex.r, "r"),
        (ex.normal, "normal"),
        (ex.relative_velocity, "b.velocity"),
        (A.state.slip, "a.state.slip"),
    ],
)
def test_one_particle_has_no_pair(value: Any, shown: str):
    with motes.World(seed=1, progress="off") as world:
        system = world.system("one")
        with pytest.raises(ArgumentError, match=rf"interact.*'{re.escape(shown)}'"):
            system.law(set={"mass": ex.length(value)})
        with pytest.raises(ArgumentError, match="interact"):
            system.set(mass=ex.length(value))
        with pytest.raises(ArgumentError, match="a pair remembers what a sees"):
            _ = B.state


def test_laws_are_values():
    law = actions.Interact(
        radius=1, acceleration=ex.normal * -A.mass, set={"mass": A.state.n}, state={"n": 1}
    )
    assert law == copy.deepcopy(law) == pickle.loads(pickle.dumps(law))
    assert law != actions.Interact(radius=1, acceleration=ex.normal)
    assert hash(law) == hash(pickle.loads(pickle.dumps(law)))
    assert "normal" in repr(law)
    assert "a.state.n" in repr(law)
    assert actions.Law(velocity=(1, 0, 0)) == actions.Law(velocity=(1, 0, 0))
    assert pickle.loads(pickle.dumps(A)).mass is not None
    with pytest.raises(AttributeError, match="cannot be assigned"):
        A.mass = 3
