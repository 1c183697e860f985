"""A temporary folder for each job's launcher."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterator

__all__ = ["folder_of_a_job"]

_VARIABLE = "PRTE_MCA_prte_local_tmpdir_base"


@contextlib.contextmanager
def folder_of_a_job() -> Iterator[tuple[str, dict[str, str]]]:
    """Yield a temporary folder for a job's launcher, and the environment variables that name it.

    mpirun of Open MPI 5 names its files by its process id, and fails to start ("The PMIx server's listener
    thread failed to start") if a killed one with the same id has left files behind.
    """
    # Ignore errors: a daemon that outlives the launcher may still write there.
    with tempfile.TemporaryDirectory(prefix="motes-run-", ignore_cleanup_errors=True) as folder:
        yield folder, {_VARIABLE: folder}
