"""`bench peers`: each peer computes the same physics, and missing peers are reported.

Times are not checked, because machines differ.
"""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec
from typing import Any

import pytest

from motes.cli import main
from motes_lab.bench.peers import PEERS, numpy_run, peers

OPTIONAL = [name for name in PEERS if name != "numpy"]


@pytest.fixture
def only_numpy(monkeypatch: pytest.MonkeyPatch):
    for name in OPTIONAL:
        monkeypatch.setitem(sys.modules, PEERS[name].module, None)


def test_what_is_not_installed_is_said(only_numpy: None, capsys: pytest.CaptureFixture[str]):
    assert (
        main(["bench", "peers", "--particles", "20000", "--steps", "2", "--lammps", "/no/python", "--busy"])
        == 0
    )
    assert "/no/python: No such file or directory" in capsys.readouterr().out
    assert main(["bench", "peers", "--particles", "20000", "--steps", "2", "--busy"]) == 0
    text = capsys.readouterr().out
    for name in OPTIONAL:
        assert f"not installed: pip install '{PEERS[name].package}', or the extra motes[peers]" in text
    assert "NaN" not in text
    figures = peers(particles=20000, steps=2, threads=1, busy=True)
    assert [row["peer"] for row in figures["rows"]] == ["motes", "numpy"]
    assert set(figures["not_installed"]) - {"lammps"} == {*OPTIONAL}
    assert figures["rows"][0]["engine_by_peer"] == 1


@pytest.mark.parametrize("name", OPTIONAL)
def test_a_peer_agrees_with_the_engine(name: str):
    """The command compares the particles itself; it runs in its own process, as peers print and warn."""
    if find_spec(PEERS[name].module) is None:
        pytest.skip(f"{PEERS[name].package} is not installed")
    command = [
        sys.executable,
        "-m",
        "motes",
        "bench",
        "peers",
        "--particles",
        "20000",
        "--steps",
        "3",
        "--json",
        "--busy",
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=280, check=False)
    assert done.returncode == 0, done.stderr
    rows: list[dict[str, Any]] = json.loads(done.stdout)["rows"]
    row = next(row for row in rows if row["peer"] == name)
    assert row["million_per_s"] > 0
    assert row["engine_by_peer"] > 0
    assert row["leaves_out"]


@pytest.mark.parametrize(
    ("wrong", "value", "column"),
    [
        ("GUST", (3.0, 1.0, 2.0), "vx"),
        ("RESTITUTION", 1.0, "vy"),
        ("FRICTION", -20.0, "x"),
        ("DT", 1 / 20, "x"),
    ],
)
def test_wrong_physics_is_noticed(
    wrong: str, value: Any, column: str, only_numpy: None, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(numpy_run, wrong, value)
    with pytest.raises(RuntimeError, match=f"numpy and the engine disagree: .*{column} "):
        peers(particles=20000, steps=3, threads=1, busy=True)
