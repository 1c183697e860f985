"""Balancing in real runs: cuts follow the load, particles follow the cuts, and no bit changes."""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest
from standing import on_ranks

POLICIES = {
    "static": "None",
    "pairwise": "balance.Pairwise(threshold=0.05, min_particles=8)",
    "diffusive": "balance.Diffusive(threshold=0.01, min_particles=8)",
    "prefix": "balance.PrefixCuts(threshold=0.02)",
    "proportional": "balance.Proportional(powers=[1 + c for c in range(n)])",
    "own": "Leftmost()",
    "orders": "Shove()",
    "all": "balance.Pairwise(threshold=0.05, min_particles=8, over='all')",
    "diffusive-all": "balance.Diffusive(threshold=0.01, min_particles=8, over='all')",
    "alone": "balance.Diffusive(threshold=0.01, min_particles=8, manager=False)",
    "alone-all": "balance.Diffusive(threshold=0.01, min_particles=8, manager=False, over='all')",
    "prefix-all": "balance.PrefixCuts(threshold=0.02, over='all')",
}

# Particles fly through the domains, die and have children; in between, the script reads and moves some.
SCENE = """
import json, sys
from mpi4py import MPI
import motes
from motes import balance, shapes

FRAMES = 10
ODD = motes.Roles(manager=0, image_generator=2, calculators=[3, 1, 2])

class Leftmost(balance.Balancer):
    def decide(self, load):
        return balance.Targets([float(len(load) - c) for c in range(len(load))])

class Shove(balance.Balancer):
    def decide(self, load):
        if len(load) < 2:
            return balance.Orders([])
        return balance.Orders([(0, 1, 10**9 if load.frame % 2 else 7), (1, 0, 3)])

def play(name, policy, space, combine, roles, log):
    n = MPI.COMM_WORLD.size if roles == "shared" else 3 if roles == "odd" else max(1, MPI.COMM_WORLD.size - 2)
    world = motes.World(
        seed=3, space=space, balancer=eval(policy, globals(), {"n": n}), combine=combine,
        roles=ODD if roles == "odd" else roles, substeps=2,
        log=log, spans=log is not None, progress="off",
        renderer=motes.Renderer(64, 48, camera=motes.Camera((0, 0, 60), (0, 0, 0))),
    )
    drops, dust = world.system("drops", capacity=3000), world.system("dust")
    rain = world.system("rain", axis="y")
    with world:
        for frame in world.frames(FRAMES):
            record(world, drops, dust, rain, frame)
            digest = world.digest()
            picture = world.render()
            world.say(f"{name} {frame} {digest} {drops.count} {rain.count} {dust.count}")
            if picture:
                print(name, "picture", frame, picture.digest(), flush=True)


def record(world, drops, dust, rain, frame):
    drops.configure(velocity=motes.Normal((2, 0, 0), (6, 3, 3)), lifetime=motes.Uniform(0.2, 2))
    drops.source(shapes.Box((-1, -1, -1), (1, 1, 1)), rate=6000)
    drops.gravity((0, -9.81, 0))
    drops.bounce(shapes.Plane((0, -2, 0), (0, 1, 0)), restitution=0.5)
    drops.spawn(into=dust, on="collision", count=1, inherit_velocity=0.3)
    drops.kill_expired()
    drops.move()
    rain.configure(velocity=(0, -20, 0))
    rain.source(shapes.Line((-9, 30, 0), (9, 30, 0)), rate=2000)
    rain.random_displacement(shapes.Sphere((0, 0, 0), 0.1))
    rain.move()
    rain.kill_old(1.5)
    dust.random_velocity(shapes.Sphere((0, 0, 0), 1))
    dust.move()
    dust.kill_old(0.5)
    if frame == 5:
        with drops.local() as p:
            p.position[:, 0] *= 3


for variant in json.loads(sys.argv[1]):
    play(**variant)
"""

FINITE, INFINITE = (-3, 3), None


