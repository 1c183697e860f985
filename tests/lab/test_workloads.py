"""Workloads: their best cuts are optimal, and the scripts that run them behave as described."""

from __future__ import annotations

from itertools import combinations_with_replacement, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from standing import on_ranks

import motes
from motes.errors import ArgumentError
from motes_lab.workloads import WORKLOADS, Pic, Planned, Step, best_cuts, workload

PLAY = """
import sys, motes
from motes_lab.workloads import workload
game = workload(sys.argv[1], frames=24, cells=64, particles=3000)
world = motes.World(**game.world, balancer=motes.balance.PrefixCuts(), progress="off")
system = world.system("particles")
with world:
    for frame in world.frames(24):
        game.step(system, frame)
        world.step()
    particles = system.gather()
    if particles:
        print("verified", game.verify(particles, 24), game.verify(particles, 23))
    digest = world.digest()
    world.say(f"digest {digest}")
"""


def slowest(counts: np.ndarray, speeds: np.ndarray, other: list[float], starts: list[int]) -> float:
    runs = zip(pairwise([0, *starts, len(counts)]), speeds, other, strict=True)
    return max(float(counts[a:b].sum() / speed) + more for (a, b), speed, more in runs)


@settings(derandomize=True, deadline=None, max_examples=150)
@given(
    st.lists(st.integers(0, 9), min_size=1, max_size=8),
    st.lists(st.sampled_from([0.1, 1 / 3, 1.0, 2.5, 7.0]), min_size=1, max_size=4),
    st.lists(st.sampled_from([0.0, 0.0, 0.7, 4.0, 50.0]), min_size=4, max_size=4),
)
def test_best_cuts_are_those_of_all_cuts_tried(
    cells: list[int], rates: list[float], fixed: list[float]
) -> None:
    counts, speeds, other = np.array(cells), np.array(rates), fixed[: len(rates)]
    every = combinations_with_replacement(range(len(counts) + 1), len(speeds) - 1)
    least = min(slowest(counts, speeds, other, list(starts)) for starts in every)
    found = best_cuts(counts, speeds, other)
    assert found.seconds == least == slowest(counts, speeds, other, found.starts.tolist())


def test_best_cuts_of_many_calculators_are_those_of_the_plain_recurrence() -> None:
    random = np.random.default_rng(4)
    counts, speeds = random.integers(0, 1000, 120), random.uniform(0.5, 2, 17)
    below = np.concatenate([[0], np.cumsum(counts)])
    least = below / speeds[0]  # shortest time of the first calculators with all cells below each
    for speed in speeds[1:]:
        least = np.array(
            [min(max(least[i], (below[j] - below[i]) / speed) for i in range(j + 1)) for j in range(121)]
        )
    assert best_cuts(counts, speeds).seconds == least[-1]


def test_what_cannot_be_divided_is_refused() -> None:
    for counts, speeds in (([-1, 2], [1]), ([1], []), ([1], [0.0]), ([[1]], [1])):
        with pytest.raises(ArgumentError):
            best_cuts(counts, speeds)
    for fixed in ([1.0], [-1.0, 0.0], [np.nan, 0.0], [[0.0, 0.0]]):
        with pytest.raises(ArgumentError, match="fixed_s"):
            best_cuts([1], [1, 1], fixed)
    assert best_cuts([0, 0], [1, 1]).seconds == 0


@pytest.mark.parametrize("name", WORKLOADS)
def test_a_workload_keeps_its_particles(name: str) -> None:
    game = workload(name, frames=30, cells=200, particles=12_345)
    alive = np.cumsum([game.births(frame).sum() for frame in range(30)])
    assert [game.counts(frame).sum() for frame in range(30)] == alive.tolist() and alive[-1] == 12_345
    assert [game.acting(frame).sum() for frame in range(30)] == alive.tolist()
    history = Planned(game, np.full(7, 1e6))
    assert all(history.moment(k, 0).density.total == alive[k] for k in range(30))


@pytest.mark.parametrize("name", WORKLOADS)
def test_a_script_plays_a_workload(name: str) -> None:
    digests = set()
    for ranks in (1, 2, 4, 8):
        said = on_ranks(ranks, PLAY, name).out.split("\n")
        (verified,) = (line for line in said if line.startswith("verified"))
        assert verified.startswith("verified True"), (name, ranks)
        if name.startswith(("pic", "wave")):
            assert verified == "verified True False", "one step less is another place"
        digests |= {line for line in said if line.startswith("digest")}
    assert len(digests) == 1


@pytest.mark.parametrize(("k", "m"), [(0, 0), (0, -1), (2, 5), (40, -77)])
def test_pic_drifts_by_k_and_m(k: int, m: int) -> None:
    pic = Pic("sinusoidal", k=k, m=m, cells=90, particles=2000, frames=49)
    world = motes.World(**pic.world, progress="off")
    system = world.system("particles")
    with world:
        for frame in world.frames(49):
            pic.step(system, frame)
            world.step()
        particles = system.gather()
    assert pic.verify(particles, 49) and not pic.verify(particles, 48)
    particles.position[7, 1] += 1
    assert not pic.verify(particles, 49)


def test_pic_is_distributed_as_the_kernel_says() -> None:
    def columns(distribution: str, **options: object) -> np.ndarray:
        return Pic(distribution, cells=100, particles=10**6, **options).births(0) / 1e6

    x = np.arange(100)
    geometric = 0.95**x / (0.95**x).sum()
    np.testing.assert_allclose(columns("geometric", ratio=0.95), geometric, atol=1e-6)
    wave = np.cos(np.pi * x / 99) ** 2
    np.testing.assert_allclose(columns("sinusoidal"), wave / wave.sum(), atol=1e-6)
    falling = 3 - x / 100
    np.testing.assert_allclose(columns("linear"), falling / falling.sum(), atol=1e-6)
    patch = columns("patch", patch=(10, 29, 5, 6))
    np.testing.assert_allclose(patch[10:30], 1 / 20, atol=1e-6)
    assert patch.sum() == pytest.approx(1) and not patch[:10].any() and not patch[30:].any()


def test_pic_refuses_what_has_no_answer() -> None:
    for options in ({"cells": 99}, {"distribution": "even"}, {"patch": (5, 2, 0, 1)}, {"offset": 0.5}):
        with pytest.raises(ArgumentError):
            Pic(**{"cells": 100, **options})
    with pytest.raises(ArgumentError):
        workload("stepp")
    assert repr(Step(particles=5)) == "<step: 5 particles in 1000 cells, 60 frames>"
