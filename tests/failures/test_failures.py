"""A rank fails inside a run: one message, and every rank ends by itself. Real jobs on four ranks.

MOTES_STALL_S exceeds a job's time limit: a job that ends in time ended because a rank noticed the failure.
"""

from __future__ import annotations

import os
import re
import signal
import time
from dataclasses import dataclass
from pathlib import Path

import pytest
from launching import Result, mpirun, said
from standing import on_ranks

RANKS = 4
FAULTY = Path(__file__).parents[1] / "scenes" / "faulty.py"
ROLES = ("image generator", "manager", "calculator 0", "calculator 1")
FRAME = 3
LIMIT_S = 60
PATIENT = {"MOTES_STALL_S": "600"}
END_S = 3.0
"""Limit from a fault to the end of the job, in seconds. Checked only with --slow, when the cores are idle."""


@dataclass(frozen=True)
class Kind:
    """How a rank fails, and what the report must contain."""

    name: str
    message: str
    code: int | None = 1
    """None: any nonzero code."""
    trace: str = ""
    """Text in the failing rank's own traceback; empty if it prints none."""


KINDS = (
    Kind("raise", "ValueError: the mistake", trace="raise ValueError"),
    Kind("exit 0", r"called sys\.exit\(0\) in the middle of the run", trace="SystemExit"),
    Kind("exit 3", r"called sys\.exit\(3\) in the middle of the run", code=3, trace="SystemExit"),
    Kind("break", "", code=None),
    Kind("segfault", "segmentation fault", code=None, trace="ctypes/__init__.py"),
    Kind("kill", r"its process is gone \(killed or crashed\)", code=None),
    Kind("another action", r"its script differs from the other ranks'.*gravity"),
    Kind("another parameter", r"its script differs from the other ranks'.*gravity with different arguments"),
    Kind("another call", r"its script differs from the other ranks'.*digest"),
    Kind(
        "another last bit",
        r"its script differs.*emit with different arguments: 4 of \d+ numbers differ, as [\d.]+ here and "
        r"[\d.]+ there: only in their last bits.*motes\.expressions.*"
        r"rank \d runs on \S+ \(\w+, NumPy \d.*\), rank \d runs on",
    ),
)


def reports(result: Result) -> list[str]:
    """Return the first lines of all reports."""
    return said(result.err, "*** motes: ")


def faulty(
    kind: str, rank: int, *, env: dict[str, str] | None = None, ranks: int = RANKS
) -> tuple[Result, float]:
    """Run the faulty scene; return its result and the seconds from the fault to the end."""
    agreed = rank == -1 or kind == "bad log" or kind.startswith("another")
    start = on_ranks if agreed else mpirun  # if one rank fails, the others still wait for it
    result = start(ranks, FAULTY, kind, rank, timeout=LIMIT_S, env={**PATIENT, **(env or {})})
    ended = time.time()
    failing = re.search(r"failing at ([\d.]+)", result.out + result.err)
    assert failing is not None, result.text
    return result, ended - float(failing[1])


def assert_told(kind: Kind, rank: int, env: dict[str, str] | None = None) -> float:
    """Check that the job ends with one message naming rank, role and frame; return the seconds it took."""
    result, seconds = faulty(kind.name, rank, env=env)
    told = reports(result)
    assert len(told) == 1, result.text
    assert f"rank {rank} ({ROLES[rank]}), frame {FRAME}" in told[0], result.text
    assert re.search(kind.message, told[0]), result.text
    assert result.code != 0 if kind.code is None else result.code == kind.code, result.text
    if kind.trace:
        assert kind.trace in result.err, result.text
    if kind.trace and kind.name != "segfault":  # Python and the core both report a crash
        assert result.err.count("Traceback (most recent call last)") == 1, result.text
    return seconds


# Each kind of fault on one rank, and each rank with at least one kind; the slow suite runs all pairs.
FAULTS = [
    pytest.param(
        *(kind, rank),
        id=f"{kind.name}-{rank}",
        marks=[] if rank == number % RANKS else [pytest.mark.slow],
    )
    for number, kind in enumerate(KINDS)
    for rank in range(RANKS)
]


@pytest.mark.parametrize(("kind", "rank"), FAULTS)
def test_a_fault_on_one_rank(kind: Kind, rank: int):
    assert_told(kind, rank)


