"""Controls, orders and poses in isolation: which values are allowed, clamped or refused."""

from __future__ import annotations

import importlib.util
import json
import math
import threading
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import motes
from motes import errors
from motes._live import viewing
from motes._live.orders import MOST_MOVES, MOST_STEPS, Orders
from motes._live.pose import FARTHEST_M, Pose
from motes._live.steering import Steering
from motes._world.world import running_of, session_of

HOME = Pose((0.0, 2.0, 12.0), (0.0, 2.0, 0.0), (0.0, 1.0, 0.0), 40.0)
reals = st.floats(allow_nan=False, allow_infinity=False, width=64, min_value=-1e3, max_value=1e3)
anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=8,
)


def world() -> motes.World:
    return motes.World(seed=1, progress="off")


# --- World.control


def test_a_colour_is_six_digits_and_a_group_is_told():
    made = world()
    tint = made.control("tint", "Orange", group="Look")
    assert tint.value == "#ffa500" and tint.group == "Look"
    assert tint._definition == {"value": "#ffa500", "group": "Look"}
    assert motes.World(seed=1).control("c", "#abc").value == "#aabbcc"
    assert tint._settled("#00ff00") == "#00ff00"
    for wrong in ("orange", "#00FF00", "#0f0", 3, None, True, ["#00ff00"]):
        with pytest.raises(ValueError, match="'tint' must be a colour such as '#ff8800'"):
            tint._settled(wrong)
    for options, told in (
        ({"value": "oragne"}, "did you mean 'orange'"),
        ({"value": "#12345"}, "a colour"),
        ({"value": "red", "step": 1}, "step must be left out for a control of a colour"),
        ({"value": True, "group": ""}, "group must be a printable string"),
        ({"value": True, "group": 3}, "group must be a printable string"),
    ):
        with pytest.raises(errors.ArgumentError, match=told):
            made.control("other", **options)


def test_a_control_has_its_first_value_and_cannot_be_assigned():
    wind = world().control("wind", 0.5, low=-2, high=2, step=0.1)
    assert (wind.value, wind.name, wind.low, wind.high, wind.step, wind.choices) == (
        0.5,
        "wind",
        -2,
        2,
        0.1,
        None,
    )
    assert repr(wind) == "<Control 'wind': 0.5>"
    with pytest.raises(errors.NotAssignableError, match="viewers set it"):
        wind.value = 1
    with pytest.raises(errors.NotAssignableError, match="cannot be assigned"):
        wind.low = 1


def test_a_control_is_not_tested_in_place_of_its_value():
    flag = motes.World(seed=1, progress="off").control("on", False)
    for test in (bool, lambda one: np.where([one], 1, 2)):
        with pytest.raises(errors.ArgumentError, match="control must be tested as on.value"):
            test(flag)


@pytest.mark.parametrize(
    ("arguments", "kind"),
    [
        ({"value": 3, "low": 1, "high": 9, "step": 2}, int),
        ({"value": 3, "low": 1, "high": 9}, float),
        ({"value": 3, "low": 1, "high": 9.0, "step": 2}, float),
        ({"value": np.float32(0.5), "low": 0, "high": 1}, float),
        ({"value": True}, bool),
        ({"value": np.True_}, bool),
        ({"value": "a", "choices": ["a", "b"]}, str),
        ({"value": 2, "choices": (1, 2, 4)}, int),
        ({"value": "orange", "group": "Look"}, str),
    ],
)
def test_a_value_is_of_the_kind_that_was_given(arguments, kind):
    assert type(world().control("c", **arguments).value) is kind


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"value": 1}, "low must be given for a control that is a number, got None"),
        ({"value": 1, "low": 0}, "high must be given"),
        ({"value": 1, "low": 2, "high": 1}, "high must be more than low, 2, got 1"),
        ({"value": 3, "low": 0, "high": 1}, r"value must be a finite number in 0\.\.1, got 3"),
        ({"value": math.nan, "low": 0, "high": 1}, "value must be a finite number"),
        ({"value": 1, "low": 0, "high": math.inf}, "high must be a finite number"),
        ({"value": "x", "low": 0, "high": 1}, "value must be a number, got 'x'"),
        ({"value": 1, "low": 0, "high": 1, "step": 0}, "step must be above 0, at most high - low, 1, got 0"),
        ({"value": 1, "low": 0, "high": 1, "step": 2}, "step must be a finite number <= 1"),
        ({"value": True, "low": 0}, "low must be left out for a control of True or False"),
        ({"value": "a", "choices": "ab"}, "choices must be 1"),
        ({"value": "a", "choices": []}, "choices must be 1"),
        ({"value": "a", "choices": ["a", "a"]}, "choices must be 1"),
        ({"value": "a", "choices": ["a", None]}, "choices must be 1"),
        ({"value": "c", "choices": ["a", "b"]}, "value must be one of the choices"),
        ({"value": True, "choices": [1, 2]}, "value must be one of the choices"),
        (
            {"value": "a", "choices": ["a"], "step": 1},
            "step must be left out for a control of choices",
        ),
    ],
)
def test_wrong_controls_are_refused_at_the_call(arguments, message):
    with pytest.raises(errors.ArgumentError, match=message):
        world().control("c", **arguments)


