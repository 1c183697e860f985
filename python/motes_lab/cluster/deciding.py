"""Lets `motes_replay`, which has no Python, use balancers written in Python, over two named pipes."""

from __future__ import annotations

import copy
import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Thread

import numpy as np

from motes import _core
from motes.balance import Balancer, policy_of
from motes.errors import MotesError

__all__ = ["deciding"]

END = "end"
ROOM = 1 << 20
"""Capacity of a pipe in bytes: holds a plan for tens of thousands of calculators, even without a reader."""


@contextmanager
def deciding(balancer: Balancer, folder: Path) -> Iterator[None]:
    """Answer for a balancer while the body runs; cpp/driver/piped_policy.h describes the protocol.

    An error in `decide` is sent to `motes_replay`, which ends with it, and is raised here at the end.

    Args:
        balancer: the balancer that decides.
        folder: the argument of `motes_replay --ask`; the folder is created.

    Raises:
        MotesError: the body's error, caused by the one that `decide` raised.
    """
    policy = policy_of(copy.deepcopy(balancer))  # copied, since balancers may keep state between frames
    folder.mkdir()
    over = "all" if policy.over_all else "system"
    (folder / "facts").write_text(f"{' '.join(policy.name.split())}\n{policy.smoothing!r} {over}\n")
    pipes = []
    for name in ("tables", "plans"):
        os.mkfifo(folder / name, 0o600)
        pipes.append(os.open(folder / name, os.O_RDWR))  # open at both ends, so that opening never blocks
        fcntl.fcntl(pipes[-1], fcntl.F_SETPIPE_SZ, ROOM)
    tables, plans = pipes
    failed: list[BaseException] = []
    thread = Thread(target=_answer, args=(policy, tables, plans, failed), daemon=True)
    thread.start()
    try:
        yield
    except MotesError as error:
        raise error from (failed[0] if failed else error.__cause__)
    finally:
        os.write(tables, f"\n{END}\n".encode())  # a killed process may have left half a line
        thread.join()
        for pipe in pipes:
            os.close(pipe)


def _answer(policy: _core.Policy, tables: int, plans: int, failed: list[BaseException]) -> None:
    """Answer each table with a plan, until the end."""
    with open(tables, closefd=False, encoding="utf-8") as lines:
        for line in lines:
            if line.rstrip() == END:
                return
            if not line.endswith("\n") or len(line) < 2:
                continue
            try:
                answer = _text(policy.plan(_table(line)))
            except Exception as error:
                failed.append(error)
                notes = getattr(error, "__notes__", [])
                answer = "error " + " ".join(" ".join([f"{type(error).__name__}: {error}", *notes]).split())
            view = memoryview(f"{answer}\n".encode())
            while view:
                view = view[os.write(plans, view) :]


def _table(line: str) -> _core.BalanceTable:
    frame, evaluation, axes, n, *rest = line.rstrip("\n").split(" ")
    count = int(n)
    loads = np.array(rest[: 4 * count]).reshape(count, 4)
    seconds, speed, error = (loads[:, i].astype(np.float64) for i in (1, 2, 3))
    cuts = np.array(rest[4 * count : 5 * count - 1], np.float64).astype(np.float32)
    system = " ".join(rest[5 * count - 1 :])
    particles = loads[:, 0].astype(np.uint64)
    return _core.BalanceTable(
        int(frame), int(evaluation), system, particles, seconds, speed, cuts, error, axes
    )


def _text(plan: _core.BalancePlan) -> str:
    if len(plan.shares):
        return " ".join(["shares", *map(repr, plan.shares.tolist())])
    return " ".join(["orders", *(str(number) for order in plan.orders for number in order)])
