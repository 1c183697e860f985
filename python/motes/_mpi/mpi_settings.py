"""Environment variables that MPI and NumPy's linear algebra read; imported before mpi4py and NumPy."""

from __future__ import annotations

import os
import sys

# Open MPI 5 does not start without HOME, which services and containers may lack. Users without an entry in
# the password database get what `login` and Docker give them.
if not os.environ.get("HOME"):
    import pwd

    try:
        os.environ["HOME"] = pwd.getpwuid(os.getuid()).pw_dir or "/"
    except KeyError:
        os.environ["HOME"] = "/"

# Disable libfabric's module for one-sided messages, which the engine does not use: its search for network
# cards adds a second to each start (Open MPI 5.0.11). Two-sided messages use another module of libfabric.
if "mpi4py.MPI" not in sys.modules:
    os.environ.setdefault("OMPI_MCA_btl", "^ofi")

# OpenBLAS starts one thread per processor at `import numpy`. Busy-waiting, they would take 30 ms of each
# processor at the start of each rank, so let them sleep after 2^16 cycles without work.
os.environ.setdefault("OPENBLAS_THREAD_TIMEOUT", "16")
