"""`Run.explain` names what is wrong first, in runs whose ailment is known.

Each is a log made frame by frame from what its ranks hold and do. The times follow from that: all ranks wait
for the last one, and the waits name it.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from handmade import load_row, rows, time_row, write_log

import motes

pandas = pytest.importorskip("pandas")

FRAMES = 24
PARTICLE_S = 1e-6  # on a rank of speed 1


@dataclass
class Ailing:
    """A run: functions of a frame and a rank. Rank 0 draws, rank 1 manages, the others calculate."""

    held: Callable[[int, int], float] = lambda frame, rank: 40_000
    spent: Callable[[int, int], dict[str, float]] = lambda frame, rank: {}
    speeds: dict[int, float] = field(default_factory=dict)
    flight_s: float = 1e-4
    facts: dict[str, Any] = field(default_factory=dict)
    ranks: Callable[[int], range] = lambda frame: range(5)
    balance: Callable[[int], list[dict[str, Any]]] = lambda frame: []
    events: list[dict[str, Any]] = field(default_factory=list)

    def calculators(self, frame: int) -> list[int]:
        """Return the ranks that calculate."""
        ranks = self.ranks(frame)
        return [rank for rank in ranks if rank > 1] or [0]


def write(ailing: Ailing, folder: Path) -> motes.analysis.Run:
    """Write a run's log and open it."""
    load, times, waits, seconds, balance, chain = [], [], [], [], [], 0.0
    for frame in range(FRAMES):
        did: dict[int, dict[str, float]] = {}
        for rank in ailing.ranks(frame):
            did[rank] = {"script": 1e-4, "talk": 1e-4, **ailing.spent(frame, rank)}
            if rank in ailing.calculators(frame):
                n = round(ailing.held(frame, rank))
                did[rank]["act"] = n * PARTICLE_S / ailing.speeds.get(rank, 1.0)
                took = {"t_compute_s": did[rank]["act"], "speed": n / did[rank]["act"] if n else 0.0}
                load.append(load_row(frame, "s", rank, n_start=n, n_end=n, **took))
        work = {rank: sum(own.values()) - own.get("script_idle", 0.0) for rank, own in did.items()}
        last = max(work, key=lambda rank: work[rank])
        flight = ailing.flight_s if len(did) > 1 else 0.0
        chain += work[last] - did[last].get("recovery", 0.0)
        seconds.append(work[last] + flight)
        for rank, own in did.items():
            waited = work[last] - work[rank]
            times.append(time_row(frame, rank, chain_s=chain, **own, wait=waited + flight))
            if waited > 0:
                row = {"frame": frame, "rank": rank, "waited_for": last, "sender": 1 if rank != 1 else last}
                waits.append({**row, "phase": "verdict", "seconds": waited})
        balance += [{"frame": frame, "system": "s", "axis": "x", **row} for row in ailing.balance(frame)]
    facts: dict[str, Any] = {"calculators": ailing.calculators(0), "cores": 64}
    facts["ranks"] = [{"rank": rank, "host": "h"} for rank in ailing.ranks(0)]
    if len(facts["ranks"]) == 1:
        facts["manager"] = 0
    log = write_log(folder, load, facts={**facts, **ailing.facts})
    frames = [json.loads(line) for line in (log / "frames.jsonl").read_text().splitlines()]
    rows(log / "frames.jsonl", [{**row, "t_frame_s": seconds[row["frame"]]} for row in frames])
    rows(log / "times.jsonl", times, pad=512)
    rows(log / "waits.jsonl", waits)
    rows(log / "events.jsonl", ailing.events, mode="a")
    if balance:
        rows(log / "balance.jsonl", balance, pad=512)
    return motes.open_run(log)


def only(rank: int, **spent: float) -> Callable[[int, int], dict[str, float]]:
    """Let one rank do something in each frame."""
    return lambda frame, at: spent if at == rank else {}


def all_ranks(**spent: float) -> Callable[[int, int], dict[str, float]]:
    """Let all ranks do something in each frame."""
    return lambda frame, rank: spent


