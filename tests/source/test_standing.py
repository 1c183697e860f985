"""Bodies in standing jobs: each finds a process like a new one, and cannot harm others if it fails."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import pytest
from launching import Hang, command, launches
from standing import on_ranks

STATE = """
import os, signal, sys, threading, warnings
import numpy as np
import motes
from motes._run import attendance, continuing, process, script_lines, stopping
from mpi4py import MPI
told = {name: text for name, text in os.environ.items() if name.startswith("MOTES_")}
print(MPI.COMM_WORLD.rank, MPI.COMM_WORLD.size, sys.argv[1:], os.getcwd(), told, len(sys.path))
print(signal.getsignal(signal.SIGINT), sys.unraisablehook, warnings.filters, np.geterr())
print(sorted(vars(motes.World)))
print(vars(process.process), vars(continuing.continued), len(continuing.open_movies()), attendance._gone)
print(len(threading.enumerate()), "acting" in sys.modules, hasattr(sys, "ps1"), len(script_lines._of_script))
"""
LEAVES = """
import acting, builtins, ctypes
os.environ["MOTES_BIRTHS"] = "calculators"
os.chdir("/")
signal.signal(signal.SIGINT, signal.SIG_IGN)
warnings.simplefilter("error")
np.seterr(all="raise")
motes.World.step = motes.World.added = None
movie = motes.Movie("/tmp/never.mp4")
script_lines._of_script["a"] = True
attendance._gone.add(3)
sys.ps1 = ">>> "
sys.path.append("/nowhere")
sys.unraisablehook = print
ctypes.CDLL(None).puts(b"from C")
"""
OPENS = "attendance._gone.clear(); world = motes.World().open(); 1 / 0"  # there is no rank 3


def pids(n: int) -> list[str]:
    return sorted(on_ranks(n, "import os\nprint(os.getpid())").lines)


@pytest.mark.usefixtures("children_import_tests")
@pytest.mark.parametrize("wrong", ["", "raise ValueError('wrong')", OPENS])
def test_nothing_is_left_of_a_body(wrong: str):
    before = sorted(on_ranks(3, STATE, "a").lines)
    first = on_ranks(3, STATE + LEAVES + wrong, "a")
    assert (first.code != 0) == bool(wrong) and first.out.count("from C") == 3, first.text
    assert sorted(on_ranks(3, STATE, "a").lines) == before
    assert first.err.count("*** motes: ") == bool(wrong), first.text


def runs(pid: str) -> bool:
    """Return whether a process exists and is not a zombie."""
    try:
        return Path("/proc", pid, "stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


def test_a_body_that_cannot_be_undone_costs_its_job(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(launches, "replaced", [])
    before = pids(5)
    with pytest.raises(Hang, match="(?s)no end within 2 s.*said before"):
        on_ranks(2, "import time; print('said before'); time.sleep(60)", timeout=2)
    after = pids(5)
    assert not set(before) & set(after) and not any(map(runs, before))
    result = on_ranks(2, "import threading, time; threading.Thread(target=time.sleep, args=(60,)).start()")
    assert result.code == 0, result.text
    assert not set(after) & set(pids(2))
    assert "no end" not in launches.replaced[0] and "a thread named" in launches.replaced[1]


KILLED = """
import os, signal, sys
sys.path.insert(0, sys.argv[1])
from standing import on_ranks
body = "import os, sys, time; open(sys.argv[1], 'a').write(f'{os.getpid()} '); time.sleep(60)"
def watch(_):
    if os.path.exists(sys.argv[2]) and len(open(sys.argv[2]).read().split()) == 2:
        os.kill(os.getpid(), signal.SIGKILL)
on_ranks(2, body, sys.argv[2], watch=watch)
"""


def test_ranks_end_when_the_tests_are_killed(tmp_path: Path):
    ended = command([sys.executable, "-c", KILLED, Path(__file__).parents[1] / "support", tmp_path / "pids"])
    assert ended.code == -9, ended.text
    limit = time.monotonic() + 30
    while any(os.path.exists(f"/proc/{pid}") for pid in (tmp_path / "pids").read_text().split()):
        assert time.monotonic() < limit
        time.sleep(0.02)
