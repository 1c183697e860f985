"""run.json: what was run, by whom and on which machines; written whole when the run starts."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import socket
import sys
import time
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import mpi4py

from .. import _core
from .._io import files

__all__ = ["write_run"]

SCHEMA = 1


def write_run(
    directory: str | os.PathLike[str], facts: dict[str, Any], hosts: Sequence[str], threads: Sequence[int]
) -> None:
    """Write `directory`/run.json from the world's facts, and the host and threads of each rank."""
    script = Path(sys.argv[0]) if sys.argv and sys.argv[0] else None
    text = script.read_text(errors="replace") if script is not None and script.is_file() else ""
    run = {
        "schema": SCHEMA,
        "started_unix_s": time.time(),
        "argv": sys.argv,
        "script": text,
        "script_sha256": hashlib.sha256(text.encode()).hexdigest(),
        **facts,
        "ranks": [{"rank": rank, "host": host, "threads": threads[rank]} for rank, host in enumerate(hosts)],
        "motes": _version("motes"),
        "mpi": _core.mpi_version(),
        "mpi4py": mpi4py.__version__,
        "python": platform.python_version(),
        "simd": _core.simd(),
        "machine": platform.machine(),
        "cores": os.cpu_count(),
        "host": socket.gethostname(),
        "pid": os.getpid(),
    }
    files.write_whole(Path(directory) / "run.json", (json.dumps(run, indent=1) + "\n").encode())


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"