def full(frame: int, rank: int) -> float:
    """Return what ranks hold if rank 4 always holds too much."""
    return {2: 20_000, 3: 20_000, 4: 80_000}.get(rank, 0)


def wandering(frame: int, rank: int) -> float:
    """Return what ranks hold if a cloud wanders over all of them, eight frames each."""
    return 80_000 if rank == 2 + frame // 8 % 3 else 20_000


def swinging(frame: int, rank: int) -> float:
    """Return what ranks hold if 60 000 particles are moved to and fro between ranks 2 and 3."""
    return {2: 80_000 - 60_000 * (frame % 2), 3: 20_000 + 60_000 * (frame % 2)}.get(rank, 50_000)


def to_and_fro(frame: int) -> list[dict[str, Any]]:
    """Return the cut that moves them."""
    sign = 1 if frame % 2 == 0 else -1
    sides = {"left_rank": 2, "right_rank": 3, "n_left": swinging(frame, 2), "n_right": swinging(frame, 3)}
    cut = {"cut_before": 0.5 * sign, "cut_after": -0.5 * sign, "policy": "Mine()"}
    return [{**sides, "ordered": 60_000 * sign, "given": 60_000 * sign, **cut}]


def to_and_fro_by_shares(frame: int) -> list[dict[str, Any]]:
    """Return the same cut from a balancer that replaces all cuts and counts nothing."""
    return [{**row, "ordered": None, "given": None} for row in to_and_fro(frame)]


def following(frame: int) -> list[dict[str, Any]]:
    """Return a cut that a balancer moves in one direction, behind a cloud that wanders."""
    sides = {"left_rank": 2, "right_rank": 3, "n_left": 80_000, "n_right": 20_000}
    cut = {"cut_before": 0.1 * frame, "cut_after": 0.1 * frame + 0.1, "policy": "Pairwise()"}
    return [{**sides, "ordered": -4000, "given": -4000, **cut}]


def fewer(frame: int) -> range:
    """Let a run go on with two ranks fewer."""
    return range(5 if frame < 12 else 3)


PART = {"frame": 12, "calculators": [2], "ranks": [{"rank": rank, "host": "h"} for rank in range(3)]}
LATER = {"continued": [PART]}
SLOW = {
    "frame": 9,
    "kind": "slow_balancer",
    "text": "balancer Mine(): its decide takes 30 ms of a frame's 70 ms",
}

