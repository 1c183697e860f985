"""Random lists of actions give the same particles and pictures with any ranks, threads and vector width."""

from __future__ import annotations

import pytest
from hypothesis import given
from list_jobs import MakeJobs, by_width, jobs, searched, threads
from random_lists import HEADER, KINDS, script
from same_bits import widths

__all__ = ["jobs"]


def test_every_action_is_drawn():
    assert len(KINDS) >= 33


def test_random_lists(jobs: MakeJobs):
    narrow = {"MOTES_SIMD": widths()[0]}
    players = jobs(
        {"1 rank": (1, threads(1)), "2 ranks, 3 threads": (2, threads(3)), "3 ranks, narrow": (3, narrow)}
    )

    @searched(10)
    @given(script())
    def search(text: str) -> None:
        players.compare(HEADER + text)

    search()


@pytest.mark.slow
def test_many_random_lists(jobs: MakeJobs):
    kinds = {f"{size} rank{'s' * (size > 1)}": (size, {}) for size in (1, 2, 3, 5)}
    threaded = {
        f"{size} ranks, {count} threads": (size, threads(count))
        for size, count in ((1, 2), (2, 3), (3, 7), (5, 2))
    }
    wide = {f"1 rank, {width}": (1, env) for width, env in by_width().items()}
    players = jobs({**kinds, **threaded, **wide})

    @searched(250)
    @given(script())
    def search(text: str) -> None:
        players.compare(HEADER + text)

    search()
