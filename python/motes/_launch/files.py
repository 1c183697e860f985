"""Temporary folders of each job's launcher: for its own files, and for the memory that the ranks share."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator

from .._io.files import is_locked_elsewhere, try_lock
from ..errors import MotesError

__all__ = ["folder_of_a_job", "folder_of_a_launcher"]

_VARIABLE = "PRTE_MCA_prte_local_tmpdir_base"
_SHARED_MEMORY = "/dev/shm"
_SHARED_VARIABLES = ("OMPI_MCA_btl_sm_backing_directory", "OMPI_MCA_btl_vader_backing_directory")
"""Where ranks of Open MPI 5 and 4 put the memory that they share."""
_PREFIX = "motes-job-"


@contextlib.contextmanager
def folder_of_a_job() -> Iterator[tuple[str, dict[str, str]]]:
    """Yield a temporary folder for a job's launcher, and the variables that name its folders.

    mpirun of Open MPI 5 names its files by its process id, and fails to start ("The PMIx server's listener
    thread failed to start") if a killed one with the same id has left files behind. A killed mpirun also
    leaves its ranks' shared memory. So both are in folders that are removed at the end. Those of a job whose
    `motes run` was killed are removed by the next one.
    """
    with contextlib.ExitStack() as folders:
        try:
            folder = folders.enter_context(_own_folder(tempfile.gettempdir()))
        except OSError as error:
            raise MotesError(
                f"no folder for temporary files: {error}; set TMPDIR to one that has room"
            ) from None
        variables = {_VARIABLE: folder}
        if not any(name in os.environ for name in _SHARED_VARIABLES):  # each overrides the other
            with contextlib.suppress(OSError):  # then the ranks choose a place themselves
                shared = folders.enter_context(_own_folder(_SHARED_MEMORY))
                variables |= dict.fromkeys(_SHARED_VARIABLES, shared)
        yield folder, variables


def folder_of_a_launcher() -> contextlib.AbstractContextManager[str]:
    """Return a context manager of a folder that lasts as long as this process, over all starts of its job."""
    return _own_folder(tempfile.gettempdir())


@contextlib.contextmanager
def _own_folder(parent: str) -> Iterator[str]:
    """Make a folder and hold a lock on it, so that it is known as in use; remove it at the end."""
    _sweep(parent)
    while True:
        folder = tempfile.mkdtemp(prefix=_PREFIX, dir=parent)
        with contextlib.suppress(FileNotFoundError):  # the sweep of another job came between
            lock = os.open(folder, os.O_RDONLY)
            if not is_locked_elsewhere(lock) and os.path.isdir(folder):
                break
            os.close(lock)
    try:
        yield folder
    finally:
        _remove(folder)
        os.close(lock)


def _remove(folder: str) -> None:
    """Remove a folder, and the memory that ranks of MPICH have named in it (`_mpi/presence.py`)."""
    with contextlib.suppress(OSError):
        for name in os.listdir(folder):
            if name.startswith("mpich_"):
                with contextlib.suppress(OSError):
                    os.unlink(os.path.join(_SHARED_MEMORY, name))
    shutil.rmtree(folder, ignore_errors=True)  # a daemon that outlives the launcher may still write there


def _sweep(parent: str) -> None:
    """Remove this user's folders whose lock nobody holds any more."""
    with contextlib.suppress(OSError), os.scandir(parent) as entries:
        for entry in entries:
            if not entry.name.startswith(_PREFIX) or not entry.is_dir(follow_symlinks=False):
                continue
            with contextlib.suppress(OSError):
                lock = os.open(entry.path, os.O_RDONLY | os.O_NOFOLLOW)
                try:
                    if os.fstat(lock).st_uid == os.getuid() and try_lock(lock):
                        _remove(entry.path)
                finally:
                    os.close(lock)
