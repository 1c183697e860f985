"""Runs benchmarks as separate jobs on several ranks."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from typing import Any

from .._launch import starting
from .._launch.files import folder_of_a_job
from .._launch.supervisor import Relay
from .._run import losses
from ..errors import MotesError

__all__ = ["figures_of"]


def figures_of(module: str, ranks: int, options: Sequence[str], *, survive: bool = False) -> dict[str, Any]:
    """Run a module on `ranks` ranks, and return the last JSON object that it prints.

    `survive`: ranks may be lost; the exit code is then ignored.

    Raises MotesError with the job's errors if it fails or prints no object.
    """
    argv = starting.command(ranks, [sys.executable, "-m", module, *options], survive=survive)
    with folder_of_a_job() as (_, own):
        variables = {**own, **os.environ, **(losses.ENVIRONMENT if survive else {})}
        job = subprocess.run(argv, check=False, capture_output=True, text=True, env=variables)
    lines = [line for line in job.stdout.splitlines() if line.startswith("{")]
    if (job.returncode != 0 and not survive) or not lines:
        raise MotesError(f"the job on {ranks} ranks failed:\n{_said(job.stderr)}")
    figures: dict[str, Any] = json.loads(lines[-1])
    return figures


def _said(errors: str) -> str:
    """Remove the launcher's own messages if a rank's message says what has failed."""
    kept: list[bytes] = []
    relay = Relay(kept.append)
    relay.feed(f"{errors}\n".encode())
    return b"".join(kept).decode().strip() if relay.message else errors
