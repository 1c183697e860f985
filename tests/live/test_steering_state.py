"""State that all ranks share about what viewers did: values, the camera, what is kept and replayed."""

from __future__ import annotations

import json

import pytest

from motes import errors
from motes._live.pose import Pose
from motes._live.steering import Steering
from motes._values.live import Live

HOME = Pose((0.0, 2.0, 12.0), (0.0, 2.0, 0.0), (0.0, 1.0, 0.0), 40.0)


def steering() -> Steering:
    made = Steering()
    made.control("wind", 0.0, -5, 5, None, None)
    return made


def test_values_change_at_the_border_only():
    state = steering()
    wind = state.controls["wind"]
    state.hear('{"set": {"wind": 2.0}}\n')
    assert wind.value == 0 and state.wished("wind") == 2
    assert state.commit(7) == {"set": {"wind": 2.0}} and wind.value == 2
    state.hear('{"set": {"wind": 3.0}}\n{"set": {"wind": 2.0}}\n')
    assert state.commit(8) == {}  # nothing has changed


def test_a_paused_run_steps_and_goes_on():
    state = steering()
    state.hear('{"pause": true}')
    assert state.held and not state.commit(0) and state.held
    state.hear('{"step": 2}')
    for frame in (1, 2):
        assert not state.held
        state.commit(frame)
    assert state.held
    state.hear('{"pause": false}')
    assert not state.held


def test_a_stop_forgets_what_no_frame_will_see():
    state = steering()
    state.hear(json.dumps({"set": {"wind": 1.0}, "camera": HOME.to_dict()}))
    state.hear('{"stop": true}')
    assert state.commit(3) == {} and state.stopped and state.camera is None
    assert state.state() == {"values": {"wind": 0.0}, "camera": None}


def test_a_checkpoint_brings_values_back_also_of_controls_made_later():
    state = steering()
    state.hear(json.dumps({"set": {"wind": 1.5}, "camera": HOME.to_dict()}))
    state.commit(0)
    kept = json.loads(json.dumps(state.state()))
    later = Steering()
    later.restore(kept)
    assert later.control("wind", 0.0, -5, 5, None, None).value == 1.5 and later.camera == HOME
    assert later.commit(9) == {}
    changed = Steering()
    changed.restore(kept)
    assert changed.control("wind", True, None, None, None, None).value is True  # not the kept number


def test_a_checkpoint_of_a_pause_is_held_for_viewers_only():
    state = Steering(Live())
    assert not state.held and "paused" not in state.state()
    state.hear('{"pause": true}')
    kept = json.loads(json.dumps(state.state()))
    watched, alone = Steering(Live()), Steering()
    watched.restore(kept)
    alone.restore(kept)
    assert watched.held and not alone.held


@pytest.mark.parametrize("paused", [False, True])
def test_a_checkpoint_on_the_way_to_an_earlier_frame_keeps_the_way(paused):
    state = Steering(live=Live(0))
    wind = state.control("wind", 0.0, -5, 5, None, None)
    rows = [{"frame": frame, "set": {"wind": float(frame)}} for frame in (1, 3)]
    state.hear(json.dumps({"again": {"rows": rows, "to": 4, "paused": paused}}))
    for frame in (0, 1):
        state.commit(frame)
    assert wind.value == 1
    kept = json.loads(json.dumps(state.state()))
    for live in (Live(0), None):
        later = Steering(live=live)
        wind = later.control("wind", 0.0, -5, 5, None, None)
        later.restore(kept)
        for frame in (2, 3):
            assert not later.held and later.hidden(frame) == (frame == 2 and live is not None)
            later.commit(frame)
        assert wind.value == 3 and later.held == (paused and live is not None)


def test_ranks_agree_on_what_controls_are():
    plain, other = Steering(), Steering()
    assert plain.agreement() == ""
    plain.control("wind", 0.0, -5, 5, None, None)
    other.control("wind", 0.0, -5, 6, None, None)
    assert plain.agreement() == steering().agreement() != other.agreement()


def test_what_cannot_be_repeated_is_said():
    for row, message in (
        ({"set": {"rain": 1}}, "sets 'rain' before frame 4: this run has no such control"),
        ({"set": {"wind": 9}}, "sets 'wind' to 9 before frame 4: not a value"),
        ({"set": {"wind": "x"}}, "frame 4: 'wind' must be a finite number"),
    ):
        state = steering()
        state.rows = {4: row}
        assert state.commit(3) == {}
        with pytest.raises(errors.MotesError, match=message):
            state.commit(4)