@pytest.mark.parametrize("rank", [0, 2])  # messages go from the manager, rank 1, to 2, then 3, then 0
@pytest.mark.parametrize("kind", ["raise", "kill", "another action", "another call"])
def test_a_fault_where_ranks_relay_messages(kind: str, rank: int):
    (found,) = (each for each in KINDS if each.name == kind)
    assert_told(found, rank, env={"MOTES_FAN_OUT": "1", "MOTES_BIRTHS": "calculators"})


@pytest.mark.slow
@pytest.mark.parametrize("rank", range(RANKS))
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_a_fault_five_times(kind: Kind, rank: int):
    for _ in range(5):
        assert assert_told(kind, rank) < END_S


def test_the_scene_without_a_fault():
    result = on_ranks(RANKS, FAULTY, "none", 0)
    assert result.lines[-1] == "done", result.text
    assert reports(result) == []


@pytest.mark.parametrize("kind", ["raise", "exit 3", "break"])
def test_all_ranks_make_the_same_mistake(kind: str):
    result, _ = faulty(kind, -1)
    if kind == "break":  # all ranks leave the loop together, which is no fault
        assert result.code == 0, result.text
        assert reports(result) == []
        return
    assert len(reports(result)) == 1, result.text
    assert result.err.count("Traceback (most recent call last)") == 1, result.text
    assert result.code == (3 if kind == "exit 3" else 1), result.text


@pytest.mark.parametrize("kind", ["raise", "kill", "break", "another action"])
def test_a_fault_of_a_rank_with_all_roles(kind: str):
    result, _ = faulty(kind, 0, ranks=3, env={"MOTES_TEST_ROLES": "shared"})
    told = reports(result)
    assert len(told) == 1, result.text
    assert f"rank 0 (image generator, manager, calculator 0), frame {FRAME}" in told[0], result.text
    assert result.code != 0


def test_a_calculator_runs_out_of_memory():
    result, _ = faulty("no memory", 3)
    told = reports(result)
    assert len(told) == 1, result.text
    assert f"rank 3 (calculator 1), frame {FRAME}" in told[0], result.text
    assert "MemoryError" in result.err, result.text
    caught = "caught RankError on rank 2: rank 3 (calculator 1), frame 3, source at faulty.py:"
    assert caught in result.out, result.text


def test_a_log_that_cannot_be_written():
    result, _ = faulty("bad log", 1)
    told = reports(result)
    assert len(told) == 1, result.text
    assert "rank 1 (manager), frame 0" in told[0], result.text
    assert "/dev/null/log" in told[0], result.text
    assert result.code == 1


@pytest.mark.parametrize(
    ("rank", "fan_out"),
    [
        (1, 8),
        pytest.param(2, 1, marks=pytest.mark.slow),
        pytest.param(3, 8, marks=pytest.mark.slow),
        pytest.param(1, 1, marks=pytest.mark.slow),
    ],
)
def test_a_stalled_rank_is_named(rank: int, fan_out: int, tmp_path: Path):
    stopped: list[int] = []

    def stop(launcher: int) -> None:
        # The rank writes its process id to a file when it may be stopped.
        if not stopped and mark.exists() and (text := mark.read_text()).endswith("\n"):
            stopped.append(int(text))
            os.kill(stopped[0], signal.SIGSTOP)

    mark = tmp_path / "may be stopped"
    result = mpirun(
        *(RANKS, FAULTY, "stall", rank, mark),
        timeout=LIMIT_S,
        env={"MOTES_STALL_S": "3", "MOTES_FAN_OUT": str(fan_out)},
        watch=stop,
    )
    told = reports(result)
    assert len(told) == 1, result.text
    # The first rank to notice names the rank it waits for, which may itself wait for the stopped one.
    assert re.search(r"rank \d \(.*\) waited \d+ s for rank \d \(.*\): frame \d+, phase \w+", told[0]), (
        result.text
    )
    if rank == 1:  # every rank waits for the manager
        assert "for rank 1 (manager)" in told[0], result.text
    assert result.code != 0


def test_an_interrupt_stops_all_ranks(tmp_path: Path):
    sent: list[int] = []

    def interrupt(launcher: int) -> None:
        if not sent and mark.exists():
            sent.append(launcher)
            os.kill(launcher, signal.SIGINT)

    mark = tmp_path / "running"
    result = mpirun(RANKS, FAULTY, "endless", 0, mark, timeout=LIMIT_S, env=PATIENT, watch=interrupt)
    assert result.code == 130, result.text
    assert reports(result) == [] and len(said(result.err, "motes: stopped by SIGINT after frame")) == 1
    assert sent
