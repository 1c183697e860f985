"""MPI does not touch memory that was freed when a wait was abandoned."""

from __future__ import annotations

from pathlib import Path

from launching import command

from motes._run import starting


def test_mpi_leaves_memory_alone_that_was_given_back(abandoned_waits: Path):
    # Over TCP a large message moves only while both ends call MPI, so that it can be given up half way.
    result = command(
        starting.command(2, [str(abandoned_waits)]), env={"OMPI_MCA_btl": "self,tcp"}, timeout=60
    )
    assert result.lines == ["memory is as it was"], result.text
