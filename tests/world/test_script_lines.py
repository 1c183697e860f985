"""Errors name the script's line and what ran there, on every rank."""

from __future__ import annotations

import json
import pickle
import re
from pathlib import Path

import pytest
from standing import on_ranks

import motes
from motes import RankError
from motes._run import script_lines
from motes._run.script_lines import located, rank_error
from motes._system.system import state_of

SCENE = """
import json, os, resource, sys, mpi4py.MPI
import motes
import numpy as np
from motes import shapes


def halve(p):
    return np.linalg.inv(np.zeros((2, 2)))  # line 9


def act(p):
    if rank in guilty:
        halve(p)


class Mine(motes.balance.Balancer):
    def decide(self, load):
        raise KeyError("load")  # line 19


how, guilty = sys.argv[1], eval(sys.argv[2])
world = motes.World(
    seed=1, progress="off", space=(-1, 1), roles=sys.argv[3], balancer=Mine() if how == "policy" else None
)
rank = world.rank
system = world.system("a")
with world:
    for frame in world.frames(3):
        system.burst(shapes.Box((-1, 0, 0), (1, 1, 1)), 100)
        if how == "callback" and frame == 1:
            system.callback(act)
        if how == "lambda" and frame == 1:
            system.callback(lambda p: 1 / 0 if rank in guilty else None)  # line 34
        if how == "births" and frame == 1:
            if rank in guilty:  # has no memory for them
                now = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
                resource.setrlimit(resource.RLIMIT_AS, (now + 200_000_000, resource.RLIM_INFINITY))
            with system.local():  # counts as no call
                pass
            system.burst(shapes.Point((0, 0, 0)), 3)
            system.burst(shapes.Box((-1, 0, 0), (1, 1, 1)), 30_000_000)  # line 42
        system.move()
        try:
            world.step()
        except motes.RankError as error:
            told = [rank, error.rank, error.frame, error.action, error.line, error.text, str(error)]
            os.write(1, (json.dumps(told) + chr(10)).encode())
            mpi4py.MPI.COMM_WORLD.Barrier()  # the first to raise ends the job
            raise
        except Exception as error:
            notes = getattr(error, "__notes__", [])
            os.write(1, (json.dumps([rank, type(error).__name__, notes]) + chr(10)).encode())
            mpi4py.MPI.COMM_WORLD.Barrier()
            raise
"""


@pytest.mark.parametrize(
    ("how", "ranks", "roles", "guilty", "own", "action", "line", "text"),
    [
        ("callback", 4, "auto", 3, "LinAlgError", "callback act", 9, "LinAlgError: Singular matrix"),
        ("callback", 2, "auto", 1, "LinAlgError", "callback act", 9, "LinAlgError: Singular matrix"),
        ("callback", 3, "shared", 0, "LinAlgError", "callback act", 9, "LinAlgError: Singular matrix"),
        ("lambda", 5, "auto", 4, "ZeroDivisionError", "callback <lambda>", 34, "ZeroDivisionError: division"),
        (
            "policy",
            4,
            "auto",
            1,
            "KeyError",
            "balancer Mine()",
            19,
            "KeyError: 'load'\nin the balancer Mine()",
        ),
    ],
)
def test_other_ranks_name_the_line_that_failed(how, ranks, roles, guilty, own, action, line, text):
    result = on_ranks(ranks, SCENE, how, f"[{guilty}]", roles, timeout=30)
    assert result.code == 1, result.text
    told = sorted(json.loads(line) for line in result.out.splitlines())
    assert [row[0] for row in told] == list(range(ranks)), result.text
    for row in told:
        if row[0] == guilty:
            assert row[1] == own
            continue
        assert row[1] == guilty
        assert row[3:5] == [action, f"script.py:{line}"]
        assert row[5].startswith(text)
        assert f", {action} at script.py:{line}: {text}" in row[6]
        assert "At:" not in row[6], "no frames of the package"


