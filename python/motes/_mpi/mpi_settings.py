"""Settings for Open MPI and NumPy's linear algebra; imported before mpi4py and NumPy, which read them."""

from __future__ import annotations

import os
import sys

# Disable libfabric's module for one-sided messages, which the engine does not use: its search for network
# cards adds a second to each start (Open MPI 5.0.11). Two-sided messages use another module of libfabric.
if "mpi4py.MPI" not in sys.modules:
    os.environ.setdefault("OMPI_MCA_btl", "^ofi")

# OpenBLAS starts one thread per processor at `import numpy`. Busy-waiting, they would take 30 ms of each
# processor at the start of each rank, so let them sleep after 2^16 cycles without work.
os.environ.setdefault("OPENBLAS_THREAD_TIMEOUT", "16")