@pytest.mark.parametrize("name", ["", 3, None, "a\n", "x" * 101])
def test_wrong_names_are_refused(name):
    with pytest.raises(errors.ArgumentError, match="name must be a printable string"):
        world().control(name, True)


def test_names_are_unique_and_near_ones_are_suggested():
    made = world()
    made.control("wind", True)
    with pytest.raises(errors.ArgumentError, match="a control named 'wind' already exists; names are unique"):
        made.control("wind", False)
    with pytest.raises(TypeError, match="did you mean 'high'"):
        made.control("rain", 1, low=0, hihg=1)


@given(wish=reals, low=st.integers(-50, 50), width=st.integers(1, 60), steps=st.integers(1, 40))
def test_numbers_are_clamped_and_snapped(wish, low, width, steps):
    step = width / steps
    control = world().control("c", low, low=low, high=low + width, step=step)
    settled = control._settled(wish)
    assert low <= settled <= low + width
    assert abs((settled - low) / step - round((settled - low) / step)) < 1e-6
    assert abs(settled - min(max(wish, low), low + width)) <= step / 2 * (1 + 1e-9)
    assert control._settled(settled) == settled  # settling twice changes nothing, which a replay relies on
    assert json.loads(json.dumps(settled)) == settled


def test_steps_that_do_not_divide_the_bounds_stay_within():
    control = world().control("c", 0, low=0, high=10, step=4)
    assert [control._settled(wish) for wish in (-3, 1.9, 2.1, 9, 11)] == [0, 0, 4, 8, 8]


@pytest.mark.parametrize("wish", [None, "1", True, [1], {}, math.nan, math.inf, 10**400])
def test_no_number_is_no_number(wish):
    with pytest.raises(ValueError, match="'c' must be a finite number"):
        world().control("c", 0, low=0, high=1)._settled(wish)


def test_flags_and_choices_take_nothing_else():
    flag = world().control("f", True)
    choice = world().control("c", 1, choices=(1, "1", 2.5))
    assert flag._settled(False) is False and choice._settled("1") == "1" and choice._settled(2.5) == 2.5
    for control, wish in (
        (flag, 1),
        (flag, "on"),
        (choice, 3),
        (choice, True),
        (choice, None),
        (choice, [1]),
    ):
        with pytest.raises(ValueError, match=f"'{control.name}' must be"):
            control._settled(wish)


# --- Live, and World's arguments


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"port": -1}, "port must be an integer in 0..65535"),
        ({"port": 65536}, "port"),
        ({"host": ""}, "host must be an address"),
        ({"host": "a b"}, "host"),
        ({"wait": 1}, "wait must be True or False"),
        ({"max_fps": 0}, "max_fps"),
        ({"quality": 101}, "quality must be an integer in 1..100"),
        ({"paused": None}, "paused"),
    ],
)
def test_wrong_settings_are_refused(arguments, message):
    with pytest.raises(errors.ArgumentError, match=message):
        motes.Live(**arguments)


def test_live_is_a_value():
    assert motes.Live(9000, wait=True) == motes.Live(port=9000, wait=True) != motes.Live()
    assert repr(motes.Live(9000)).startswith("Live(port=9000")
    with pytest.raises(TypeError):
        motes.Live(8080, "127.0.0.1")


@pytest.mark.parametrize("wrong", [True, "8080", 1.5, -1, 70000])
def test_worlds_live_is_a_port_or_live(wrong):
    with pytest.raises(errors.ArgumentError, match="live must be"):
        motes.World(live=wrong)


@pytest.mark.parametrize("missing", ["websockets", "simplejpeg"])
def test_without_its_packages_every_rank_is_told_what_to_install(monkeypatch, missing):
    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == missing else found(name))
    with pytest.raises(errors.MissingExtraError, match=f"a live run needs {missing}, .*websockets>=13"):
        motes.World(live=0)
    assert motes.World().live_url is None


