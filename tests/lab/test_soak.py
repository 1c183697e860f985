"""`motes soak`: a sample of its seeds, and its report of seeds for which a check failed."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

import pytest

from motes.cli import main
from motes_lab import compiled


def figures(capsys: pytest.CaptureFixture[str], *argv: str) -> dict[str, Any]:
    assert main(["soak", *argv, "--json"]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def test_disasters(capsys):
    found = figures(capsys, "disasters", "--seeds", "60", "--from", "5000", "--jobs", "1")
    assert found["broken"] == 0 and found["seeds_broken"] == []
    assert found["losses"] + found["restarts"] + found["orders"] == 60
    assert found["died"] > 20 and found["survived"] > 20


def test_damaged_files(capsys):
    found = figures(capsys, "files", "--seeds", "800", "--jobs", "1")
    assert found["broken"] == 0
    assert found["scenes"] + found["parts"] + found["states"] + found["tables"] == 800
    assert 0 < found["read"] < 400


def test_several_processes_take_their_part():
    argv = [sys.executable, "-m", "motes", "soak", "files", "--seeds", "100", "--jobs", "2", "--json"]
    ended = subprocess.run(argv, capture_output=True, text=True, timeout=60, check=True)
    assert json.loads(ended.stdout)["seeds"] == 100


def test_a_broken_promise_is_told_with_its_seed(capsys, monkeypatch):
    disaster = compiled.disaster
    wrong = {7: "particles differ"}
    monkeypatch.setattr(compiled, "disaster", lambda seed: {**disaster(seed), "broken": wrong.get(seed, "")})
    assert main(["soak", "disasters", "--seeds", "5", "--from", "5"]) == 1
    said = capsys.readouterr()
    assert "seed 7: particles differ" in said.err
    assert "1 broke a promise" in said.out


@pytest.mark.slow
@pytest.mark.parametrize("what", ["disasters", "files"])
def test_more_of_it(capsys, what):
    assert figures(capsys, what, "--seeds", "2000", "--from", "100000")["broken"] == 0
