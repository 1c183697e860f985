"""Failures of balancing: wrong answers, wrong settings, ranks that fail between rounds."""

from __future__ import annotations

import pytest
from launching import mpirun
from standing import on_ranks
from test_balance import MIDDLE, POLICIES

WRONG = """
import sys
import motes
from motes import balance, shapes

class Wrong(balance.Balancer):
    def decide(self, load):
        if load.frame < 2:
            return balance.Targets([1.0] * len(load))
        return eval(sys.argv[1])

world = motes.World(seed=1, space=(-1, 1), balancer=Wrong(), progress="off")
snow = world.system("snow")
try:
    with world:
        for frame in world.frames(5):
            snow.source(shapes.Box((-1, -1, -1), (1, 1, 1)), rate=2400)
            snow.move()
            try:
                world.step()
            except BaseException as error:
                sys.stderr.write(f"<{type(error).__name__}|{frame}|{error}>\\n")
                raise
finally:
    sys.stderr.flush()
"""


@pytest.mark.parametrize(
    ("answer", "kinds"),
    [
        ("None", "ArgumentError"),
        ("[1.0]", "ArgumentError"),
        ("balance.Targets([1.0])", "ArgumentError"),
        ("balance.Targets([float('nan'), 1.0])", "ArgumentError"),
        ("balance.Targets([-1.0, 1.0])", "ArgumentError"),
        ("balance.Orders([(0, 5, 3)])", "ArgumentError"),
        ("1 / 0", "ZeroDivisionError"),
    ],
)
def test_a_wrong_policy_ends_the_run_everywhere(answer, kinds):
    result = on_ranks(4, WRONG, answer, timeout=30)
    assert result.code != 0
    assert "Wrong" in result.err, result.text
    assert kinds in result.err, result.text
    assert "frame 2" in result.err, result.text


ANSWERS = """
import math
import motes
from motes import balance, shapes

class Mute:
    def __repr__(self):
        raise RuntimeError("speechless")

class Wrong(balance.Balancer):
    def decide(self, load):
        if load.frame < 2:
            return balance.Targets([1.0] * len(load))
        return self.answer(load)

def raises(load):
    raise KeyError("no such machine")

def writes(load):
    load.speed[0] = 5

T, O = balance.Targets, balance.Orders
most = 2**64 - 1
wrong = [
    lambda load: None, lambda load: Mute(), lambda load: T(Mute()), lambda load: T([1.0] * 10_000),
    lambda load: T([math.inf, 1]), lambda load: T([0, 0]), lambda load: O([(0, 1, math.nan)]),
    lambda load: O([(0, 1, Mute())]), lambda load: O([(0, 1, 2**64)]), lambda load: O(None), raises, writes,
]
right = [
    lambda load: T([1e308, 1e308]), lambda load: T([1e-320, 0]), lambda load: O([(0, 1, most), (1, 0, most)]),
    lambda load: O([(0, 1, most)]), lambda load: O([(0, 1, 5)] * 100_000), lambda load: O([]),
]
for combine in ("together", "one_by_one", "overlapped"):
    for over in ("system", "all"):
        for number, answer in enumerate(wrong + right):
            balancer = Wrong()
            balancer.answer, balancer.over = answer, over
            world = motes.World(seed=1, space=(-1, 1), balancer=balancer, combine=combine, progress="off")
            systems = [world.system("a"), world.system("b")]
            world.__enter__()
            ending, text = "no error", ""
            try:
                for frame in world.frames(4):
                    for system in systems:
                        system.source(shapes.Box((-1, -1, -1), (1, 1, 1)), rate=2400)
                        system.move()
                    world.step()
                world.__exit__(None, None, None)
            except Exception as error:
                ending = "an error"
                text = f"{type(error).__name__}: {error} {getattr(error, '__notes__', '')}"
            expected = "an error" if number < len(wrong) else "no error"
            told = ending == "no error" or ("Wrong()" in text and "frame 2" in text)
            said = "as it should" if ending == expected and told else f"{combine} {over} {number}: {text}"
            print(world.rank, said, flush=True)
"""


def test_wrong_answers_of_a_policy_reach_all_ranks_and_odd_ones_become_legal():
    """The next world in the same job works too: no rank still waits for a message of the previous one."""
    lines = on_ranks(4, ANSWERS, timeout=120).lines
    assert len(lines) == 4 * 3 * 2 * 18
    assert {line.partition(" ")[2] for line in lines} == {"as it should"}


DIFFERENT = """
import motes
from motes import balance, shapes
from mpi4py import MPI

world = motes.World(seed=1, space=(-1, 1), progress="off", {0})
a, b = world.system("a"), world.system("b")
with world:
    for frame in world.frames(3):
        a.source(shapes.Box((-1, -1, -1), (1, 1, 1)), rate=2400)
        a.move()
        world.step()
"""


@pytest.mark.parametrize(
    "argument",
    [
        "combine='overlapped' if MPI.COMM_WORLD.rank == 2 else 'together'",
        "balancer=balance.Diffusive() if MPI.COMM_WORLD.rank == 2 else None",
    ],
)
def test_ranks_that_balance_otherwise_are_found_out(argument):
    result = on_ranks(4, DIFFERENT.replace("{0}", argument), timeout=30)
    assert result.code != 0
    assert "ScriptMismatchError" in result.err, result.text


@pytest.mark.parametrize(
    ("speeds", "complaint"),
    [("2", "MOTES_SPEEDS"), ("9:0.5", "0..3"), ("2:0", "0.001..1"), ("2:2", "0.001..1")],
)
def test_wrong_speeds_are_refused(speeds, complaint):
    result = on_ranks(4, MIDDLE, "None", "/nowhere", 1, env={"MOTES_SPEEDS": speeds}, timeout=30)
    assert result.code != 0
    assert complaint in result.err
    assert "MOTES_SPEEDS" in result.err


FAILING = """
import os
import signal
import sys
import motes
from motes import balance, shapes

how, combine, policy = sys.argv[1:4]
world = motes.World(seed=1, space=(-1, 1), balancer=eval(policy), combine=combine, progress="off")
systems = [world.system(name) for name in "abc"]

def fail(particles):
    if world.frame == 3 and world.rank == 3:
        if how == "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        raise ValueError("out of luck")

with world:
    for frame in world.frames(6):
        for s in systems:
            s.source(shapes.Box((-1, -1, -1), (1, 1, 1)), rate=2400)
            s.move()
            if s is systems[1]:
                s.callback(fail)
        world.step()
"""


@pytest.mark.parametrize("how", ["raise", "kill"])
@pytest.mark.parametrize("combine", ["one_by_one", "together", "overlapped"])
@pytest.mark.parametrize("policy", ["pairwise", pytest.param("diffusive", marks=pytest.mark.slow)])
def test_a_rank_that_fails_between_rounds_ends_the_job(how, combine, policy):
    start = mpirun if how == "kill" else on_ranks
    result = start(5, FAILING, how, combine, POLICIES[policy], timeout=30)
    assert result.code != 0
    assert "rank 3" in result.err, result.text
    if how == "raise":
        assert "out of luck" in result.err, result.text
        assert "frame 3" in result.err, result.text
    assert result.err.count("*** motes") == 1, "one message"
