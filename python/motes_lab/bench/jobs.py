"""Runs benchmarks as separate jobs on several ranks."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from typing import Any

from motes.errors import MotesError

__all__ = ["figures_of"]


def figures_of(module: str, ranks: int, options: Sequence[str], *, survive: bool = False) -> dict[str, Any]:
    """Run a module on `ranks` ranks, and return the last JSON object that it prints.

    `survive`: ranks may be lost; the exit code is then ignored.

    Raises MotesError with the job's errors if it fails or prints no object.
    """
    run = [sys.executable, "-m", "motes", "run", "-n", str(ranks), *(["--survive"] if survive else [])]
    job = subprocess.run([*run, "-m", module, *options], check=False, capture_output=True, text=True)
    lines = [line for line in job.stdout.splitlines() if line.startswith("{")]
    if (job.returncode != 0 and not survive) or not lines:
        raise MotesError(f"the job on {ranks} ranks failed:\n{job.stderr}")
    figures: dict[str, Any] = json.loads(lines[-1])
    return figures
