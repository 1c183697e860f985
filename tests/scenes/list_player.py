"""Plays the scripts that appear in a folder: N.txt is a script, N.NAME its answer, one line per frame.

A file `stop` ends it.

Arguments: the folder, this job's name, the first N. Each rank polls the folder by itself, which costs little.
"""

from __future__ import annotations

import sys
import time
import traceback
from pathlib import Path

from mpi4py import MPI

import motes

POLL_S, PATIENCE_S = 0.003, 300.0
HOME = MPI.COMM_WORLD.rank == 0


def answer_of(text: str) -> str:
    """Run a script; return its frames as digests of particles and pictures."""
    lines: list[str] = []

    def note(particles: str, picture: motes.Frame) -> None:
        lines.append(f"{particles} {picture.digest() if picture else '-'}")

    try:
        exec(compile(text, "script", "exec"), {"note": note})
    except Exception:  # with several ranks, the first to get here ends the job instead
        lines.append(traceback.format_exc())
    return "\n".join(lines)


def main(folder: Path, name: str, number: int) -> None:
    """Answer until `stop` appears, or until no script appears for long."""
    last = time.monotonic()
    while time.monotonic() - last < PATIENCE_S and not (folder / "stop").exists():
        question = folder / f"{number}.txt"
        if not question.exists():
            time.sleep(POLL_S)
            continue
        answer = answer_of(question.read_text())
        if HOME:
            (folder / "draft").mkdir(exist_ok=True)
            draft = folder / "draft" / name
            draft.write_text(answer)
            draft.rename(folder / f"{number}.{name}")
        number, last = number + 1, time.monotonic()


main(Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]))
