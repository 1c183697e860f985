"""Each action's effect on particles, against physics or its formula."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from acting import SOLIDS, after, cloud, length
from docs_scripts import script_of_docs

import motes
from motes import actions, shapes
from motes import expressions as ex
from motes.errors import ArgumentError

DOCS = Path(__file__).resolve().parents[2] / "docs"
BALL = shapes.Sphere((0, 0, 0), 1)
AXES = np.eye(3, dtype=np.float32)
BY_EXPRESSIONS = ("gravity", "wind", "damping", "rotational_damping")
OTHER_KINDS = {"pairs", "contact_clumps", "bounce_counted", *(f"{name}_by" for name in BY_EXPRESSIONS)}


def test_explosion_is_strongest_at_its_crest():
    r = np.linspace(0.5, 6, 111)
    state = {"position": np.outer(r, (0.6, 0.8, 0)), "velocity": np.zeros((111, 3))}
    blast = actions.Explosion(center=(0, 0, 0), radius=3, magnitude=20, sigma=0.5, epsilon=0.1)
    v = after(state, blast).velocity
    wave = np.exp(-((r - 3) ** 2) / (2 * 0.5**2)) / (0.5 * math.sqrt(2 * math.pi))
    np.testing.assert_allclose(v @ (0.6, 0.8, 0), 0.1 * 20 * wave / (r**2 + 0.1), rtol=2e-5, atol=1e-12)
    np.testing.assert_allclose(np.cross(v, (0.6, 0.8, 0)), 0, atol=1e-5)
    assert not after({"position": [(0, 0, 0)]}, blast).velocity.any(), "the centre knows no direction"
    assert not after({"position": [(0, 0, 8.1)]}, blast).velocity.any(), "ten sigmas away"


@pytest.mark.parametrize("knots", [1, 2, 5, 9, 10, 23])
def test_ramps_go_straight_from_knot_to_knot(knots: int):
    dice = np.random.default_rng(knots)
    ratio = np.sort(dice.uniform(0, 1, knots).astype(np.float32))
    values = dice.uniform(0, 1, (knots, 3))
    age = dice.uniform(0, 2.2, 1000).astype(np.float32)
    state = {"position": np.zeros((1000, 3)), "age": age, "lifetime": np.full(1000, 2)}
    knots_of = list(zip(ratio.tolist(), values.tolist(), strict=True))
    color = after(state, actions.ColorOverLife(ramp=knots_of)).color
    for c in range(3):
        np.testing.assert_allclose(color[:, c], np.interp(age / 2, ratio, values[:, c]), atol=3e-6)


def test_circular_orbits():
    # The pull is magnitude / r^2: speed sqrt(magnitude / r) gives circles with a period of 2 pi r / v.
    r, magnitude = np.array([1.0, 2.0, 4.0]), 5.0
    speed = np.sqrt(magnitude / r)
    state = {"position": np.outer(r, (1, 0, 0)), "velocity": np.outer(speed, (0, 0, 1))}
    pull = actions.OrbitPoint(center=(0, 0, 0), magnitude=magnitude, epsilon=0)
    for period, i in zip(2 * math.pi * r / speed, range(3), strict=True):
        p = after(state, pull, actions.Move(), dt=period, substeps=4000)
        assert abs(length(p.position[i : i + 1])[0] - r[i]) < 2e-3 * r[i]
        np.testing.assert_allclose(p.position[i], state["position"][i], atol=0.01 * r[i])


@pytest.mark.parametrize("along", [(1, 2, -1), (3, 0, 0), (0, -0.1, 0), (0, 0, 1)])
def test_orbit_line_pulls_across_and_only_near(along: tuple[float, float, float]):
    state = cloud(500)
    axis, point = np.array(along) / math.hypot(*along), np.array((0.5, 0.2, -0.3))
    near = actions.OrbitLine(point=point, axis=10 * axis, magnitude=2, epsilon=0.3, max_radius=2.5)
    change = after(state, near).velocity - np.float32(state["velocity"])
    to_axis = np.outer((state["position"] - point) @ axis, axis) - (state["position"] - point)
    r = length(to_axis)
    np.testing.assert_allclose(change @ axis, 0, atol=1e-5)
    wanted = np.where(r < 2.5, 0.1 * 2 / (r**2 + 0.3), 0)
    np.testing.assert_allclose(length(change), wanted, rtol=1e-3, atol=3e-6)
    assert ((change * to_axis).sum(1)[r < 2.5] > 0).all()


def test_vortex_inside_outside_and_beyond():
    places = [(0.4, 1, 0), (0, 1, 0.4), (1.5, 1, 0), (2.5, 1, 0), (0.4, -1, 0), (0.4, 5, 0)]
    state = {"position": places, "velocity": np.ones((6, 3)), "mass": np.full(6, 2.0)}
    whirl = actions.Vortex(
        tip=(0, 0, 0), axis=(0, 4, 0), tightness=0.5, max_radius=2, in_speed=8, up_speed=6, around_speed=4
    )
    v = after(state, whirl).velocity
    # At height 1 of 4 the vortex radius is 2 sqrt(1 / 4) = 1 m; inward is -x, around is y x -x = z.
    np.testing.assert_allclose(v[0], (0, 0.3, 0.2), atol=1e-6)
    np.testing.assert_allclose(v[1], (-0.2, 0.3, 0), atol=1e-6)
    np.testing.assert_allclose(v[2], (1 - 0.4, 1, 1), atol=1e-6)
    assert (v[3:] == 1).all()


def test_wind_converges_to_the_air_whatever_the_step():
    state, air = cloud(100), np.array((3.0, -1.0, 2.0))
    start = np.float32(state["velocity"])
    wanted = air + (start - air) * math.exp(-0.7)
    for dt, substeps in ((1.0, 1), (1.0, 2), (1.0, 500)):
        v = after(state, actions.Wind(velocity=air, drag=0.7), dt=dt, substeps=substeps).velocity
        np.testing.assert_allclose(v, wanted, atol=3e-5)
    for drag in (40, 1e9):
        v = after(state, actions.Wind(velocity=air, drag=drag), dt=1.0).velocity
        np.testing.assert_allclose(v, np.broadcast_to(air, v.shape), atol=1e-6)
    np.testing.assert_array_equal(after(state, actions.Wind(velocity=air, drag=0)).velocity, start)
    tiny = after({"position": [(0, 0, 0)]}, actions.Wind(velocity=air, drag=1e-5)).velocity[0]
    np.testing.assert_allclose(tiny, air * 1e-6, rtol=1e-5)


def test_dampings_are_alike():
    state = cloud(300)
    options = {"damping": (0.1, 0.5, 1.2), "min_speed": 2, "max_speed": 6}
    v = after(state, actions.Damping(**options)).velocity
    turned = {"position": state["position"], "rotational_velocity": state["velocity"]}
    spin = after(turned, actions.RotationalDamping(**options)).rotational_velocity
    np.testing.assert_array_equal(v, spin)
    start = np.float32(state["velocity"])
    hit = (length(start) >= 2) & (length(start) <= 6)
    np.testing.assert_allclose(v[hit], start[hit] * (1 - (1 - np.array(options["damping"])) * 0.1), rtol=1e-5)
    np.testing.assert_array_equal(v[~hit], start[~hit])


def test_speed_clamp():
    state = cloud(300)
    state["velocity"][0] = 0
    start = np.float32(state["velocity"])
    v = after(state, actions.SpeedClamp(min_speed=4, max_speed=5)).velocity
    assert not v[0].any()
    assert (length(v)[1:] > 4 - 1e-5).all() and (length(v) < 5 + 1e-5).all()
    np.testing.assert_allclose(np.cross(v, start), 0, atol=2e-5)
    kept = (length(start) >= 4) & (length(start) <= 5)
    np.testing.assert_array_equal(v[kept], start[kept])
    np.testing.assert_array_equal(after(state, actions.SpeedClamp()).velocity, start)


def test_targets_are_approached_by_the_same_part_of_the_difference():
    n, scale, dt, frames = 50, 0.8, 0.25, 9
    dice = np.random.default_rng(1)
    state = {
        name: dice.normal(0, 2, (n, 3))
        for name in ("position", "velocity", "rotational_velocity", "size", "color")
    }
    state["alpha"] = dice.random(n)
    goal = (1.0, -2.0, 0.5)
    p = after(
        state,
        actions.TargetVelocity(velocity=goal, scale=scale),
        actions.TargetRotationalVelocity(rotational_velocity=goal, scale=scale),
        actions.TargetColor(color=goal, alpha=0.25, scale=scale),
        actions.TargetSize(size=2, scale=(scale, 0, 2 * scale)),
        dt=dt,
        frames=frames,
    )
    left = (1 - scale * dt) ** frames
    for name in ("velocity", "rotational_velocity", "color"):
        np.testing.assert_allclose(getattr(p, name), goal + (state[name] - goal) * left, atol=2e-5)
    np.testing.assert_allclose(p.alpha, 0.25 + (state["alpha"] - 0.25) * left, atol=2e-6)
    lefts = np.array([left, 1, (1 - 2 * scale * dt) ** frames])
    np.testing.assert_allclose(p.size, 2 + (state["size"] - 2) * lefts, atol=2e-5)


def restored(frames: int) -> motes.Particles:
    """Restore particles in one second; return the largest errors of position and up before the last frame."""
    world = motes.World(seed=3, dt=1 / frames, progress="off")
    system = world.system("all")
    with world:
        for frame in world.frames(frames + 1):
            if frame == 0:
                system.emit(**cloud(100), position_b=np.full((100, 3), 7.0), up_b=np.full((100, 3), 2.0))
            system.restore(1 - frame / frames if frame < frames else 0)
            if frame < frames:
                system.move()
                nearly = None
            world.step()
            if frame == frames - 1:
                nearly = system.gather()
                off = length(nearly.position - 7).max(), length(nearly.up - 2).max()
        p = system.gather()
    assert (p.position == 7).all() and (p.up == 2).all()
    assert not p.velocity.any() and not p.rotational_velocity.any()
    return off


def test_restore_arrives_and_rests():
    coarse, fine = restored(50), restored(400)
    assert fine[0] < 0.01 and fine[1] < 0.01
    assert fine[0] < coarse[0] / 4 and fine[1] < coarse[1] / 4, (
        "the path is met the better the finer the steps"
    )


def test_copies_restore_the_exact_bits():
    state = {**cloud(100), "up": cloud(100, seed=1)["position"]}
    swirl = [
        actions.RandomDisplacement(shape=shapes.Sphere((1, 0, 0), 30)),
        actions.RandomVelocity(shape=BALL),
    ]
    p = after(state, actions.CopyVertexB(position=True, velocity=True), *swirl)
    assert (p.position != np.float32(state["position"])).any()
    np.testing.assert_array_equal(p.velocity_b, np.float32(state["velocity"]))
    p = after(state, actions.CopyVertexB(), *swirl, actions.Restore(time_left=0))
    np.testing.assert_array_equal(p.position, np.float32(state["position"]))
    np.testing.assert_array_equal(p.up, np.float32(state["up"]))
    p = after(state, *swirl, actions.Restore(time_left=-1, up=False))
    np.testing.assert_array_equal(p.position, np.float32(state["position"]))


def test_ramps_at_knots_between_and_outside():
    age = np.array([-1, 0, 0.4, 0.5, 0.75, 1, 1.5, 2, 3, 1], np.float32)
    lifetime = np.array([2] * 9 + [math.inf], np.float32)
    state = {"position": np.zeros((10, 3)), "age": age, "lifetime": lifetime}
    ramp = [(0.2, 5.0), (0.25, 1.0), (0.5, 3.0), (0.5, 10.0), (0.75, 0.0)]
    colors = [(ratio, (value, 1.0, -value)) for ratio, value in ramp]
    p = after(
        state,
        actions.AlphaOverLife(ramp=ramp),
        actions.ColorOverLife(ramp=colors),
        actions.SizeOverLife(ramp=ramp),
    )
    # at age / lifetime -0.5, 0, 0.2, 0.25, 0.375, 0.5 (after the jump), 0.75, 1, 1.5, 0 (lives forever)
    wanted = np.array([5, 5, 5, 1, 2, 10, 0, 0, 0, 5], np.float32)
    np.testing.assert_array_equal(p.alpha, wanted)
    np.testing.assert_array_equal(p.color, np.stack([wanted, np.ones(10), -wanted], axis=1))
    np.testing.assert_array_equal(p.size, np.stack([wanted] * 3, axis=1))
    one = after(state, actions.SizeOverLife(ramp=[(0.5, (1, 2, 3))]))
    np.testing.assert_array_equal(one.size, np.tile(np.float32((1, 2, 3)), (10, 1)))


def test_jet_with_a_random_shape():
    state = cloud(20_000, scale=1)
    gusts = shapes.Box((1, -2, 0), (3, 2, 0))
    p = after(state, actions.Jet(shape=BALL, acceleration=gusts))
    change = (p.velocity.astype(np.float64) - np.float32(state["velocity"])) / 0.1
    inside = BALL.contains(state["position"])
    np.testing.assert_array_equal(p.velocity[~inside], np.float32(state["velocity"])[~inside])
    blown = change[inside]
    assert len(blown) > 2000 and (np.abs(blown - (2, 0, 0)) <= np.array((1, 2, 0)) + 1e-4).all()
    np.testing.assert_allclose(blown.mean(0), (2, 0, 0), atol=0.1)
    np.testing.assert_allclose(blown.var(0), (1 / 3, 4 / 3, 0), atol=0.1)
    steady = after(state, actions.Jet(shape=BALL, acceleration=(0, 9, 0))).velocity - np.float32(
        state["velocity"]
    )
    np.testing.assert_allclose(steady, np.outer(inside, (0, 0.9, 0)), atol=2e-6)


def test_random_draws_differ_by_particle_step_and_place_in_the_list():
    state = {"position": np.zeros((4000, 3))}
    spin = actions.RandomRotationalVelocity(shape=shapes.Sphere((5, 0, 0), 2))
    once = after(state, spin).rotational_velocity
    again = after(state, spin).rotational_velocity
    np.testing.assert_array_equal(once, again)
    assert (length(once - (5, 0, 0)) <= 2 + 1e-5).all() and len(np.unique(once, axis=0)) == 4000
    np.testing.assert_allclose((once.astype(np.float64) - (5, 0, 0)).mean(0), 0, atol=0.06)
    assert (after(state, spin, frames=2).rotational_velocity != once).any(axis=1).all()
    jump = actions.RandomDisplacement(shape=BALL)
    single, double = after(state, jump).position, after(state, jump, jump).position
    assert length(single).max() <= 0.1 + 1e-6, "the shape is in m/s"
    assert (np.abs(double - 2 * single) > 1e-6).any(axis=1).all()


def test_sink_velocity_kills_by_speed_and_direction():
    state = cloud(400)
    fast = length(np.float32(state["velocity"])) > 4
    limit = shapes.Sphere((0, 0, 0), 4)
    assert set(after(state, actions.SinkVelocity(shape=limit, inside=False)).id) == set(np.flatnonzero(~fast))
    assert set(after(state, actions.SinkVelocity(shape=limit)).id) == set(np.flatnonzero(fast))
    falling = np.float32(state["velocity"])[:, 1] <= 0
    plane = shapes.Plane((0, 0, 0), (0, 1, 0))
    assert set(after(state, actions.SinkVelocity(shape=plane)).id) == set(np.flatnonzero(~falling))


def test_special_places_stay_finite():
    """At the centre, on the axis, at rest, on a surface, straight at a shape: results stay finite."""
    places = [(0, 0, 0), (0, 1, 0), (1, 0, 0), (0, -1, 0), (0, 4, 0), (1e-20, 0, 0), (0, 3, 1e-25)]
    speeds = [(0, 0, 0), (0, -5, 0), (1e-20, 0, 0), (-3, 0, 0), (1e9, 0, 0)]
    state = {
        "position": np.repeat(places, len(speeds), axis=0),
        "velocity": np.tile(speeds, (len(places), 1)),
        "mass": np.resize([1, 0, 1e-10], len(places) * len(speeds)),
        "lifetime": np.resize([1, 0, math.inf], len(places) * len(speeds)),
    }
    soft = {"magnitude": 5, "epsilon": 0.1}
    steps: list[actions.Action] = [
        actions.Explosion(center=(0, 0, 0), radius=0, sigma=0.1, **soft),
        actions.OrbitPoint(center=(0, 0, 0), **soft),
        actions.OrbitLine(point=(0, 0, 0), axis=(0, 1, 0), **soft),
        actions.Wind(velocity=(1, 0, 0), drag=1e15),
        actions.SpeedClamp(min_speed=1, max_speed=2),
        actions.SizeOverLife(ramp=[(0, 1), (1, 0)]),
        actions.Restore(time_left=0.01),
        actions.TargetVelocity(velocity=(0, 0, 0), scale=1),
        *(actions.Bounce(shape=shape, exact_hit=False) for shape in SOLIDS.values()),
        *(actions.Avoid(shape=shape, look_ahead=3, magnitude=9, epsilon=0) for shape in SOLIDS.values()),
    ]
    whirl = {"tightness": 0.5, "max_radius": 2, "in_speed": 8, "up_speed": 6, "around_speed": 4}
    steps.append(actions.Vortex(tip=(0, 0, 0), axis=(0, 4, 0), **whirl))
    for step in steps:
        p = after(state, step)
        for column in (p.position, p.velocity, p.size, p.up):
            assert np.isfinite(column).all(), f"{step}: {column[~np.isfinite(column).all(axis=1)][0]}"


def test_where_limits_them():
    state = cloud(500)
    inside = BALL.contains(state["position"])
    v = after(state, actions.Wind(velocity=(9, 9, 9), drag=1e9, where=BALL)).velocity
    np.testing.assert_array_equal((v == 9).all(axis=1), inside)
    gone = after(state, actions.SinkVelocity(shape=shapes.Sphere((0, 0, 0), 99), where=BALL))
    assert set(gone.id) == set(np.flatnonzero(~inside))


WRONG = [
    (
        lambda: actions.Avoid(shape=(0, 0, 0), magnitude=1, epsilon=1, look_ahead=1),
        "shape must have a surface",
    ),
    (lambda: actions.Avoid(shape=BALL, magnitude=1, epsilon=-1, look_ahead=1), "epsilon"),
    (
        lambda: actions.Explosion(center=(0, 0, 0, 0), radius=1, magnitude=1, sigma=1, epsilon=1),
        "center must be 3 numbers",
    ),
    (lambda: actions.Explosion(center=(0, 0, 0), radius=1, magnitude=1, sigma=0, epsilon=1), "sigma"),
    (
        lambda: actions.OrbitLine(point=(0, 0, 0), axis=(0, 0, 0), magnitude=1, epsilon=1),
        "axis must not be zero",
    ),
    (lambda: actions.OrbitPoint(center=(0, 0, 0), magnitude=math.inf, epsilon=1), "magnitude"),
    (lambda: actions.SpeedClamp(min_speed=2, max_speed=1), "min_speed must not be above max_speed"),
    (
        lambda: actions.RotationalDamping(damping=(1, 1, 1), min_speed=2, max_speed=1),
        "min_speed must not be above",
    ),
    (lambda: actions.TargetSize(size=(1, 2, 3, 4), scale=1), "size must be 3 numbers"),
    (lambda: actions.TargetColor(color=(1, 1, 1), alpha=math.nan, scale=1), "alpha"),
    (lambda: actions.Wind(velocity=(0, 0, 0), drag=-1), "drag"),
    (lambda: actions.Restore(time_left="soon"), "time_left must be a number"),
    (lambda: actions.CopyVertexB(position=1), "position must be True or False"),
    (lambda: actions.Bounce(shape=BALL, exact_hit=None), "exact_hit must be True or False"),
    (lambda: actions.Jet(shape=BALL, acceleration=3), "acceleration must be a shape or 3 finite numbers"),
    (lambda: actions.AlphaOverLife(ramp=[]), "ramp must be a list"),
    (lambda: actions.AlphaOverLife(ramp=[(0, 1), (1.5, 1)]), "ramp must be a finite number in 0..1, got 1.5"),
    (lambda: actions.AlphaOverLife(ramp=[(0.5, 1), (0.2, 1)]), "ramp must be ratios in ascending order"),
    (lambda: actions.ColorOverLife(ramp=[(0, 1)]), "ramp must be 3 numbers"),
    (lambda: actions.SizeOverLife(ramp=7), "ramp must be a list"),
]


@pytest.mark.parametrize(("make", "message"), WRONG, ids=[message for _, message in WRONG])
def test_wrong_arguments_are_named(make: Any, message: str):
    with pytest.raises(ArgumentError, match=message):
        make()


def test_every_action_has_a_method_that_records_it():
    world = motes.World(progress="off")
    system = world.system("all")
    kinds = [
        kind for kind in vars(actions).values() if isinstance(kind, type) and issubclass(kind, actions.Action)
    ]
    names = ["".join("_" + c.lower() if c.isupper() else c for c in kind.__name__)[1:] for kind in kinds]
    assert sorted({*names, *OTHER_KINDS} - {"action"}) == sorted(motes._core.action_names())
    assert all(callable(getattr(system, name)) for name in names if name != "action")
    with world:
        system.jet(BALL, acceleration=(0, 1, 0))
        system.size_over_life([(0, 1), (1, 0)])
        assert [type(action).__name__ for action in system.recorded] == ["Jet", "SizeOverLife"]


@pytest.mark.parametrize("name", sorted({*motes._core.action_names()} - {"set", "law", "interact", "sort"}))
def test_messages_name_what_a_script_calls(name: str):
    with pytest.raises(ArgumentError) as caught:
        motes._core.Action(name, {"nonsense": 1.0}, [])
    call, colon, _ = str(caught.value).partition(":")
    assert colon and callable(getattr(motes.System, call))


def test_the_pages_of_actions_are_current():
    for path, text in script_of_docs("make_actions").pages().items():
        assert text == path.read_text(), "run python docs/scripts/make_actions.py"


@pytest.mark.parametrize("rotational", [False, True])
@pytest.mark.parametrize("name", ["up", "rotational_velocity"])
def test_move_may_ask_for_the_columns_that_it_leaves_alone(name, rotational):
    state = {"position": np.zeros((3, 3)), "velocity": np.ones((3, 3))}
    moved = after(state, actions.Move(rotational=rotational, where=ex.column(name).y > 0.5), dt=1.0)
    assert moved.position.tolist() == ([[1, 1, 1]] if name == "up" else [[0, 0, 0]]) * 3


def test_a_particle_beyond_the_range_of_float32_dies():
    state = {
        "position": [(0, 0, 0), (3e38, 0, 0), (1, 2, 3)],
        "velocity": [(1, 0, 0), (3e38, 0, 0), (0, -3e38, 0)],
    }
    p = after(state, actions.Move(), dt=1.0)
    assert p.id.tolist() == [0, 2]
    p = after(state, actions.Gravity(acceleration=(0, -1e15, 0)), actions.Move(), dt=1e9, frames=1)
    assert p.id.tolist() == [0] and np.isfinite(p.position).all()


@pytest.mark.parametrize("value", [ex.column("zero") / 0, 1 / ex.column("zero"), ex.column("minus").sqrt()])
def test_values_that_are_not_finite_are_not_set(value):
    world = motes.World(seed=1, progress="off")
    s = world.system("a", attributes={"zero": 0.0, "minus": -1.0, "heat": 5.0, "wind": (1, 2, 3)})
    with world:
        s.burst(BALL, count=3)
        s.set(heat=value, wind=value + ex.column("velocity") * 0, mass=ex.column("minus") * -2)
        world.step()
        p = s.gather()
    assert p.heat.tolist() == [5] * 3 and p.mass.tolist() == [2] * 3
    assert p.wind.tolist() == [[1, 2, 3]] * 3


def test_spawn_may_ask_for_the_place_of_birth():
    world = motes.World(seed=1, dt=1.0, progress="off")
    s, children = world.system("a"), world.system("b")
    with world:
        for frame in world.frames(2):
            if frame == 0:
                s.emit(position=[(2, 0, 0), (-2, 0, 0)], velocity=[(0, 1, 0), (0, 1, 0)])
                s.spawn(into=children, on="birth", count=3, where=ex.column("position_b").x > 1)
            s.move()
            world.step()
        assert (s.count, children.count) == (2, 3)


def test_children_of_the_lost_are_not_born():
    world = motes.World(seed=1, dt=1.0, progress="off")
    s = world.system("a")
    with world:
        for frame in world.frames(3):
            s.spawn(into=s, on="death", count=5, inherit_velocity=1)
            if frame == 0:
                s.emit(position=[(3e38, 0, 0), (1, 0, 0)], velocity=[(3e38, 0, 0), (1, 0, 0)])
                with s.local() as p:
                    p.velocity[0] = np.inf
            s.move()
            world.step()
        assert (s.count, s.born) == (1, 2)


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"velocity": (1, 2, 3)}, "wind: drag must be given"),
        ({"velocity": (1, 2), "drag": 1}, "wind: velocity must be 3 numbers"),
        (
            {"velocity": (1, 2, 3), "drag": 1, "wind": 2},
            "numbers must match the action's number of parameters, got 3",
        ),
    ],
)
def test_the_engine_takes_numbers_by_name(numbers: dict[str, Any], message: str):
    with pytest.raises(ValueError, match=message):
        motes._core.Action("wind", numbers, [])
    assert motes._core.Action("wind", {"drag": 4, "velocity": (1, 2, 3)}, []).numbers == [1, 2, 3, 4]
