"""Settings that Open MPI and NumPy's linear algebra get before they start; imported before mpi4py."""

from __future__ import annotations

import os
import sys

# libfabric's module for one-sided messages, of which the engine sends none: looking for its network cards
# adds a second to each start (Open MPI 5.0.11). Another module sends two-sided messages over libfabric.
if "mpi4py.MPI" not in sys.modules:
    os.environ.setdefault("OMPI_MCA_btl", "^ofi")

# The threads that OpenBLAS makes at `import numpy`, one per processor, would wait actively for work: 30 ms of
# each processor at the start of each rank. So they sleep after 2^16 cycles without work.
os.environ.setdefault("OPENBLAS_THREAD_TIMEOUT", "16")
