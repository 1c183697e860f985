"""A folder of its own for each job's launcher."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterator

__all__ = ["folder_of_a_job"]

_VARIABLE = "PRTE_MCA_prte_local_tmpdir_base"


@contextlib.contextmanager
def folder_of_a_job() -> Iterator[tuple[str, dict[str, str]]]:
    """Make a folder for a job's launcher, remove it in the end; gives also the variables that say it.

    mpirun of Open MPI 5 names its files by its process, and does not start ("The PMIx server's listener
    thread failed to start") where a killed one left files of the same number behind.
    """
    # Errors: a daemon of the launcher that outlives it may still write there.
    with tempfile.TemporaryDirectory(prefix="motes-run-", ignore_cleanup_errors=True) as folder:
        yield folder, {_VARIABLE: folder}
