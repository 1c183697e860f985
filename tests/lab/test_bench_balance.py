"""`bench balance`: balancers compared on synthetic and recorded loads."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from handmade import moving_spot

from motes.cli import main
from motes.replay.loads import LOADS


def test_bench_prints_a_table_and_json(capsys: pytest.CaptureFixture[str]) -> None:
    argv = ["balance", "--frames", "6", "--calculators", "8"]
    assert main(["bench", *argv, "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert {row["load"] for row in figures["rows"]} == set(LOADS)
    assert figures["planning_calculators"] == 4096
    assert all(ms < 10 for ms in figures["planning_ms"].values()), figures["planning_ms"]
    assert {"PrefixCuts", "Pairwise", "Diffusive"} <= set(figures["planning_ms"])
    assert main(["bench", *argv]) == 0
    text = capsys.readouterr().out
    assert "mean imbalance" in text and "planning for 4096" in text


def test_bench_compares_on_a_recorded_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = moving_spot(tmp_path / "log")
    assert main(["bench", "balance", "--run", str(log), "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    worth = {row["balancer"]: row["mean_imbalance"] for row in rows}
    assert worth["PrefixCuts"] < worth["Static"]
