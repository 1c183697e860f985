"""Random pictures have the same pixels on any ranks, on all paths and with any vector width.

They are compared like random lists of actions: see `tests/support/list_jobs.py`.
"""

from __future__ import annotations

import pytest
from hypothesis import given
from list_jobs import MakeJobs, by_width, jobs, searched, threads
from random_pictures import HEADER, picture_script
from same_bits import widths

__all__ = ["jobs"]


def test_random_pictures(jobs: MakeJobs):
    players = jobs({"1 rank": (1, {}), "3 ranks, narrow": (3, {"MOTES_SIMD": widths()[0]})})

    @searched(10)
    @given(picture_script())
    def search(text: str) -> None:
        players.compare(HEADER + text)

    search()


@pytest.mark.slow
def test_many_random_pictures(jobs: MakeJobs):
    kinds = {f"{size} rank{'s' * (size > 1)}": (size, {}) for size in (1, 2, 3, 5, 8)}
    wide = {f"1 rank, {width}": (1, env) for width, env in by_width().items()}
    players = jobs({**kinds, "2 ranks, 3 threads": (2, threads(3)), **wide})

    @searched(150)
    @given(picture_script())
    def search(text: str) -> None:
        players.compare(HEADER + text)

    search()
