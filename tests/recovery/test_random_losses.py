"""Ranks that are lost at any moment: what the others make has the same bits (tests/support/losses.py)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("av")

import losses  # noqa: E402

from motes import _core  # noqa: E402, F401  (MPI starts, before it is asked without a start what it can do)
from motes._launch import starting  # noqa: E402

pytestmark = pytest.mark.skipif(starting.cannot_survive() is not None, reason=str(starting.cannot_survive()))


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the runs are to which nothing happens."""
    return tmp_path_factory.mktemp("models")


@pytest.mark.parametrize(
    ("ranks", "film", "deaths"),
    [
        # A checkpoint is due, and the last picture is in no file yet. The second world's manager goes, too.
        (4, "inside", [[0, 0, "behind the frame", 5, 0], [1, 1, "before securing the film", 2, 0]]),
        # Nobody knows that the last checkpoint is whole; then the film's writer is lost behind its world.
        (
            3,
            "forgotten",
            [[1, 0, "before the checkpoint's name", 3, 0], [0, 1, "behind the world's end", 1, 0]],
        ),
    ],
)
def test_the_others_go_on(tmp_path, models, ranks, film, deaths):
    plan: dict[str, Any] = {"worlds": 2, "frames": losses.FRAMES, "checkpoint": losses.EVERY, "film": film}
    plan |= {"export": False, "live": film == "inside", "deaths": deaths}
    result = losses.play(tmp_path, ranks, plan)
    assert result.code == 0, result.text
    assert result.err.count("motes: lost rank ") == (2 if film == "inside" else 1), result.text
    model = losses.model(str(models), losses.EVERY, film)
    assert losses.judged(result, tmp_path, model, plan) == "", result.text


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 300, 10))
def test_random_losses(tmp_path, models, first):
    """One rank, or two; `python tests/support/losses.py --from SEED --seeds 1` repeats one."""
    for seed in range(first, first + 10):
        assert losses.broken(tmp_path / str(seed), models, seed) == "", f"seed {seed}"
