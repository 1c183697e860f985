"""`collide` compared with LAMMPS: the commands that LAMMPS gets, and the output if it is not installed.

A module of the same name stands in for LAMMPS; `MOTES_TEST_LAMMPS` names a Python that has the real one.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import pytest

from motes_lab.bench.meetings import REACH
from motes_lab.bench.peers import lammps_run
from motes_lab.bench.peers.spheres import NotInstalled, spheres
from motes_lab.cli.bench import _colliding as shown

MODULE = """
import time
__version__ = "20990101"

class lammps:
    def __init__(self, cmdargs):
        assert cmdargs == ["-log", "none", "-screen", "none"]

    def command(self, text):
        if text.startswith("run 10 "):
            until = time.process_time() + 0.02
            while time.process_time() < until:
                pass

    def create_atoms(self, count, ids, types, x, v):
        assert len(types) == count and len(x) == len(v) == 3 * count
        return count

    def extract_compute(self, name, style, kind):
        return CONTACTS
"""


class Asked:
    """Stands in for LAMMPS' class and records its commands."""

    def __init__(self, cmdargs: list[str]) -> None:
        self.said: list[str] = []
        self.made: tuple[Any, ...] = ()

    def command(self, text: str) -> None:
        self.said.append(text)

    def create_atoms(self, *arguments: Any) -> int:
        self.made = arguments
        return len(arguments[2])

    def extract_compute(self, name: str, style: int, kind: int) -> float:
        assert (name, style, kind) == ("mean", 0, 0)  # style 0: global, type 0: scalar
        return 7.1


@pytest.fixture
def python(tmp_path: Path):
    """Make a program that runs this Python with a stand-in for `lammps` that reports these contacts."""

    def make(contacts: float) -> str:
        (tmp_path / "lammps.py").write_text(MODULE.replace("CONTACTS", repr(contacts)))
        program = tmp_path / "python"
        program.write_text(f'#!/bin/sh\nPYTHONPATH={tmp_path} exec {sys.executable} "$@"\n')
        program.chmod(0o755)
        return str(program)

    return make


@pytest.mark.parametrize(
    ("lists", "built", "skin"),
    [("each", "every 1 delay 0 check no", "0.0"), ("kept", "every 1000000 delay 1000000 check no", "0.05")],
)
def test_lammps_is_asked_for_the_same_spheres(lists: str, built: str, skin: str):
    positions, velocities = [-1.5, 0.0, 3.2, 2.0, 1.0, 0.5], [0.1] * 6
    run = lammps_run.Run(Asked, positions, velocities, 1.25, lists)
    asked: Any = run._lammps
    assert asked.made == (2, None, [1, 1], positions, velocities)
    assert "region box block -3 5 -3 5 -3 5" in asked.said  # more than a metre beyond all spheres
    assert "set group all diameter 1.25 density 1" in asked.said
    assert f"neigh_modify {built}" in asked.said and f"neighbor {skin} bin" in asked.said
    assert "pair_style gran/hooke 10000 2857 50 25 0.5 1" in asked.said
    assert run.contacts == 7.1
    assert asked.said[-1] == "run 0 post no"  # measurements compute only the steps
    assert asked.said.index("uncompute contacts") > asked.said.index("compute contacts all contact/atom")
    assert run.seconds(10) >= 0
    assert asked.said[-1] == "run 10 pre no post no"


def test_both_are_timed_in_turn(python: Any):
    figures = spheres(particles=2000, rounds=2, python=python(6.37))
    rows = {row["peer"]: row for row in figures["rows"]}
    assert list(rows) == ["collide", "lammps, list built each step", "lammps, list kept"]
    assert rows["collide"]["engine_by_peer"] == 1
    each = rows["lammps, list built each step"]
    assert 1000 < each["ns"] < 2000  # 0.02 s for ten steps of 2000 spheres
    assert each["engine_by_peer"] == pytest.approx(each["ns"] / rows["collide"]["ns"], rel=0.5)
    assert figures["lammps"] == "20990101"
    text = "\n".join(shown(figures))
    assert "2000 spheres, 6.4 neighbours each, LAMMPS 20990101" in text
    assert "lammps, list kept" in text and "NaN" not in text


def test_other_neighbours_are_noticed(python: Any):
    with pytest.raises(RuntimeError, match=r"LAMMPS finds 5 neighbours per sphere, the engine 6\.367"):
        spheres(particles=2000, rounds=1, python=python(5.0))


def test_a_python_without_lammps_is_named(tmp_path: Path):
    program = tmp_path / "python"
    program.write_text("#!/bin/sh\necho \"ModuleNotFoundError: No module named 'lammps'\" >&2\nexit 1\n")
    program.chmod(0o755)
    with pytest.raises(NotInstalled, match=rf"not installed in {program} \(ModuleNotFoundError.*--lammps"):
        spheres(particles=2000, rounds=1, python=str(program))


def test_lammps_itself_sees_the_same_neighbours():
    named = os.environ.get("MOTES_TEST_LAMMPS")
    if not named:
        pytest.skip("MOTES_TEST_LAMMPS names no Python that has LAMMPS")
    figures = spheres(particles=8000, rounds=1, python=named)
    assert figures["neighbours"] < REACH * 7
    assert all(row["ns"] > 0 for row in figures["rows"])
