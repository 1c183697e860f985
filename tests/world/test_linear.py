"""The cost of recording is linear: calls are counted, or the times for n and 4 n are compared."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import pytest

import motes

LINEAR = 6.0
"""Limit for the growth of cost when the work grows 4 times: linear cost grows 4 times, quadratic 16 times."""


def calls_of(work: Callable[[], object]) -> int:
    """Count the Python and C functions that `work` calls."""
    count = 0

    def note(_frame: Any, event: str, _what: Any) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(note)
    try:
        work()
    finally:
        sys.setprofile(None)
    return count


def test_recording_calls_as_many_functions_for_each_action():
    world = motes.World(seed=1, progress="off")
    snow = world.system("snow")

    def record(actions: int) -> None:
        for _ in range(actions):
            snow.gravity((0, -1, 0))
            snow.burst((0, 0, 0), count=1)

    with world:
        few = calls_of(lambda: record(100))
        world.step()
        many = calls_of(lambda: record(400))
        world.step()
    assert many < LINEAR * few


def test_making_a_system_calls_as_many_functions_however_many_there_are():
    world = motes.World(seed=1, progress="off")

    def make(first: int, last: int) -> None:
        for i in range(first, last):
            world.system(f"system {i}")

    first = calls_of(lambda: make(0, 100))
    make(100, 1000)
    assert calls_of(lambda: make(1000, 1100)) < 2 * first


def seconds(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start


@pytest.mark.slow
def test_a_frame_of_four_times_the_actions_costs_four_times_as_much():
    """The core once took 4.2 s for 16,000 actions per frame; now it takes 16 ms."""
    least = []
    for actions in (4_000, 16_000):
        world = motes.World(seed=1, progress="off")
        snow = world.system("snow")
        times = []
        with world:
            snow.burst((0, 0, 0), count=100)
            world.step()
            for _ in range(5):
                for _ in range(actions):
                    snow.gravity((0, -1, 0))
                times.append(seconds(world.step))
        least.append(min(times))
    assert least[1] < 2 * LINEAR * least[0]
