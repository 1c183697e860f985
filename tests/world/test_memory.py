"""Memory use is constant over a long run in which everything is created and deleted."""

from __future__ import annotations

import sys
from pathlib import Path
from statistics import median

import pytest

pytest.importorskip("av")

from launching import command  # noqa: E402

from motes._launch.starting import cannot_survive  # noqa: E402

SCENE = Path(__file__).parents[1] / "scenes" / "long_run.py"


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("keeps", [False, True], ids=["alone", "with replicas and checkpoints"])
def test_ranks_do_not_grow(tmp_path: Path, keeps: bool) -> None:
    """10,000 frames on 4 ranks have births, deaths, children, moving domains, pictures, a film and a log."""
    if keeps and (why := cannot_survive()):
        pytest.skip(why)
    run = [sys.executable, "-m", "motes", "run", "-n", 4, *["--survive"] * keeps]
    result = command([*run, SCENE, tmp_path, 10_000, *["--keep"] * keeps], timeout=580)
    assert result.code == 0, result.text
    rows = [list(map(int, line.split())) for line in result.out.splitlines() if line[:1].isdigit()]
    assert [row[0] for row in rows] == [0, 1, 2, 3]
    for rank, *tenths in rows:  # a median, since a checkpoint may be in progress at one of them
        assert tenths[-1] <= 1.005 * median(tenths[4:7]), (rank, tenths)
