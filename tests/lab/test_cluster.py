"""Virtual clusters: their files, and runs on them if SimGrid is installed."""

from __future__ import annotations

import json
import math
import sys
import xml.etree.ElementTree as ElementTree
from collections import Counter
from pathlib import Path

import pytest
from launching import command

from motes.balance import PrefixCuts, Static
from motes.cli import main
from motes.errors import ArgumentError, MotesError
from motes_lab.arena.players import player
from motes_lab.cluster import (
    Cluster,
    FastEthernet,
    Modern,
    Myrinet,
    Network,
    Node,
    growth,
    migrant_s,
    simulate,
)
from motes_lab.cluster import build as build_module
from motes_lab.cluster.paper import experiment, in_text, model, show
from motes_lab.cluster.paper.experiment import Row
from motes_lab.cluster.paper.tables import IN_TEXT, cells
from motes_lab.cluster.platform import hosts, platform
from motes_lab.cluster.simulate import record

ROOT = Path(__file__).parents[2]
SNOW = ROOT / "examples" / "snow.py"
SMALL = ("--systems", 2, "--particles", 600, "--frames", 4, "--size", "64x36", "--space", "-30,30")
TWO_NETWORKS = Cluster(
    [
        Node("b", 1.0, cores=2, count=2, sharing=0.8),
        Node("a", 0.5, cores=2, count=1, ranks=1),
        Node("c", 4.0, count=1, networks=("Fast Ethernet",)),
    ],
    [Myrinet(), FastEthernet()],
)


def links(text: str) -> dict[tuple[str, str], list[str]]:
    """Return the links between each pair of hosts in a platform file."""
    zone = ElementTree.fromstring(text)[0]
    return {
        (route.attrib["src"], route.attrib["dst"]): [link.attrib["id"] for link in route]
        for route in zone.findall("route")
    }


def test_platform_has_each_machine_and_each_route_once():
    zone = ElementTree.fromstring(platform(TWO_NETWORKS))[0]
    speeds = {host.attrib["id"]: host.attrib["speed"] for host in zone.findall("host")}
    assert speeds == {
        "b-0": "800000000.0f",
        "b-1": "800000000.0f",
        "a-0": "500000000.0f",
        "c-0": "4000000000.0f",
    }
    known = {link.attrib["id"]: link.attrib for link in zone.findall("link")}
    assert "Myrinet c-0" not in known and known["Myrinet a-0"]["bandwidth"] == f"{2e9 / 8!r}Bps"
    assert known["Fast Ethernet c-0"]["latency"] == "3e-05s"
    routes = links(platform(TWO_NETWORKS))
    assert len(routes) == 4 + 4 * 3 // 2 and all(set(ids) <= set(known) for ids in routes.values())
    assert routes["b-0", "a-0"] == ["Myrinet b-0", "Myrinet a-0"]
    assert routes["b-0", "c-0"] == ["Fast Ethernet b-0", "Fast Ethernet c-0"], "the network that both have"
    assert routes["b-1", "b-1"] == ["memory b-1"]


def test_machines_of_one_kind_take_one_line():
    text = platform(Cluster([Node("n", 2.0, cores=2, count=4096)], Network("wire", 1e9, 2e-6)))
    (found,) = ElementTree.fromstring(text)
    assert len(text) < 600 and found.attrib["radical"] == "0-4095" and found.attrib["prefix"] == "n-"
    assert (found.attrib["speed"], found.attrib["lat"]) == ("2000000000.0f", "1e-06s")


def test_ranks_go_to_machines_in_their_order():
    assert hosts(TWO_NETWORKS).split() == ["b-0", "b-0", "b-1", "b-1", "a-0", "c-0"]
    assert TWO_NETWORKS.ranks == 6
    crowded = Node("x", 2.0, cores=2, ranks=4, sharing=0.5)
    assert crowded.rank_speed == 0.5, "half of it shared, and two ranks a core"