AILMENTS: dict[str, tuple[Ailing, str, str, str]] = {
    # name: (run, cause, how the first sentence begins, what else it says)
    "well balanced": (Ailing(), "", "Nothing stands out", ""),
    "one rank": (Ailing(ranks=lambda frame: range(1)), "", "Nothing stands out", ""),
    "imbalance": (
        Ailing(held=full), "imbalance", "Imbalance: rank 4 holds 2 times", "--balancer pairwise"),
    "imbalance in spite of a balancer": (
        Ailing(held=full, facts={"balancer": "Diffusive()"}), "imbalance", "Imbalance: rank 4",
        "try a balancer other than Diffusive()"),
    "moving imbalance": (
        Ailing(held=wandering), "moving imbalance",
        "Moving imbalance: the fullest rank holds 2 times", "try a balancer (--balancer"),
    "a balancer lags behind": (
        Ailing(held=wandering, balance=following, facts={"balancer": "Pairwise()"}), "moving imbalance",
        "Moving imbalance: the fullest rank holds 2 times", "balance more often, or predict"),
    "thrashing": (
        Ailing(held=swinging, balance=to_and_fro, facts={"balancer": "Mine()"}), "thrashing",
        "Thrashing: Mine() moves particles back and forth (22 of 23 moves between ranks 2 and 3",
        "act less often"),
    "thrashing by shares": (
        Ailing(held=swinging, balance=to_and_fro_by_shares, facts={"balancer": "Mine()"}), "thrashing",
        "Thrashing: Mine() moves particles back and forth", "act less often"),
    "slow rank": (
        Ailing(speeds={3: 0.25}), "slow rank", "Slow rank 3: it takes 4 times", "leave this machine out"),
    "a calculator sleeps": (
        Ailing(spent=only(3, other=0.2)), "slow rank", "Slow rank 3", "slept, or other processes"),
    "preempted script": (
        Ailing(spent=all_ranks(script=0.09, script_idle=0.08), facts={"cores": 2}), "system",
        "System: 5 ranks share 2 cores", "80 ms in the script"),
    "sleeping script": (
        Ailing(spent=all_ranks(script=0.09, script_idle=0.08)), "script",
        "Script: on every rank it is without", "waits for files"),
    "script": (
        Ailing(spent=all_ranks(script=0.09)), "script", "Script: its own Python takes 90 ms", "use arrays"),
    "script of one rank": (
        Ailing(spent=only(3, script=0.09)), "rank", "Rank 3: others wait", "its script takes 90 ms"),
    "one rank sleeps": (
        Ailing(spent=only(3, script=0.09, script_idle=0.085)), "rank", "Rank 3: others wait", "it sleeps"),
    "checkpoints": (
        Ailing(spent=lambda frame, rank: {"checkpoint": 0.6} if frame % 6 == 5 else {}), "checkpoint",
        "Checkpoints: writing them takes 104 ms", "in 4 frames: write them less often"),
    "image generator": (
        Ailing(spent=only(0, picture=0.2)), "image generator", "Image generator (rank 0): others wait",
        "let all ranks draw"),
    "picture": (
        Ailing(spent=all_ranks(picture=0.2)), "picture", "Picture: drawing takes 200 ms", "on every rank"),
    "manager": (
        Ailing(spent=only(1, births=0.2)), "manager", "Manager (rank 1): others wait",
        'births="calculators"'),
    "slow balancer": (
        Ailing(spent=only(1, talk=0.07), events=[SLOW]), "manager", "Manager (rank 1): others wait",
        "its decide takes 30 ms"),
    "log": (Ailing(spent=only(1, log=0.2)), "manager", "Manager (rank 1)", "log to a local disk"),
    "network": (Ailing(flight_s=0.1), "network", "Network: messages in flight cost 100 ms", "faster network"),
    "small frames": (
        Ailing(held=lambda frame, rank: 100, flight_s=1e-3), "small frames",
        "Small frames: messages in flight cost 1 ms", "fewer ranks or more particles"),
    "continued on fewer ranks": (Ailing(ranks=fewer, facts=LATER), "", "Nothing stands out", ""),
    "imbalance before it continued": (
        Ailing(held=lambda f, r: full(f, r) if f < 12 else 40_000, ranks=fewer, facts=LATER), "imbalance",
        "Imbalance: rank 4 holds 2 times", "(frames 0 to 11)."),
    "recovered": (
        Ailing(ranks=fewer, facts=LATER, spent=lambda f, r: {"recovery": 0.5} if f == 12 else {}), "recovery",
        "Recovery: a loss of ranks cost 500 ms", "(frames 12 to 23)."),
}  # fmt: skip


@pytest.mark.parametrize("ailment", AILMENTS)
def test_the_first_sentence_names_the_ailment(ailment, tmp_path):
    ailing, cause, begins, says = AILMENTS[ailment]
    told = write(ailing, tmp_path / "log").explain()
    assert told.sentences[0].startswith(begins), str(told)
    assert says in told.sentences[0], told.sentences[0]
    assert [loss.cause for loss in told.losses[:1]] == [cause][: len(cause)], str(told)
    assert all(loss.seconds <= told.frame_s * (1 + 1e-9) for loss in told.losses)


def test_a_balancer_that_is_right_does_not_thrash(tmp_path):
    run = write(Ailing(held=full, balance=following), tmp_path / "log")
    assert [loss.cause for loss in run.explain().losses] == ["imbalance"]


def test_a_rank_is_late_only_for_as_long_as_others_waited_for_it(tmp_path):
    both = lambda frame, rank: {0: {"picture": 0.2}, 1: {"births": 0.15}}.get(rank, {})  # noqa: E731
    told = write(Ailing(spent=both), tmp_path / "log").explain()
    assert [loss.cause for loss in told.losses][0] == "image generator"
    assert "manager" not in {loss.cause for loss in told.losses}, "nobody waits for it, but for rank 0"
