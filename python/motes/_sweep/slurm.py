"""A sweep as a Slurm array: one task per run that is missing."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

from .._io import files

__all__ = ["write_script"]


def write_script(directory: Path, command: Sequence[str], numbers: Sequence[int], ranks: int) -> Path:
    """Write sweep.sbatch, which starts `command` with `--only NUMBER` for each missing run.

    `command`: the arguments of `motes sweep`; `ranks`: the most ranks of a run. Options of the site, such as
    --account or --time, go to sbatch.
    """
    python = shlex.quote(sys.executable)
    lines = [
        "#!/bin/sh",
        "#SBATCH --job-name=motes-sweep",
        f"#SBATCH --array={_ranges(numbers)}",
        f"#SBATCH --ntasks={ranks}",
        f"#SBATCH --output={directory / 'slurm-%A_%a.txt'}",
        f"cd {shlex.quote(os.getcwd())} || exit 1",
        f'exec {python} -m motes sweep --only "$SLURM_ARRAY_TASK_ID" {shlex.join(command)}',
        "",
    ]
    path = directory / "sweep.sbatch"
    files.write_whole(path, "\n".join(lines).encode())
    return path


def _ranges(numbers: Sequence[int]) -> str:
    """Return ascending numbers as Slurm writes them: "0-3,7"."""
    parts: list[list[int]] = []
    for number in numbers:
        if parts and number == parts[-1][1] + 1:
            parts[-1][1] = number
        else:
            parts.append([number, number])
    return ",".join(str(first) if first == last else f"{first}-{last}" for first, last in parts)
