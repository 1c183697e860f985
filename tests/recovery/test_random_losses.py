"""Ranks lost at any moment: the others produce the same bits (tests/support/losses.py)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("av")

import losses  # noqa: E402

from motes import _core  # noqa: E402, F401  (MPI must start before the query below, which does not start it)
from motes._launch import starting  # noqa: E402

pytestmark = pytest.mark.skipif(starting.cannot_survive() is not None, reason=str(starting.cannot_survive()))


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the undisturbed runs."""
    return tmp_path_factory.mktemp("models")


@pytest.mark.parametrize(
    ("ranks", "film", "deaths"),
    [
        # A checkpoint is due and the last picture is not on disk. The second world's manager is lost too.
        (4, "inside", [[0, 0, "behind the frame", 5, 0], [1, 1, "before securing the film", 2, 0]]),
        # No rank knows that the last checkpoint is complete; then the film's writer is lost after its world.
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
    """One or two ranks are lost; `python tests/support/losses.py --from SEED --seeds 1` repeats a case."""
    for seed in range(first, first + 10):
        assert losses.broken(tmp_path / str(seed), models, seed) == "", f"seed {seed}"
