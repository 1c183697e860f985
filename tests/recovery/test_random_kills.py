"""Ranks killed at any moment: all files are those of an undisturbed run (tests/support/kills.py)."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("av")

import kills  # noqa: E402

from motes import _core  # noqa: E402, F401  (MPI must start before the query below, which does not start it)
from motes._launch import starting  # noqa: E402

pytestmark = pytest.mark.skipif(starting.cannot_survive() is not None, reason=str(starting.cannot_survive()))


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the undisturbed run."""
    return tmp_path_factory.mktemp("models")


@pytest.mark.parametrize(
    ("ranks", "mode", "killed"),
    [(3, "survive", [[2, "frame", 0, 0]]), (4, "survive,export", [[1, "name", 5, 1]])],
)
def test_a_kill_changes_nothing(tmp_path, models, ranks, mode, killed):
    result = kills.play(tmp_path, ranks, mode, killed)
    assert (result.code == 0) == (mode == "survive"), result.text
    if result.code != 0:
        assert kills.SENTENCE.search(result.err), result.text
        again = kills.play(tmp_path, 3, mode, [])
        assert again.code == 0, again.text
    wanted = kills.model(str(models))
    made = kills.results(tmp_path, mode)
    assert made == {name: wanted[name] for name in made}


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 120, 6))
def test_random_kills(tmp_path, models, first):
    """`python tests/support/kills.py --from SEED --seeds 1` repeats a case."""
    for seed in range(first, first + 6):
        assert kills.broken(tmp_path / str(seed), models, seed)[0] == "", f"seed {seed}"