def test_a_migrant_costs_work_at_both_ends_and_its_bytes(tmp_path: Path):
    (tmp_path / "costs").write_text("leave = 300\narrive = 100\n")
    wire = Network("wire", 1e6, 0.0)
    cluster = Cluster([Node("fast", 2.0), Node("slow", 0.5)], wire)
    assert migrant_s(cluster, tmp_path / "costs", size=40) == pytest.approx(200e-9 * (0.5 + 2) / 2 + 40e-6)
    assert migrant_s(cluster, scale=3) == pytest.approx(3 * migrant_s(cluster))


def test_what_is_no_cluster_is_refused():
    with pytest.raises(ArgumentError, match="nodes must be at least one Node"):
        Cluster([])
    with pytest.raises(ArgumentError, match="nodes must be Nodes with different names"):
        Cluster([Node("b"), Node("b")])
    with pytest.raises(ArgumentError, match="speed of b"):
        Node("b", speed=0)
    with pytest.raises(ArgumentError, match="sharing of b"):
        Node("b", sharing=2)
    with pytest.raises(ArgumentError, match="bandwidth of wire"):
        Network("wire", 0, 0)
    with pytest.raises(ArgumentError, match="networks of b must be among"):
        Cluster([Node("b", networks=("wire",))], Modern())
    apart = [Node("a", networks=("Myrinet",)), Node("b", networks=("Fast Ethernet",))]
    with pytest.raises(ArgumentError, match="networks must be such that one connects a and b"):
        Cluster(apart, [Myrinet(), FastEthernet()])


def test_the_papers_tables_are_whole():
    assert [len(cells(table)) for table in (1, 2, 3, IN_TEXT)] == [24, 8, 24, 8]
    for cell in (cell for table in (1, 2, 3, IN_TEXT) for cell in cells(table)):
        assert model.cluster(cell).ranks == cell.processes, cell
    mixed = cells(2)[3]
    assert mixed.nodes == "8*B (16 P.) + 8*A (16 P.) = 32 P."
    assert Counter(line[0] for line in hosts(model.cluster(mixed)).split()) == {"B": 16, "A": 16}
    assert cells(1)[-1].nodes == "8*B /16 P." and cells(1)[-1].finite and cells(1)[-1].dynamic
    for table in (1, 2, 3):
        names = {f"{cell.nodes} {cell.variant}" for cell in cells(table)}
        assert set(model.model()["fitted"][str(table)]) <= names, "what was fitted is a cell"


def test_a_table_is_shown_as_text_values_and_plot(tmp_path: Path):
    rows = [Row(cell, ours=cell.speedup * 1.1, best=9.0) for cell in cells(1)]
    rows[0] = Row(rows[0].cell, ours=1.0, best=9.0)
    facts = show.facts(rows)
    assert facts["near"] == 23 and facts["within"] == 0.2
    first = facts["rows"][0]
    assert (first["nodes"], first["variant"], first["paper"], first["ours"], first["best"]) == (
        *("4*B /4 P.", "IS-SLB", 1.74),
        *(1.0, 9.0),
    )
    assert "23 of 24 cells are within 20 %" in show.text(rows) and "-43%" in show.text(rows)
    show.plot(rows, tmp_path / "table.png")
    assert (tmp_path / "table.png").read_bytes().startswith(b"\x89PNG")