@pytest.mark.parametrize("wrong", [3, "", b"x"])
def test_worlds_steering_is_a_path(wrong):
    with pytest.raises(errors.ArgumentError, match="steering must be None or the path"):
        motes.World(steering=wrong)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("9000", motes.Live(9000)),
        ("0,paused,wait", motes.Live(0, paused=True, wait=True)),
        ("80,host=0.0.0.0", motes.Live(80, host="0.0.0.0")),
        ("off", None),
    ],
)
def test_the_environment_takes_precedence(monkeypatch, text, expected):
    monkeypatch.setenv("MOTES_LIVE", text)
    assert session_of(motes.World(live=1234)).settings.live == expected


@pytest.mark.parametrize("text", ["on", "-1", "99999", "80,loud", "80,host="])
def test_a_wrong_variable_is_named(monkeypatch, text):
    monkeypatch.setenv("MOTES_LIVE", text)
    with pytest.raises(errors.ArgumentError, match="MOTES_LIVE must be off, or a port"):
        motes.World()


# --- poses


@given(st.lists(st.tuples(st.sampled_from(["orbit", "pan", "zoom"]), reals, reals), max_size=8))
def test_whatever_the_mouse_does_the_camera_sees_something(moves):
    pose = HOME
    for kind, a, b in moves:
        pose = pose.zoom(a, 0.1) if kind == "zoom" else getattr(pose, kind)(a, b)
        pose = pose.rounded()
        assert pose.possible() or max(map(abs, pose.position)) > 1e6
        assert all(map(math.isfinite, (*pose.position, *pose.look_at)))


@given(right=st.floats(-10, 10), up=st.floats(-10, 10))
def test_an_orbit_keeps_its_distance_and_its_target(right, up):
    pose = HOME.orbit(right, up)
    assert math.dist(pose.position, pose.look_at) == pytest.approx(12)
    assert pose.look_at == HOME.look_at and pose.up == HOME.up
    assert abs(pose.position[1] - 2) <= 12 * math.sin(math.radians(89.0001))


def test_moves_go_where_the_mouse_goes():
    assert HOME.orbit(math.pi / 2, 0).position == pytest.approx((12, 2, 0))
    assert HOME.orbit(0, math.pi / 6).position == pytest.approx((0, 8, 12 * math.cos(math.pi / 6)))
    seen = 2 * 12 * math.tan(math.radians(20))
    assert HOME.pan(0.5, 0).position == pytest.approx((seen / 2, 2, 12))
    assert HOME.pan(0, 0.25).look_at == pytest.approx((0, 2 + seen / 4, 0))
    assert HOME.zoom(math.log(2), 0.1).position == pytest.approx((0, 2, 6))
    assert math.dist(HOME.zoom(1e3, 0.1).position, HOME.look_at) == pytest.approx(0.4)
    assert math.dist(HOME.zoom(-1e3, 0.1).position, HOME.look_at) == pytest.approx(FARTHEST_M)


def test_poses_are_rounded_to_four_digits_and_small_scenes_to_more():
    pose = HOME.orbit(0.1234567, 0.0567).rounded()
    assert all(round(x, 4) == x for x in pose.position)
    small = Pose((0.0, 0.0, 1e-3), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40.0).orbit(0.3, 0.2).rounded()
    assert math.dist(small.position, (0, 0, 0)) == pytest.approx(1e-3, rel=1e-3)


@given(anything)
def test_what_is_no_pose_is_refused(said):
    with pytest.raises(ValueError):
        Pose.read(said)


# --- orders


def known() -> Orders:
    made = world()
    orders = Orders()
    made.control("wind", 0.0, low=-5, high=5, step=0.1)
    made.control("still", False)
    orders.know(running_of(made).viewers.steering.controls)
    return orders


def taken(orders: Orders) -> dict:
    text, _ = orders.take(lambda: HOME, 0.1)
    return json.loads(text) if text else {}


def test_the_last_value_wins_and_moves_add_up():
    orders = known()
    for wind in (1, 2, 3.14159):
        orders.put({"set": {"wind": wind}})
    for _ in range(4):
        orders.put({"orbit": [math.pi / 8, 0]})
    orders.put({"pause": True})
    orders.put({"step": 2})
    orders.put({"step": 3})
    said = taken(orders)
    assert said["set"] == {"wind": 3.1} and said["step"] == 5 and said["pause"] is True
    assert said["camera"]["position"] == [12.0, 2.0, 0.0]
    assert taken(orders) == {} and orders.accepted == 10


def test_a_reset_forgets_moves_before_it_and_not_those_behind():
    orders = known()
    orders.put({"orbit": [1, 0]})
    orders.put({"camera": None})
    assert taken(orders) == {"camera": None}
    orders.put({"camera": {**HOME.to_dict(), "position": [0, 2, 24]}})
    orders.put({"orbit": [math.pi / 2, 0]})
    assert taken(orders)["camera"]["position"] == [24.0, 2.0, 0.0]


