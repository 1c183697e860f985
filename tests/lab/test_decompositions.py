"""The page about decompositions: its crowds run, and its tables show the stored figures."""

from __future__ import annotations

import json
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from standing import on_ranks

PAGES = Path(__file__).parents[2] / "docs" / "lab"


@pytest.fixture(scope="module")
def made() -> dict[str, Any]:
    return runpy.run_path(str(PAGES / "scripts" / "make_decompositions.py"))


def test_tables_show_the_figures_that_are_kept(made: dict[str, Any]):
    known = json.loads((PAGES / "scripts" / "decompositions.json").read_text())
    page = (PAGES / "decompositions.md").read_text()
    for part in ("real", "virtual"):
        assert made["table"](part, known[part]) in page


@pytest.mark.parametrize("crowd", ["heap", "flock", "ball"])
def test_crowds_are_the_same_however_space_is_cut(crowd: str, tmp_path: Path):
    script = (PAGES / "scripts" / "decompositions_crowds.py").read_text()
    script = script.replace("world.step()", "world.step(), world.say(world.digest())")
    options = [f"--crowd={crowd}", "--particles=100", "--calculators=4", "--frames=2", "--space=fit"]
    alone = on_ranks(1, script, *options).lines
    assert len(alone) == 2
    assert on_ranks(5, script, *options, "--axis=xyz").lines == alone


def test_a_run_gives_its_figures(made: dict[str, Any], tmp_path: Path):
    import motes

    script = str(PAGES / "scripts" / "decompositions_crowds.py")
    command = [sys.executable, "-m", "motes", "run", "-n", "4", script]
    command += ["--crowd=flock", "--particles=500", "--calculators=2", "--frames=2", "--space=fit"]
    subprocess.run([*command, f"--log={tmp_path / 'log'}"], check=True, capture_output=True, timeout=200)
    found = made["figures_of"](motes.open_run(tmp_path / "log"), 1, 800.0)
    assert found["calculators"] == 2
    assert 0 < found["ghosts"] < 0.2  # each half of a 93 m cube has a 2 m layer of ghosts
    assert found["bytes"] > 800 * 32 * found["ghosts"] * 1000 - 1
    assert 1 <= found["share"] < 1.1