def test_what_stands_in_the_papers_text_alone(monkeypatch: pytest.MonkeyPatch, capsys):
    wanted = []

    def measure(asked, jobs):
        """Model eight A that add less the more B there are, and more if each machine runs two processes."""
        wanted.extend(asked)
        for cell in asked:
            assert model.cluster(cell).ranks == cell.processes, cell
        fast = [sum(node.count for node in model.cluster(cell).nodes if node.name == "B") for cell in asked]
        slow = ["A" in cell.hosts for cell in asked]
        twice = [cell.processes - 16 * more == 2 * n for n, more, cell in zip(fast, slow, asked, strict=True)]
        ours = [
            n + more * (2.2 - 0.4 * n + 2 * two) if math.isnan(cell.speedup) else cell.speedup
            for n, more, two, cell in zip(fast, slow, twice, asked, strict=True)
        ]
        return [Row(cell, ours=one, best=2 * one) for cell, one in zip(asked, ours, strict=True)]

    monkeypatch.setattr(in_text, "measure", measure)
    assert main(["cluster", "paper", "--text", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert [row["paper"] for row in facts["speedups"]] == [2.76, 2.93, 2.56, 2.65, 4.28, 4.28, 1.26, 1.26]
    assert all(row["ours"] == row["paper"] for row in facts["speedups"])
    saved = [(row["paper"], round(row["of_the_table"]), round(row["ours"])) for row in facts["saved_percent"]]
    assert saved == [(84, 85, 85), (68, 68, 68), (66, 74, 74)], "the text says less than Table 3"
    slow = facts["eight_slow_nodes"]
    assert (slow["pay_below"], slow["ours"], slow["ours_two_each"]) == (7, 6, None)
    assert [row["fast"] for row in slow["rows"]] == [4, 5, 6, 7, 8] * 2
    assert len(wanted) == 8 + 3 + 2 * 5 * 2
    assert main(["cluster", "paper", "--text"]) == 0
    said = capsys.readouterr().out
    assert "fewer than 7 B; here" in said and "next to fewer than 6; with two, next to all of these" in said
    assert main(["cluster", "paper", "--text", "--plot", "a.png"]) == 2
    assert "use it with --table" in capsys.readouterr().err


def test_without_simgrid_one_sentence_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.setenv("MOTES_SMPIRUN", "no-such-smpirun")
    with pytest.raises(MotesError, match="apt-get install libsimgrid-dev"):
        simulate(tmp_path / "x.motes", Cluster([Node("b")]), log=tmp_path / "log")
    made = command([sys.executable, "-m", "motes", "cluster", "paper", "--table", "1"])
    assert made.code == 2 and made.err.count("\n") == 1 and "libsimgrid-dev" in made.err, made.text


def test_many_ranks_talk_along_trees_and_rings(simulated_replay: Path, tmp_path: Path, monkeypatch):
    monkeypatch.setenv("MOTES_SMPI_REPLAY", str(simulated_replay))
    scene = tmp_path / "snow.motes"
    record(scene, SNOW, [*SMALL, "--out", tmp_path])
    frames = []
    many = ["--births", "calculators", "--fan-out", "3"]
    for nodes, shared, more in (
        ([Node("n", count=3)], True, []),
        ([Node("n", count=14)], True, many),
        ([Node("n", count=7), Node("m", count=7)], False, many),
    ):
        cluster = Cluster(nodes, Network("wire", 1e9, 1e-6, overhead_s=1e-7, shared=shared))
        log = tmp_path / f"log-{len(frames)}"
        run = simulate(scene, cluster, log=log, scale=4, options=["--digest", *more])
        frames.append(run.frames[["particles", "particles_digest", "image_sha256"]].to_numpy().tolist())
        assert run.frames["t_frame_s"].min() > 0, "messages take time"
    assert len(frames[0]) == 4 and frames[0] == frames[1] == frames[2]


def test_growth_tells_the_phases_of_a_frame(simulated_replay: Path, tmp_path: Path, monkeypatch):
    monkeypatch.setenv("MOTES_SMPI_REPLAY", str(simulated_replay))
    monkeypatch.setattr(growth, "COMPUTED", 3000)
    rows = [row for way in growth.WAYS for row in growth.grow([5], way)]
    for row in rows:
        assert row.computed == 1000 and 0 < row.efficiency < 1
        assert sum(row.phases.values()) == pytest.approx(row.frame_s, rel=0.02), "nothing is left out"
        assert row.phases["act"] == pytest.approx(400_000 * 4.3e-9, rel=0.1) and row.phases["render"] == 0
    assert rows[0].talk < rows[1].talk, "a manager that makes all births is waited for"
    assert [row["way"] for row in growth.facts(rows)["rows"]] == list(growth.WAYS)
    assert "calculators" in growth.text(rows)
    growth.plot(rows, tmp_path / "growth.png")
    assert (tmp_path / "growth.png").read_bytes().startswith(b"\x89PNG")


def test_pictures_of_many_ranks_are_drawn_by_all(simulated_replay: Path, monkeypatch):
    monkeypatch.setenv("MOTES_SMPI_REPLAY", str(simulated_replay))
    few, many = growth.grow([6, 16], pictures=True)
    assert few.pictures and few.phases["render"] > 0.001, "400,000 particles per rank"
    assert many.phases["render"] < 2 * few.phases["render"], "one rank alone would take 3.5 times as long"


def test_slow_ranks_draw_fewer_tiles(simulated_replay: Path, tmp_path: Path, monkeypatch):
    monkeypatch.setenv("MOTES_SMPI_REPLAY", str(simulated_replay))
    scene = tmp_path / "snow.motes"
    sizes = ["--systems=1", "--particles=4000", "--frames=10", "--space=-8,8", "--width=16"]
    record(scene, growth.FOLDER / "paper" / "snow.py", [*sizes, "--size=960x540", "--distance=8"])
    cluster = Cluster([Node("fast", count=2), Node("slow", speed=0.5, count=2)], growth.network())
    options = ["--roles", "shared", "--path", "tiles", "--balancer", "PrefixCuts", "--spans"]
    run = simulate(scene, cluster, log=tmp_path / "log", scale=400, options=options)
    drawn = run.spans[run.spans["phase"] == "draw"]
    took = (drawn["end_s"] - drawn["start_s"]).groupby([drawn["frame"], drawn["rank"]]).sum().unstack()
    # At first, tiles are dealt out as if ranks were equal; slow ranks then take twice as long.
    assert took.loc[7:].max(axis=1).max() < 1.35 * took.loc[7:].min(axis=1).min()


def test_who_also_draws_gets_less_to_calculate(simulated_replay: Path, tmp_path: Path, monkeypatch):
    monkeypatch.setenv("MOTES_SMPI_REPLAY", str(simulated_replay))
    scene = tmp_path / "snow.motes"
    sizes = ["--systems=1", "--particles=3000", "--frames=14", "--space=-8,8", "--width=16"]
    record(scene, growth.FOLDER / "paper" / "snow.py", [*sizes, "--size=160x90", "--distance=8"])
    costs = tmp_path / "costs"
    costs.write_text("action = 200\nbirth = 300\nrecord = 50\ncollect = 10\ndraw = 60\n")
    cluster = Cluster([Node("n", count=4)], growth.network())
    runs = []
    for policy in ("Static", "PrefixCuts(threshold=0.03,min_particles=8)"):
        options = ["--roles", "all", "--path", "gather", "--births", "manager", "--balancer", policy]
        log = tmp_path / policy[:6]
        runs.append(simulate(scene, cluster, log=log, scale=400, costs=costs, options=options))
    even, fair = (run.by_rank("n_end").loc[11:].mean() for run in runs)
    assert even[0] == pytest.approx(even.mean(), rel=0.1)
    assert fair[0] < 0.85 * fair[2:].mean(), "rank 0 draws"
    slow, quick = (run.frames["t_frame_s"].loc[8:].mean() for run in runs)
    assert quick < 0.9 * slow
    waits = runs[1].waits()
    answers = waits["seconds"][waits["phase"] == "proposals"]
    assert len(answers) and answers.max() < 0.02, "the picture takes 0.08 s, and nobody waits for it"


OWN = """
import motes

class Mine(motes.balance.PrefixCuts):
    seen = 0

    def decide(self, load):
        self.seen += 1
        assert load.frame < 3 and self.seen == load.evaluation + 1, f"no frame {load.frame}"
        return super().decide(load)
"""


def test_a_balancer_of_one_s_own_decides_on_the_virtual_cluster(
    simulated_replay: Path, tmp_path: Path, monkeypatch, capsys
):
    monkeypatch.setenv("MOTES_SMPI_REPLAY", str(simulated_replay))
    (tmp_path / "mine.py").write_text(OWN)
    scene, mine = tmp_path / "snow.motes", player(f"{tmp_path}/mine.py:Mine")
    record(scene, SNOW, [*SMALL, "--systems", "1", "--frames", "3", "--out", tmp_path])
    cluster = Cluster([Node("fast", count=3), Node("slow", 0.25, count=2)], FastEthernet())
    logs = []
    for balancer in (mine, mine, PrefixCuts(), Static()):
        options = ["--roles", "all"]
        log = tmp_path / f"log-{len(logs)}"
        run = simulate(scene, cluster, log=log, balancer=balancer, scale=1000, options=options)
        logs.append(run.load[["n_end", "sent", "domain_hi"]].fillna(0).to_numpy().tolist())
    assert logs[0] == logs[1] == logs[2] != logs[3], "as the same policy in the core, also the second time"
    five = tmp_path / "cluster.py"
    five.write_text("from motes.cluster import *\ncluster = Cluster([Node('n', count=5)])\n")
    record(scene, SNOW, [*SMALL, "--systems", "1", "--out", tmp_path])
    assert main(["cluster", "run", "--balancer", f"{tmp_path}/mine.py:Mine", str(five), str(scene)]) == 2
    said = capsys.readouterr().err
    assert "AssertionError: no frame 3 in the balancer Mine" in said and said.count("\n") == 1


def test_a_virtual_run_is_an_ordinary_run_and_repeats_to_the_byte(simulated_replay: Path, tmp_path: Path):
    (tmp_path / "cluster.py").write_text(
        "from motes.cluster import *\n"
        "cluster = Cluster([Node('fast', cores=2, count=2), Node('slow', 0.5, count=2)], FastEthernet())\n"
    )
    (tmp_path / "costs").write_text("action = 100\nbirth = 300\nrecord = 50\ncollect = 50\ndraw = 80\n")
    env = {"MOTES_SMPI_REPLAY": str(simulated_replay)}
    argv = [sys.executable, "-m", "motes", "cluster", "run", "--json", "--costs", tmp_path / "costs"]
    argv += ["--scale", "100", "--log"]
    script = [tmp_path / "cluster.py", SNOW, *SMALL, "--digest", "--out", tmp_path]
    logs = [tmp_path / "log-a", tmp_path / "log-b"]
    for log in logs:
        made = command([str(word) for word in [*argv, log, *script]], env=env)
        facts = json.loads(made.lines[-1])
        assert (facts["ranks"], facts["hosts"], facts["frames"]) == (6, 4, 4)
    names = sorted(path.name for path in logs[0].iterdir())
    assert "run.json" in names and "frames.jsonl" in names
    for name in names:
        assert (logs[0] / name).read_bytes() == (logs[1] / name).read_bytes(), name
    rows = [json.loads(line) for line in (logs[0] / "load.jsonl").read_text().splitlines()]
    # Particles are really computed, but time comes from the model: 11 actions per particle.
    sums = Counter[int]()
    for row in rows:
        sums[row["frame"]] += row["n_end"]
        if row["n_start"] + row["created"] > 0 and row["frame"] == 1:
            nanoseconds = row["t_compute_s"] * 1e9 / (row["n_start"] + row["created"])
            slower = 1 if row["host"].startswith("fast") else 2
            assert nanoseconds == pytest.approx(110_000 * slower, rel=0.01)
    assert sums[3] > 1000


# --- compiling, finding the program, the cost of work


def test_no_command_but_build_compiles_anything(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Other commands do not run CMake, even if the current folder is a source tree."""
    (tmp_path / "cpp" / "driver").mkdir(parents=True)
    (tmp_path / "cpp" / "driver" / "CMakeLists.txt").write_text("message(FATAL_ERROR here)")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("MOTES_SMPI_REPLAY", raising=False)
    monkeypatch.setattr(build_module, "_default_program", lambda: tmp_path / "bin" / "motes_replay_smpi")
    with pytest.raises(MotesError, match=r"python -m motes cluster build --source DIR.*MOTES_SMPI_REPLAY"):
        build_module.find_replay()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cpp"]
    monkeypatch.setenv("MOTES_SMPI_REPLAY", "no/such/program")
    with pytest.raises(MotesError, match="MOTES_SMPI_REPLAY=no/such/program does not exist"):
        build_module.find_replay()


def test_build_compiles_a_clone_and_puts_the_program_where_it_is_found(tmp_path: Path, monkeypatch, capsys):
    clone, tools = tmp_path / "clone", tmp_path / "tools"
    (clone / "cpp" / "driver").mkdir(parents=True)
    (clone / "cpp" / "driver" / "CMakeLists.txt").touch()
    tools.mkdir()
    for name, text in {
        "smpirun": "exit 0",
        # Configuring writes the cache, building writes the program; both record their arguments.
        "cmake": f'echo "$@" >> {tmp_path}/asked; mkdir -p {clone}/build/smpi/cpp/driver; '
        f"touch {clone}/build/smpi/CMakeCache.txt; echo built > {clone}/build/smpi/cpp/driver/motes_replay",
    }.items():
        (tools / name).write_text(f"#!/bin/sh\n{text}\n")
        (tools / name).chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(tools / "python"))
    monkeypatch.setenv("PATH", f"{tools}:/usr/bin:/bin")
    monkeypatch.delenv("MOTES_SMPI_REPLAY", raising=False)
    monkeypatch.delenv("MOTES_SMPIRUN", raising=False)
    for _ in range(2):
        assert main(["cluster", "build", "--source", str(clone)]) == 0
        assert capsys.readouterr().out.strip() == str(tools / "motes_replay_smpi")
    assert build_module.find_replay().read_text() == "built\n"
    asked = (tmp_path / "asked").read_text().splitlines()
    assert [line.startswith("-S") for line in asked] == [True, False, False], "configured once, built twice"
    assert "-DMOTES_MPI=smpi" in asked[0]
    assert main(["cluster", "build", "--source", str(tmp_path)]) == 2
    assert "is not a clone of motes" in capsys.readouterr().err


def test_work_is_not_free_where_no_costs_are_given(simulated_replay: Path, tmp_path: Path):
    (tmp_path / "cluster.py").write_text(
        "from motes.cluster import *\n"
        "cluster = Cluster([Node('a'), Node('b'), Node('fast'), Node('slow', 0.25)])\n"
    )
    env = {"MOTES_SMPI_REPLAY": str(simulated_replay)}
    start = [sys.executable, "-m", "motes", "cluster", "run"]
    script = [tmp_path / "cluster.py", SNOW, *SMALL, "--out", tmp_path]
    facts = json.loads(command([str(w) for w in [*start, "--json", *script]], env=env).lines[-1])
    assert facts["costs"] == "measured on one core of a Xeon"
    assert facts["imbalance"] == pytest.approx(2 * 4 / 5, rel=0.1), "one of two has a quarter of the speed"
    (tmp_path / "free").write_text("# nothing costs anything\n")
    said = command([str(w) for w in [*start, "--costs", tmp_path / "free", *script]], env=env).lines[-1]
    assert f"costs of work: {tmp_path / 'free'}" in said
    assert "imbalance 1.00" in said


# --- the paper's tables, from end to end


def test_cells_of_the_paper_are_run(simulated_replay: Path, monkeypatch: pytest.MonkeyPatch, capsys):
    monkeypatch.setenv("MOTES_SMPI_REPLAY", str(simulated_replay))
    few = [cell for cell in cells(1) if cell.processes == 4 and cell.variant in ("IS-SLB", "FS-DLB")]
    monkeypatch.setattr(experiment, "cells", lambda _: few)
    size = {**model.model()["scale"], "particles": 200, "frames": 6, "measured": 2}
    monkeypatch.setitem(model.model(), "scale", size)
    assert main(["cluster", "paper", "--table", "1", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert [(row["nodes"], row["variant"]) for row in facts["rows"]] == [
        ("4*B /4 P.", "IS-SLB"),
        ("4*B /4 P.", "FS-DLB"),
    ]
    for row in facts["rows"]:
        assert 0.5 < row["ours"] < 2, "two calculators"
        assert row["best"] > 0
        assert row["error"] == pytest.approx(row["ours"] / row["paper"] - 1)


@pytest.mark.parametrize(
    ("argv", "module"),
    [
        ("growth --ranks 4", "pandas"),
        ("growth --ranks 4 --plot x.png", "matplotlib.figure"),
        ("paper --table 1", "pandas"),
        ("paper --table 1 --plot x.png", "matplotlib.figure"),
        ("paper --text", "pandas"),
        ("run cluster.py scene.motes", "pandas"),
    ],
)
def test_what_is_not_installed_is_named_before_minutes_of_work(argv: str, module: str, monkeypatch, capsys):
    for maker in (growth, experiment):
        monkeypatch.setattr(maker, "find_smpirun", lambda: "smpirun")
        monkeypatch.setattr(maker, "find_replay", lambda: Path("motes_replay"))
        monkeypatch.setattr(maker, "record", lambda *_: pytest.fail("recorded"))
    monkeypatch.setitem(sys.modules, module, None)
    assert main(["cluster", *argv.split()]) == 2
    assert f"needs {module.partition('.')[0]}, which" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("table", [1, 2, 3])
def test_a_whole_table_of_the_paper(simulated_replay: Path, tmp_path: Path, table: int):
    env = {"MOTES_SMPI_REPLAY": str(simulated_replay)}
    argv = ["cluster", "paper", "--table", str(table), "--json", "--plot", str(tmp_path / "table.png")]
    made = command([sys.executable, "-m", "motes", *argv], env=env, timeout=1700)
    facts = json.loads(made.lines[-1])
    assert len(facts["rows"]) == len(cells(table))
    assert facts["near"] >= 0.75 * len(facts["rows"]), "see docs/lab/paper.md"
    assert (tmp_path / "table.png").stat().st_size > 10_000


@pytest.mark.slow
@pytest.mark.parametrize(("table", "experiment_name"), [(1, "snow"), (3, "fountain")])
def test_all_processes_calculating_come_close_to_the_bound(
    simulated_replay: Path, monkeypatch, table: int, experiment_name: str
):
    monkeypatch.setenv("MOTES_SMPI_REPLAY", str(simulated_replay))
    (cell,) = (one for one in cells(table) if (one.nodes, one.variant) == ("8*B /16 P.", "FS-DLB"))
    (row,) = experiment.measure([cell])
    assert cell.experiment == experiment_name and 13.0 < row.best < 13.9, "see docs/lab/paper.md"


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_the_papers_text(simulated_replay: Path):
    env = {"MOTES_SMPI_REPLAY": str(simulated_replay)}
    argv = ["cluster", "paper", "--text", "--json"]
    facts = json.loads(command([sys.executable, "-m", "motes", *argv], env=env, timeout=1700).lines[-1])
    snow = [row for row in facts["speedups"] if row["experiment"] == "snow"]
    assert len(snow) == 4
    assert all(abs(row["ours"] / row["paper"] - 1) < 0.2 for row in snow), "see docs/lab/paper.md"
    assert facts["eight_slow_nodes"]["ours"] == 7 and facts["eight_slow_nodes"]["ours_two_each"] == 4
    assert all(abs(row["ours"] - row["paper"]) < 6 for row in facts["saved_percent"])