@given(anything)
def test_nonsense_is_refused_and_changes_nothing(said):
    orders = known()
    with pytest.raises(ValueError):
        orders.put(said)
    assert taken(orders) == {} and orders.accepted == 0


@pytest.mark.parametrize(
    "order",
    [
        {"set": {"rain": 1}},
        {"set": {"wind": 1, "rain": 1}},
        {"set": {}},
        {"set": {"wind": "__import__('os')"}},
        {"set": {"still": 1}},
        {"orbit": [1]},
        {"orbit": [1, math.nan]},
        {"orbit": [1, 1e300]},
        {"orbit": [10**400, 0]},
        {"zoom": -(10**400)},
        {"set": {"wind": 10**400}},
        {"step": 10**400},
        {"camera": {**HOME.to_dict(), "position": [10**400, 0, 0]}},
        {"camera": {**HOME.to_dict(), "fov_deg": 10**400}},
        {"zoom": "in"},
        {"pan": [True, 0]},
        {"camera": {"position": [0, 0, 0]}},
        {"camera": {**HOME.to_dict(), "position": [0, 2, 0]}},
        {"camera": {**HOME.to_dict(), "fov_deg": 190}},
        {"step": 0},
        {"step": MOST_STEPS + 1},
        {"step": 1.5},
        {"step": True},
        {"pause": 1},
        {"stop": False},
        {"joined": True},
        {"eval": "1"},
        {"pause": True, "stop": True},
    ],
)
def test_wrong_orders_say_why(order):
    orders = known()
    with pytest.raises(ValueError, match=r".{10}"):
        orders.put(order)
    assert taken(orders) == {}


def test_a_flood_of_orders_stays_small():
    orders = known()
    for i in range(20_000):
        orders.put({("orbit", "pan")[i % 2]: [0.001, 0]})
        orders.put({"step": MOST_STEPS})
    assert len(orders._moves) <= MOST_MOVES
    text, accepted = orders.take(lambda: HOME, 0.1)
    assert len(text) < 1000 and accepted == 40_000 and json.loads(text)["step"] == MOST_STEPS


def test_a_run_that_repeats_another_can_only_be_paused():
    orders = Orders("log/steer.jsonl")
    for order in ({"orbit": [1, 0]}, {"camera": None}, {"stop": True}, {"set": {"wind": 1}}):
        with pytest.raises(ValueError, match="repeats the orders of log/steer.jsonl"):
            orders.put(order)
    orders.put({"pause": True})
    assert taken(orders) == {"pause": True}


def test_the_films_speed_is_kept_where_viewers_want_it(monkeypatch):
    now, slept = [100.0], []

    def sleep(seconds: float) -> None:
        slept.append(round(seconds, 6))
        now[0] += seconds

    monkeypatch.setattr(viewing.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(viewing.time, "sleep", sleep)
    seen = object.__new__(viewing.Viewing)
    seen._orders, seen._due_s = Orders("steer.jsonl"), 0.0
    for took in (0.01, 0.01):  # frames come as fast as possible
        now[0] += took
        seen.keep_pace(0.04)
    assert slept == []
    seen._orders.put({"pace": True})
    assert taken(seen._orders) == {}, "it is no order to other ranks, nor in the record"
    for took in (0.01, 0.01, 0.2, 0.01):
        now[0] += took
        seen.keep_pace(0.04)
    assert slept == [0.03, 0.03, 0.03], "a frame that took longer is not made up for"
    seen._orders.put({"pace": False})
    seen.keep_pace(0.04)
    assert len(slept) == 3
    with pytest.raises(ValueError):
        seen._orders.put({"pace": 1})


def test_a_wait_ends_with_an_order():
    orders = known()
    assert not orders.wait(0.01)
    threading.Timer(0.05, orders.put, [{"pause": True}]).start()
    start = time.monotonic()
    assert orders.wait(10) and time.monotonic() - start < 5


@pytest.mark.parametrize(
    ("given", "paused", "frames"),
    [
        ([{"pause": True}, {"step": 2}], True, 2),
        ([{"step": 5}, {"pause": True}, {"step": 2}], True, 2),
        ([{"step": 2}, {"pause": True}], True, 0),
        ([{"pause": False}, {"step": 1}], True, 1),
        ([{"step": 3}, {"pause": False}], False, 9),
    ],
)
def test_pauses_and_steps_count_in_their_order(given, paused, frames):
    for apart in (True, False):  # orders taken at separate borders between frames, or at the same one
        orders, state, done = known(), Steering(), 0
        for order in given:
            orders.put(order)
            if apart:
                state.hear(json.dumps(taken(orders)))
        state.hear(json.dumps(taken(orders)))
        while not state.held and done < 9:
            state.commit(done)
            done += 1
        assert (state.paused, done) == (paused, frames)
