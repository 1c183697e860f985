"""The arena: reproducible scores against the best cuts, on virtual machines and on ranks."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motes.balance import BALANCERS, Balancer, PrefixCuts, Proportional, Static, Targets
from motes.cli import main
from motes.errors import ArgumentError, MotesError
from motes_lab.arena import MACHINES, Machine, Track, league, machine, on_ranks, table
from motes_lab.arena.players import FIELD, player
from motes_lab.arena.score import name_of
from motes_lab.workloads import Step, Tasks, best_cuts, workload

FREE = Machine("free", (1.0, 1.0, 0.5, 0.25), 1e-6, 0.0, 0.0, 0.0, 0.0)
MINE = """
import motes

class Mine(motes.balance.Balancer):
    def decide(self, load):
        return motes.balance.Targets(load.powers)
"""


class Keen(Balancer):
    """Moves particles in every frame."""

    def decide(self, load: object) -> Targets:
        """Alternate between equal and graded shares."""
        return Targets(1 + np.arange(4) * (0.2 if load.frame % 2 else 0.0))  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", ["step", "wave", "slow_rank", "noise", "pic_geometric"])
def test_nobody_beats_the_best_cuts(name: str) -> None:
    track = Track(workload(name, frames=30, cells=400, particles=100_000), FREE)
    scores = [track.play(player(text, FREE.speeds)) for text in FIELD]
    for score in scores:
        assert score.verified and score.distance >= -1e-12 and 0 < score.efficiency <= 1 + 1e-12
        over = np.array(score.frame_s) - score.best_s
        assert (over >= -1e-12).all(), score.balancer
    assert all((track.ideal_s <= track.best_s * (1 + 1e-12)).tolist())


def test_a_still_load_comes_to_its_optimum() -> None:
    track = Track(Step(frames=40, cells=400, particles=400_000), FREE)
    score = track.play(PrefixCuts())
    assert score.frame_s[-1] == pytest.approx(score.best_s[-1], rel=0.02)
    assert track.play(Static()).moved == 0 < score.moved


def test_moving_costs_what_the_machine_says() -> None:
    game = workload("slow_rank", frames=30, cells=400, particles=100_000)
    dear = Machine("dear", FREE.speeds, 1e-6, 1e-6, 1e-6, 1e-9, 1e-5)
    free, paid = (Track(game, one).play(Keen()) for one in (FREE, dear))
    assert free.moved == paid.moved > 0 and paid.seconds > free.seconds
    assert Track(game, FREE).play(Static()).seconds == Track(game, dear).play(Static()).seconds


def test_scores_are_the_same_in_each_repeat() -> None:
    first, second = (
        [
            Track(workload("noise", frames=12), machine("two_kinds")).play(player(text, [1.0] * 16))
            for text in FIELD
        ]
        for _ in range(2)
    )
    assert first == second and len({score.balancer for score in first}) == len(FIELD)
    best = league(table.rows(first))
    assert [row["distance"] for row in best] == sorted(row["distance"] for row in best)
    assert sum(row["won"] for row in best) >= 1 and {row["played"] for row in best} == {1}


class Slow(Keen):
    """Takes longer to decide than a frame lasts."""

    def decide(self, load: object) -> Targets:
        """Sleep, then decide."""
        time.sleep(0.01)
        return super().decide(load)


def test_slow_decisions_are_said_but_are_no_part_of_the_score() -> None:
    track = Track(workload("step", frames=5, cells=400, particles=100_000), FREE)
    quick, slow = track.play(Keen(), "same"), track.play(Slow(), "same")
    assert quick == slow and quick.figures == slow.figures and slow.decided_s >= 0.05
    for part, said in ((0.09, False), (0.11, True)):
        score = replace(slow, decided_s=part * slow.seconds)
        assert score.is_slow_to_decide == said and ("same: decisions take" in table.text([score])) == said


def test_machines_are_those_of_their_clusters(tmp_path: Path) -> None:
    assert {name: len(make().speeds) for name, make in MACHINES.items()} == {
        "paper": 32,
        "two_kinds": 16,
        "thousand": 1024,
    }
    assert FREE.move_cost == 0 and 5 < machine("two_kinds").move_cost < 12 and machine("paper").move_cost < 1
    assert machine("paper").particle_s == pytest.approx(4.4e-6), "five actions of model.toml"
    path = tmp_path / "two.py"
    path.write_text("from motes.cluster import Cluster, Node\ncluster = Cluster([Node('n', 2.0, count=2)])\n")
    assert machine(str(path)).speeds == (2.0, 2.0)
    for wrong, error in (("papper", ArgumentError), (str(tmp_path / "none.py"), MotesError)):
        with pytest.raises(error):
            machine(wrong)


def test_players_are_named_as_python_writes_them(tmp_path: Path) -> None:
    assert player("PrefixCuts(threshold=0.2)", [1.0]).threshold == 0.2  # type: ignore[attr-defined]
    for text, cost in (("CostAware", 7.0), ("CostAware(move_cost=2)", 2.0)):
        assert player(text, [1.0], 7.0).move_cost == cost  # type: ignore[attr-defined]
    assert isinstance(player("static"), Static) and isinstance(player("prefix"), PrefixCuts)
    powers = player("Proportional", [2.0, 1.0])
    assert isinstance(powers, Proportional) and name_of(powers) == "Proportional"
    assert name_of(PrefixCuts(threshold=0.2)) == "PrefixCuts(threshold=0.2)" and set(BALANCERS) <= {
        text.partition("(")[0] for text in FIELD
    }
    path = tmp_path / "mine.py"
    path.write_text(MINE)
    assert type(player(f"{path}:Mine", [1.0])).__name__ == "Mine"
    for wrong in ("Prefixcuts", "PrefixCuts(0.2)", "PrefixCuts(", f"{path}:Yours", "1 + 1"):
        with pytest.raises(ArgumentError):
            player(wrong, [1.0])
    with pytest.raises(MotesError):
        player(f"{tmp_path / 'none.py'}:Mine", [1.0])


def test_the_command_plays_a_student_s_balancer(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, kept = tmp_path / "mine.py", tmp_path / "league.jsonl"
    path.write_text(MINE)
    mine = f"{path}:Mine"
    given = ["arena", "-w", "step", "-b", "Static", mine, "--frames", "8", "--particles", "2000"]
    for cluster in ("two_kinds", "two_kinds", "paper"):
        assert main([*given, "--cluster", cluster, "--league", str(kept), "--json"]) == 0
    found = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert [row["balancer"] for row in found["rows"]] == ["Static", mine]
    rows = table.stored(kept)
    assert len(rows) == 4 and all(row["verified"] and row["machine"] in MACHINES for row in rows)
    assert main([*given, "--plot", str(tmp_path / "plot.png")]) == 0
    said = capsys.readouterr().out
    assert "step on paper: 32 calculators" in said and "league" in said
    assert (tmp_path / "plot.png").stat().st_size > 10_000
    assert main(["arena", "--league", "league.csv"]) == 2


def test_results_of_unlike_sizes_are_ranked_apart(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kept = str(tmp_path / "league.jsonl")
    assert main(["arena", "--league", kept]) == 2
    assert "there is no league" in capsys.readouterr().err
    played = ["arena", "-w", "step", "--cluster", "paper", "--league", kept, "--particles"]
    assert main([*played, "500", "--frames", "6", "-b", "Static", "PrefixCuts"]) == 0
    assert main([*played, "700", "--frames", "6", "-b", "Static"]) == 0
    assert main([*played, "500", "--frames", "5", "-b", "PrefixCuts"]) == 0
    capsys.readouterr()
    assert main(["arena", "--league", kept, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    sizes = [(row["balancer"], row["frames"], row["particles"]) for row in found["rows"]]
    assert sorted(sizes) == [
        ("PrefixCuts", 5, 16000),
        ("PrefixCuts", 6, 16000),
        ("Static", 6, 16000),
        ("Static", 6, 22400),
    ]
    ranked = [(row["frames"], row["particles_per_rank"], row["played"]) for row in found["league"]]
    assert ranked == [(6, 500, 1), (6, 500, 1), (6, 700, 1), (5, 500, 1)]
    assert main(["arena", "--league", kept]) == 0
    assert capsys.readouterr().out.count("league: ") == 3
    assert main(["arena", "--league", kept, "--frames", "3"]) == 2
    assert "--frames is for playing" in capsys.readouterr().err
    Path(kept).write_text('{"machine": "paper"}\n')
    assert main(["arena", "--league", kept]) == 2
    assert "is not a league" in capsys.readouterr().err


def test_a_parquet_league_without_pyarrow_is_refused_before_any_game(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(table.importlib.util, "find_spec", lambda _: None)
    kept = tmp_path / "league.parquet"
    assert main(["arena", "-w", "step", "-b", "Static", "--league", str(kept)]) == 2
    said = capsys.readouterr()
    assert "pip install pyarrow" in said.err and not said.out and not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["slow_rank", "noise", "step"])
def test_a_perfect_policy_on_ranks_reaches_the_optimum(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = {"frames": 30, "cells": 1000, "particles": 90_000}
    true, game = np.array([1e6, 2e6, 0.5e6]), workload(name, **sizes)
    act_s, processed = [], np.zeros(3, np.int64)
    for frame in range(30):
        counts, rates = game.acting(frame), true * game.slowdown(frame, 3)
        ends = [0, *best_cuts(counts, rates).starts, len(counts)]
        own = np.diff(np.concatenate([[0], np.cumsum(counts)])[ends])
        act_s.append((own / rates).tolist())
        processed += own
    row = {"act_s": act_s, "processed": processed.tolist(), "moved": 0, "verified": True, "digest": "x"}
    monkeypatch.setattr(on_ranks, "figures_of", lambda *_: {"rows": [row]})
    (score,) = on_ranks.play(name, ["perfect"], 3, **sizes)
    assert score.distance == pytest.approx(0, abs=1e-9) and 0.98 < score.efficiency <= 1 + 1e-9


def test_own_policies_are_told_the_cost_of_moving(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    text = "def __init__(self, {}):\n        self.given = dict(locals())\n\n    def decide"
    for asked, given in (
        ("move_cost=1.0", {"move_cost": 7.0}),
        ("powers, move_cost", {"powers": [2.0, 1.0], "move_cost": 7.0}),
        ("other=3", {"other": 3}),
    ):
        path.write_text(MINE.replace("def decide", text.format(asked)))
        made = vars(player(f"{path}:Mine", [2.0, 1.0], 7.0))["given"]
        assert {key: made[key] for key in given} == given
    path.write_text("from motes.balance import CostAware\n\nclass Mine(CostAware):\n    pass\n")
    assert vars(player(f"{path}:Mine", [1.0], 7.0))["move_cost"] == 7.0


def test_ranks_play_and_verify(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "mine.py"
    path.write_text(MINE)
    sizes = ["--frames", "8", "--particles", "500"]
    players = ["Static", f"{path}:Mine"]
    assert main(["arena", "-w", "slow_rank", "-b", *players, "--ranks", "2", *sizes, "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert [row["balancer"] for row in rows] == players and {row["machine"] for row in rows} == {"2 ranks"}
    assert len({row["digest"] for row in rows}) == 1 and rows[0]["digest"]
    assert all(row["verified"] and row["seconds"] > 0 for row in rows) and rows[0]["moved"] == 0


def test_a_balancer_that_fails_on_ranks_says_where(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "mine.py"
    path.write_text(MINE.replace("return motes.balance.Targets(load.powers)", 'raise KeyError("powers")'))
    sizes = ["--frames", "4", "--particles", "100"]
    assert main(["arena", "-w", "step", "-b", f"{path}:Mine", "--ranks", "2", *sizes]) == 2
    said = capsys.readouterr().err
    assert "KeyError: 'powers'" in said and f'{path}", line 6' in said
    assert "MPI_ABORT" not in said and "prterun" not in said and "x00" not in said


def test_metis_plays_where_it_is_installed(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("pymetis")
    metis = f"{Path(__file__).parent / 'metis.py'}:Metis"
    assert main(["arena", "--workload", "step", "--balancer", metis, "--cluster", "two_kinds", "--json"]) == 0
    assert "Metis" in capsys.readouterr().out


# --- what another code computed


def load_files(folder: Path, phases: int = 1, fixed_s: float = 0.0) -> Path:
    """Write load files of three ranks with ten tasks each, those of rank 2 five times as long."""
    folder.mkdir()
    for rank in range(3):
        tasks = [
            {"entity": {"id": 10 * rank + i, "migratable": True}, "time": 0.01 * (5 if rank == 2 else 1)}
            for i in range(10)
        ]
        if rank == 0:
            tasks.append({"entity": {"id": 99, "migratable": False}, "time": fixed_s})
        own = [{"id": k, "tasks": tasks} for k in range(phases)]
        (folder / f"data.{rank}.json").write_text(json.dumps({"type": "LBDatafile", "phases": own}))
    return folder


def test_tasks_of_another_code_play_between_whole_tasks(tmp_path: Path) -> None:
    tasks = Tasks(load_files(tmp_path / "loads", fixed_s=0.05), frames=20)
    assert (tasks.name, tasks.frames, tasks.cells, tasks.ranks) == ("data", 20, 30, 3)
    equal = Machine("equal", (1.0,) * 3, tasks.particle_s, 0.0, 0.0, 0.0, 0.0)
    track = Track(tasks, equal)
    static, cuts = track.play(Static()), track.play(PrefixCuts(threshold=0.0))
    assert static.seconds == pytest.approx(20 * 0.5, rel=1e-3), "as the files say"
    assert track.best_s[0] == pytest.approx(0.25, rel=1e-3), "0.05 + 0.2, 0.25 and 0.2"
    assert track.ideal_s[0] == pytest.approx(0.75 / 3, rel=1e-3)
    assert static.verified and cuts.verified and cuts.moved > 0 and cuts.distance < 0.3 < static.distance
    twice = Track(tasks, replace(equal, speeds=(2.0,) * 3))
    assert twice.play(Static()).seconds == pytest.approx(static.seconds / 2)
    with pytest.raises(ArgumentError, match="speeds must be 3, for the tasks that belong to their rank"):
        Track(tasks, FREE).play(Static())


def test_the_arena_takes_load_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    place = str(load_files(tmp_path / "loads", phases=4))
    argv = ["arena", "--workload", place, "--balancer", "Static", "PrefixCuts"]
    assert main([*argv, "--frames", "9", "--cluster", "two_kinds", "--json"]) == 0
    (static, cuts) = json.loads(capsys.readouterr().out)["rows"]
    assert static["frames"] == 9 and static["ranks"] == 16 and cuts["seconds"] < static["seconds"]
    assert main([*argv, "--json"]) == 0
    (static, _) = json.loads(capsys.readouterr().out)["rows"]
    assert (static["frames"], static["ranks"], static["workload"]) == (4, 3, "data")
    for wrong, says in (
        (["--ranks", "2"], "--ranks is for made loads"),
        (["--particles", "2"], "--particles is for made loads"),
    ):
        assert main([*argv, *wrong]) == 2 and says in capsys.readouterr().err
    for name in ("stepp", str(tmp_path), str(tmp_path / "none")):
        assert main(["arena", "--workload", name]) == 2
        assert "or a directory of load files" in capsys.readouterr().err
    assert main(["arena", "--workload", "stepp"]) == 2 and "did you mean 'step'" in capsys.readouterr().err


@pytest.mark.parametrize("frames", [0, -1, 1.5, "3", True])
def test_load_files_repeat_whole_phases(frames: object, tmp_path: Path) -> None:
    with pytest.raises(ArgumentError, match="frames"):
        Tasks(load_files(tmp_path / "loads"), frames=frames)  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="a directory of load files"):
        Tasks(tmp_path)