@pytest.mark.parametrize(("ranks", "roles", "guilty"), [(3, "auto", 1), (2, "shared", 0)])
def test_births_that_fail_name_the_line_that_recorded_them(ranks, roles, guilty):
    result = on_ranks(ranks, SCENE, "births", f"[{guilty}]", roles, timeout=60)
    assert result.code == 1, result.text
    told = sorted(json.loads(line) for line in result.out.splitlines())
    assert [row[0] for row in told] == list(range(ranks)), result.text
    for row in told:
        if row[0] == guilty:
            assert row[1] == "MemoryError"
            assert row[2] == ["recorded at script.py:42"], result.text
        else:
            assert row[1] == guilty
            assert row[3:5] == ["burst", "script.py:42"]


def inside(system, function):
    """Make a call inside a function of the script; the function's own line counts."""
    function(system)


def test_copies_of_a_script_in_one_process_have_numbers_of_their_own():
    """A source is known by file and line: whatever ran here before, all ranks agree on it."""
    places = [(compile("x = 1", file, "exec"), 0) for file in ("/a/first.py", "/b/second.py", "/c/first.py")]
    numbers = [script_lines.number_of(place) for place in places]
    assert places[0] == places[1] and numbers[0] == numbers[2] != numbers[1]


def test_each_call_knows_the_line_that_recorded_it():
    world = motes.World(seed=1, progress="off")
    system, other = world.system("a"), world.system("b")
    calls = [
        lambda s: s.source((0, 0, 0), 24),
        lambda s: s.burst((0, 0, 0), 1),
        lambda s: s.burst((0, 0, 0)),
        lambda s: s.emit(position=[(0, 0, 0)]),
        lambda s: s.spawn(other, on="death", count=1),
        lambda s: s.callback(print),
        lambda s: s.gravity((0, -9.81, 0)),
        lambda s: s.set(alpha=0.5),
        lambda s: s.apply(motes.actions.Move()),
        lambda s: s.apply([motes.actions.Move()]),
        lambda s: s.move(),
    ]
    with world:
        for call in calls:
            inside(system, call)
        lines = [script_lines._shown(line) for line in state_of(system).lines]
        state_of(system).entries.clear()  # nothing runs
        assert lines == [f"{Path(__file__).name}:{call.__code__.co_firstlineno}" for call in calls]


def failure(text: str) -> RankError:
    return rank_error(text, rank=1, role="manager", frame=7, action="create", speaker=1)


def test_a_failure_without_a_line_gets_the_one_that_runs():
    with pytest.raises(RankError) as caught, located(lambda place: None, lambda: (-1, -1)):
        raise failure("std::bad_alloc")
    error = caught.value
    assert error.line is not None
    assert re.fullmatch(r"test_script_lines.py:\d+", error.line)
    assert str(error) == f"rank 1 (manager), frame 7, create at {error.line}: std::bad_alloc"
    again = pickle.loads(pickle.dumps(error))
    assert (again.line, again.action, str(again)) == (error.line, "create", str(error))


def test_notes_of_errors_are_shown_plainly():
    """As pybind11 writes them before Python 3.12, and from 3.12 on."""
    for kind in ("KeyError", "KeyError[WITH __notes__]"):
        error = failure(
            f"{kind}: 'load'\n__notes__ (len=2):\nin the balancer\nsystem 'a'\n\nAt:\n  a.py(3): f\n"
        )
        assert error.text == "KeyError: 'load'\nin the balancer\nsystem 'a'"


def test_frames_of_libraries_are_passed_over_where_the_script_has_one():
    library = f"ValueError: no\n\nAt:\n  {json.__file__}(3): loads\n"
    script = "  /home/me/snow.py(21): f\n  /home/me/snow.py(40): <module>\n"
    assert failure(library + script).line == "snow.py:21"
    assert failure(library).line == "__init__.py:3"
    assert failure("ValueError: no").line is None
