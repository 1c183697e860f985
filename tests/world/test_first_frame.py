"""One warning per system for scripts that run but probably contain an oversight; none for correct ones."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from standing import on_ranks

import motes
from motes import shapes

BOX = shapes.Box((-1, 0, -1), (1, 1, 1))
FLOOR = shapes.Plane((0, 0, 0), (0, 1, 0))
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
Record = Callable[[motes.System], None]


def warnings_of(record: Record, frames: int = 3, **arguments: Any) -> list[str]:
    """Run some frames of one system, and return the warnings."""
    world = motes.World(seed=1, progress="off", **arguments)
    s = world.system("rain")
    with warnings.catch_warnings(record=True) as told, world:
        warnings.simplefilter("always")
        for _ in world.frames(frames):
            record(s)
            if arguments:
                world.render()
            else:
                world.step()
    assert all(one.category is motes.MotesWarning and one.filename == __file__ for one in told)
    return [str(one.message) for one in told]


BORN = "s.source(BOX, rate=100); "
FEW = "s.burst(BOX, count=3); "
COMPLETE = """
s.configure(velocity=(0, 1, 0), lifetime=2, color=(0.5, 0.7, 3), size=0.1)
s.source(BOX, rate=100)
s.gravity((0, -1, 0))
s.color_over_life([(0, (1, 1, 1)), (1, (1, 0, 0))])
s.bounce(FLOOR)
s.move()
s.kill_expired()
"""
NO_MOVE = BORN + "s.gravity((0, -1, 0))"


def recording(text: str) -> Record:
    return lambda s: exec(text, {"s": s, "motes": motes, "BOX": BOX, "FLOOR": FLOOR})


@pytest.mark.parametrize(
    ("record", "message"),
    [
        (NO_MOVE, "none moves: record move()"),
        ("s.configure(velocity=motes.Uniform((0, 0, 0), (0, 1, 0))); " + BORN, "none moves: record move()"),
        ("s.configure(lifetime=1); " + FEW + "s.kill_expired()", "do not age without move()"),
        (BORN + "s.move(); s.bounce(FLOOR)", "bounce after move"),
        (BORN + "s.move(); s.kill_expired()", "KillExpired without a lifetime"),
        (BORN + "s.alpha_over_life([(0, 1), (1, 0)]); s.move()", "AlphaOverLife without a lifetime"),
        ("s.configure(color=(255, 128, 0)); " + FEW, "(255, 128, 0) looks like 0..255"),
        ("s.emit(position=[(0, 0, 0)] * 2, color=[(255, 0, 0), (0, 32, 0)])", "looks like 0..255"),
        (
            FEW + "s.color_over_life([(0, (255, 255, 255)), (1, (0, 0, 0))])",
            "looks like 0..255",
        ),
        ("s.configure(size=motes.Uniform(-1, 1)); " + FEW, "size may be negative (-1)"),
        ("s.configure(lifetime=-1); " + FEW, "lifetime may be negative (-1)"),
        (NO_MOVE + "; s.kill_expired(); s.configure(color=(255, 128, 0)); " + FEW, "; "),  # both at once
    ],
)
def test_an_oversight_is_reported_once(record: str, message: str):
    (told,) = warnings_of(recording(record))
    assert told.startswith("system 'rain': ")
    assert message in told


@pytest.mark.parametrize(
    "record",
    [
        COMPLETE,
        "s.configure(velocity=(1, 0, 0)); " + BORN + "s.callback(lambda p: None); s.kill_expired()",
        NO_MOVE + "\nwith s.local() as p: p.position[:] += p.velocity",
        BORN + "s.move(); s.bounce(FLOOR); s.move()",
        "s.emit(position=[(0, 0, 0)], lifetime=[1]); s.move(); s.kill_expired()",
        FEW + "s.set(lifetime=1); s.move(); s.kill_expired()",
        "s.configure(color=(12.5, 3, 0)); " + FEW,
        FEW,
    ],
)
def test_a_complete_system_gets_no_warning(record: str):
    assert warnings_of(recording(record)) == []


def test_a_system_is_checked_when_it_first_records():
    world = motes.World(seed=1, progress="off")
    early, late = world.system("early"), world.system("late")
    told = []
    with world:
        for frame in world.frames(4):
            recording(COMPLETE)(early)
            if frame >= 2:
                recording(NO_MOVE)(late)
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                world.step()
            told.append([str(one.message) for one in caught])
    assert [len(one) for one in told] == [0, 0, 1, 0]
    assert told[2][0].startswith("system 'late'")


@pytest.mark.parametrize(
    ("position", "solid", "inside"),
    [
        ((0, 0.5, 0), shapes.Sphere((0, 0, 0), 1), True),
        ((0, -1, 5), FLOOR, True),
        ((0, 1, 5), FLOOR, False),
        ((0, 0.5, 0), shapes.Sphere((0, 0, 0), 2, 1), False),
    ],
)
def test_a_camera_inside_a_solid_is_reported_once(position, solid, inside):
    camera = motes.Camera(position, (0, 0, -9))
    told = warnings_of(recording(COMPLETE), renderer=motes.Renderer(16, 12, camera=camera, objects=[solid]))
    assert len(told) == (1 if inside else 0)
    assert all("is inside the solid" in one for one in told)


def test_only_the_manager_warns():
    script = """
import motes
world = motes.World(seed=1, space=(-1, 1), progress="off")
s = world.system("rain")
with world:
    for _ in world.frames(3):
        s.burst(motes.shapes.Box((-1, 0, 0), (1, 1, 1)), count=10)
        s.gravity((0, -1, 0))
        world.step()
"""
    result = on_ranks(4, script, timeout=60)
    assert result.code == 0, result.text
    assert result.err.count("MotesWarning: system 'rain'") == 1, result.text


NAMES = sorted(path.stem for path in EXAMPLES.rglob("*.py") if path.stem != "heterogeneous")  # it starts jobs
SOME = {"dam", "fireworks", "flame", "flock", "fountain", "rain", "snow"}
"""Examples that run each time; the slow suite runs all."""


@pytest.mark.parametrize(
    "name",
    [name if name in SOME else pytest.param(name, marks=pytest.mark.slow) for name in NAMES],
)
def test_no_example_gets_a_warning(name: str):
    argv = ("--systems", "2", "--particles", "300", "--frames", "4", "--size", "64x36")
    result = on_ranks(1, next(EXAMPLES.rglob(f"{name}.py")), *argv, timeout=60)
    assert result.code == 0, result.text
    assert "MotesWarning" not in result.err, result.text
