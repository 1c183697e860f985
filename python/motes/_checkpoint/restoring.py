"""Restore a checkpoint into the engine, on any number of calculators."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .. import _core
from .._run.collectives import first_text
from ..errors import CheckpointError
from .finding import Origin

if TYPE_CHECKING:
    from mpi4py import MPI

__all__ = ["restore"]

_WHAT = "other ranks to read their particles"


def restore(
    engine: _core.Engine, origin: Origin, comm: MPI.Intracomm, calculators: list[int], stall_s: float | None
) -> None:
    """Restore the engine's counts, domains and particles. Collective.

    If there are as many calculators as parts, each reads one. Otherwise each reads an equal share of every
    system; the particles migrate to their owners in the next frame. All ranks raise CheckpointError if one
    fails.
    """
    problem = ""
    try:
        engine.restore_state(origin.world, [tuple(sample) for sample in origin.samples or []])
        if comm.rank in calculators:
            _read(engine, origin, calculators.index(comm.rank), len(calculators))
    except (RuntimeError, ValueError) as error:
        problem = str(error)
    rank, problem = first_text(comm, problem, stall_s, _WHAT)
    if problem:
        failure = CheckpointError(f"{origin.place}: {problem}")
        failure.speaker = rank
        raise failure


def _read(engine: _core.Engine, origin: Origin, calculator: int, calculators: int) -> None:
    manifest = origin.manifest
    assert manifest is not None
    if len(manifest.parts) == calculators:
        part = _core.PartFile(str(origin.place / manifest.parts[calculator].file), False)
        for system, (_, rows) in enumerate(part.rows):
            engine.restore_rows(part, system, 0, rows)
        engine.restore_speeds(part)
        return
    wanted = [
        (total * calculator // calculators, total * (calculator + 1) // calculators)
        for total in manifest.particles
    ]
    before = [0] * len(wanted)
    for entry in manifest.parts:
        shares = [
            (max(low - start, 0), min(high - start, rows))
            for (low, high), start, rows in zip(wanted, before, entry.rows, strict=True)
        ]
        if any(first < last for first, last in shares):
            part = _core.PartFile(str(origin.place / entry.file), False)
            for system, (first, last) in enumerate(shares):
                if first < last:
                    engine.restore_rows(part, system, first, last)
        before = [start + rows for start, rows in zip(before, entry.rows, strict=True)]
