"""run.json: what was run, how and on which machines; written whole when a run starts or is continued."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import socket
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import mpi4py

from .. import _core
from .._io import files
from .._values import environment
from ..errors import LogError

__all__ = ["earlier_run", "motes_version", "write_run"]

SCHEMA = 1


def write_run(
    directory: str | os.PathLike[str],
    facts: dict[str, Any],
    hosts: Sequence[str],
    threads: Sequence[int],
    *,
    continued_from: int = 0,
) -> None:
    """Write `directory`/run.json from the world's facts, and the host and threads of each rank.

    `continued_from`: the first frame of a run that continues an earlier one. The facts of the first start are
    kept, and those that have changed are appended to the list `continued`. Raises LogError if the file is
    damaged.
    """
    path = Path(directory) / "run.json"
    run = _of_this_process(facts, hosts, threads)
    if continued_from > 0:
        run = _appended(earlier_run(path) or run, run, continued_from)
    files.write_whole(path, (json.dumps(run, indent=1) + "\n").encode())


def _of_this_process(facts: dict[str, Any], hosts: Sequence[str], threads: Sequence[int]) -> dict[str, Any]:
    script = Path(sys.argv[0]) if sys.argv and sys.argv[0] else None
    text = script.read_text(errors="replace") if script is not None and script.is_file() else ""
    return {
        "schema": SCHEMA,
        "started_unix_s": time.time(),
        "argv": sys.argv,
        "script": text,
        "script_sha256": hashlib.sha256(text.encode()).hexdigest(),
        **facts,
        "ranks": [{"rank": rank, "host": host, "threads": threads[rank]} for rank, host in enumerate(hosts)],
        "motes": motes_version(),
        "mpi": _core.mpi_version(),
        "mpi4py": mpi4py.__version__,
        "python": platform.python_version(),
        "simd": _core.simd(),
        "machine": platform.machine(),
        "cores": os.cpu_count(),
        "host": socket.gethostname(),
        "launcher": environment.read("MOTES_LAUNCHER"),
        "pid": os.getpid(),
    }


def _appended(first: dict[str, Any], now: dict[str, Any], frame: int) -> dict[str, Any]:
    """Append the changed facts of a continuation to the facts of the first start."""
    always = ("started_unix_s", "argv", "ranks", "pid", "host", "launcher")
    differ = [name for name in now if name in always or first.get(name) != now[name]]
    part = {"frame": frame, **{name: now[name] for name in differ}}
    return {**first, "continued": [*first.get("continued", []), part]}


def earlier_run(path: Path) -> dict[str, Any] | None:
    """Read the run.json of the run that is continued; return None if it had no log.

    Raises LogError if it is damaged.
    """
    try:
        run = json.loads(path.read_bytes())
    except FileNotFoundError:
        return None
    except (OSError, ValueError, RecursionError) as error:
        raise LogError(f"{path}: cannot be continued: {error}") from error
    if not isinstance(run, dict) or not isinstance(run.get("continued", []), list):
        raise LogError(f"{path}: cannot be continued: it is not the run.json of a run")
    return run


def motes_version() -> str:
    """Return the version of the installed package; "unknown" if it is not installed."""
    from importlib.metadata import PackageNotFoundError, version  # takes 14 ms

    try:
        return version("motes")
    except PackageNotFoundError:
        return "unknown"