def rows_of(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


def variant(
    policy: str,
    *,
    space: tuple[int, int] | None = FINITE,
    combine: str = "together",
    roles: str = "auto",
    logs: Path | None = None,
) -> dict[str, Any]:
    """Describe a run of the scene: its name, its settings and, if `logs` is given, its log folder."""
    name = f"{policy}-{combine}"
    log = None if logs is None else str(logs / name)
    known = {"space": space, "combine": combine, "roles": roles, "log": log}
    return {"name": name, "policy": POLICIES[policy], **known}


def play(ranks: int, *variants: dict[str, Any]) -> dict[str, list[str]]:
    """Run variants of the scene one after another in one job; return each one's lines, sorted."""
    said: dict[str, list[str]] = {one["name"]: [] for one in variants}
    assert len(said) == len(variants)
    for line in on_ranks(ranks, SCENE, json.dumps(variants), timeout=110).lines:
        name, _, what = line.partition(" ")
        said[name].append(what)
    return {name: sorted(lines) for name, lines in said.items()}


@pytest.fixture(scope="module")
def alone():
    """Return what one rank prints, the reference for all other runs."""
    (said,) = play(1, variant("static")).values()
    assert len(said) == 20
    return said


@pytest.mark.parametrize(
    "ranks", [4, pytest.param(5, marks=pytest.mark.slow), pytest.param(2, marks=pytest.mark.slow)]
)
def test_no_policy_changes_a_bit(ranks, alone, tmp_path):
    unbounded = ("pairwise", "prefix", "diffusive-all", "alone-all")
    variants = [
        variant(policy, space=INFINITE if policy in unbounded else FINITE, logs=tmp_path)
        for policy in POLICIES
    ]
    for (name, said), policy in zip(play(ranks, *variants).items(), POLICIES, strict=True):
        assert said == alone, policy
        rows = rows_of(tmp_path / name / "load.jsonl")
        cuts = {(row["system"], row["rank"], row["domain_hi"]) for row in rows}
        if ranks > 3 and policy != "static":
            assert len(cuts) > 3 * (ranks - 2), f"{policy} moves its cuts"


@pytest.mark.parametrize(
    "ranks", [5, pytest.param(1, marks=pytest.mark.slow), pytest.param(3, marks=pytest.mark.slow)]
)
def test_systems_combined_otherwise_give_the_same_bits(ranks, alone):
    policies, ways = (
        ("static", "pairwise", "diffusive", "alone", "alone-all", "prefix", "all"),
        ("one_by_one", "overlapped"),
    )
    found = play(ranks, *(variant(policy, combine=way) for policy in policies for way in ways))
    assert found == dict.fromkeys(found, alone)


def test_ranks_of_several_roles_give_the_same_bits(alone, tmp_path):
    policies, ways = (
        ("pairwise", "diffusive", "alone", "prefix", "prefix-all"),
        ("together", "overlapped"),
    )
    variants = [
        variant(policy, combine=way, roles="shared", logs=tmp_path) for policy in policies for way in ways
    ]
    found = play(3, *variants)
    assert found == dict.fromkeys(found, alone)


def test_domains_in_another_order_than_ranks_give_the_same_bits(alone, tmp_path):
    variants = [
        variant(policy, roles="odd", logs=tmp_path) for policy in ("diffusive", "alone", "proportional")
    ]
    found = play(4, *variants)
    assert found == dict.fromkeys(found, alone)
    for name in found:
        rows = rows_of(tmp_path / name / "balance.jsonl")
        assert {(row["left_rank"], row["right_rank"]) for row in rows} == {(3, 1), (1, 2)}, name
    load = [row for row in rows_of(tmp_path / name / "load.jsonl") if row["system"] == "rain"]
    last = [row["n_end"] for row in load if row["frame"] == 9]
    assert last[0] < last[1] < last[2], "powers 1, 2, 3"


# --- the paper's infinite space

MIDDLE = """
import sys
import motes
from motes import balance, shapes

world = motes.World(seed=1, space=None, balancer=eval(sys.argv[1]), log=sys.argv[2], progress="off")
snow = world.system("snow")
with world:
    for frame in world.frames(int(sys.argv[3])):
        if frame == 0:
            snow.burst(shapes.Box((-1, -1, -1), (1, 1, 1)), count=4000)
        snow.move()
        world.step()
"""


def last_counts(log: Path) -> list[int]:
    rows = rows_of(log / "load.jsonl")
    return [row["n_end"] for row in rows if row["frame"] == rows[-1]["frame"]]


def last_times(log: Path) -> list[float]:
    """Return each calculator's time for its particles at the end, by the speeds that the balancer knew.

    If no speeds were measured, or all are equal, only the counts matter.
    """
    rows = rows_of(log / "balance.jsonl")
    told = {row[f"{side}_rank"]: row[f"speed_{side}"] for row in rows for side in ("left", "right")}
    known = [speed for speed in told.values() if speed > 0] or [1.0]
    counts = last_counts(log)
    speeds = [told.get(rank, 0) or sum(known) / len(known) for rank in range(2, 2 + len(counts))]
    return [count / speed for count, speed in zip(counts, speeds, strict=True)]


@pytest.mark.parametrize(
    ("ranks", "middle"),
    [(4, [0, 1]), pytest.param(5, [1], marks=pytest.mark.slow), pytest.param(7, [2], marks=pytest.mark.slow)],
)
def test_static_cuts_of_infinite_space_leave_all_in_the_middle(ranks, middle, tmp_path):
    on_ranks(ranks, MIDDLE, "None", tmp_path / "static", 3)
    counts = last_counts(tmp_path / "static")
    assert sum(counts) == 4000
    assert [c for c, n in enumerate(counts) if n > 0] == middle
    on_ranks(ranks, MIDDLE, "balance.Pairwise(min_particles=8)", tmp_path / "pairwise", 40)
    assert sum(last_counts(tmp_path / "pairwise")) == 4000
    times = last_times(tmp_path / "pairwise")
    assert max(times) < 1.35 * min(times), times
    on_ranks(ranks, MIDDLE, "balance.PrefixCuts(threshold=0.02, min_particles=8)", tmp_path / "prefix", 6)
    times = last_times(tmp_path / "prefix")
    assert max(times) < 1.05 * min(times), times


# --- slower machines

SLOW = """
import sys
import motes
from motes import balance, shapes

world = motes.World(seed=1, space=(-1, 1), balancer=eval(sys.argv[1]), log=sys.argv[2], progress="off")
snow = world.system("snow")
with world:
    for frame in world.frames(int(sys.argv[3])):
        if frame == 0:
            snow.burst(shapes.Box((-1, -1, -1), (1, 1, 1)), count=200_000)
        snow.random_acceleration(shapes.Sphere((0, 0, 0), 1))
        snow.move()
        world.step()
"""


@pytest.mark.parametrize(
    ("policy", "frames"),
    [
        ("balance.Pairwise()", 16),
        ("balance.PrefixCuts()", 6),
        ("balance.Diffusive()", 16),
        ("balance.Diffusive(manager=False)", 16),
    ],
)
def test_work_is_shared_by_speed(policy, frames, tmp_path):
    """A rank with a tenth of the speed needs more time per particle, and gets less work.

    How much less depends on the machine's other load, so only tests without a clock check it: those of
    policies and of simulated clusters.
    """
    env = {"MOTES_SPEEDS": "2:1.0,3:0.1"}
    on_ranks(4, SLOW, policy, tmp_path / "log", frames, env=env)
    facts = json.loads((tmp_path / "log" / "run.json").read_text())
    assert facts["speeds"] == {"2": 1.0, "3": 0.1}
    assert facts["balancer"].startswith(policy.split("(")[0].removeprefix("balance."))
    assert ("manager=False" in facts["balancer"]) == ("manager=False" in policy)
    seconds, particles = defaultdict(float), defaultdict(int)
    for row in rows_of(tmp_path / "log" / "load.jsonl"):
        seconds[row["rank"]] += row["t_compute_s"]
        particles[row["rank"]] += row["n_start"] + row["created"]
    slower = seconds[3] / particles[3] / (seconds[2] / particles[2])
    assert slower > 1, "the slower machine really spends the time"
    fast, slow = last_counts(tmp_path / "log")
    assert fast > slow
    nearer = [nearer_to_told(row) for row in rows_of(tmp_path / "log" / "balance.jsonl") if row["given"]]
    assert all(nearer), "whatever was measured, what moves makes the times more alike"
    assert nearer or "Prefix" in policy


def nearer_to_told(row: dict[str, Any]) -> bool:
    """Return whether moving particles over a cut made the two times more alike, by the manager's speeds."""

    left = row["speed_left"] or row["speed_right"] or 1
    right = row["speed_right"] or left

    def apart(given: int) -> float:
        return abs((row["n_left"] - given) / left - (row["n_right"] + given) / right)

    return apart(row["given"]) < apart(0)


# --- what the log records


def expected(row: dict[str, Any], given: dict[Any, int | None]) -> int:
    """Return a calculator's particles before the exchange: those alive, and what new cuts moved."""
    last, rank = (row["frame"] - 1, row["system"]), row["rank"]
    brought = (given.get((*last, rank - 1)) or 0) - (given.get((*last, rank)) or 0)
    return int(row["n_start"] + row["created"] - row["killed"] + brought)


@pytest.mark.parametrize("policy", ["pairwise", "alone"])
def test_rows_of_balance(policy, tmp_path):
    (log,) = (tmp_path / name for name in play(5, variant(policy, logs=tmp_path)))
    rows = rows_of(log / "balance.jsonl")
    assert {"manager=False" in row["policy"] for row in rows} == {policy == "alone"}
    load = {(r["frame"], r["system"], r["rank"]): r for r in rows_of(log / "load.jsonl")}
    given = {(r["frame"], r["system"], r["left_rank"]): r["given"] for r in rows}
    moved = 0
    for row in rows:
        left, right = (load[row["frame"], row["system"], row[f"{side}_rank"]] for side in ("left", "right"))
        assert row["right_rank"] == row["left_rank"] + 1
        if policy != "alone":
            assert (row["n_left"], row["n_right"]) == (left["n_end"], right["n_end"])
        elif row["system"] != "dust":  # children are created at the frame's end
            assert (row["n_left"], row["n_right"]) == (expected(left, given), expected(right, given))
        assert row["cut_before"] == pytest.approx(left["domain_hi"])
        if not row["ordered"]:
            assert row["cut_after"] == row["cut_before"]
            continue
        assert abs(row["given"]) <= abs(row["ordered"])
        assert row["given"] * row["ordered"] >= 0
        if row["given"]:
            moved += 1
            assert (row["cut_after"] < row["cut_before"]) == (row["given"] > 0)
            after = load.get((row["frame"] + 1, row["system"], row["left_rank"]))
            if after is not None:
                assert after["domain_hi"] == pytest.approx(row["cut_after"])
    assert moved > 5


def test_the_timeline_shows_messages_under_way_while_the_next_system_computes(tmp_path):
    (log,) = (tmp_path / name for name in play(4, variant("static", combine="overlapped", logs=tmp_path)))
    files = sorted(path.name for path in log.glob("spans.*"))
    assert files == [f"spans.r{rank:04d}.jsonl" for rank in range(4)]
    rows = rows_of(log / "spans.r0002.jsonl")
    for frame in range(10):
        mine = [row for row in rows if row["frame"] == frame]
        acts = {row["system"]: row for row in mine if row["phase"] == "act"}
        messages = {row["system"]: row for row in mine if row["phase"] == "messages"}
        assert set(acts) == set(messages) == {"drops", "rain", "dust"}
        for here, following in (("drops", "dust"), ("dust", "rain")):
            assert messages[here]["start_s"] <= acts[following]["start_s"]
            assert acts[following]["end_s"] <= messages[here]["end_s"]


def test_densities_lie_inside_their_domains(tmp_path):
    (log,) = (tmp_path / name for name in play(4, variant("prefix", logs=tmp_path)))
    for row in rows_of(log / "density.jsonl"):
        quantiles = [row[f"x_q{q:02d}"] for q in range(17)]
        if row["n"] == 0:
            assert quantiles == [None] * 17
        else:
            assert quantiles == sorted(quantiles)
