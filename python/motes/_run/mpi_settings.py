"""Settings that Open MPI gets before it starts; imported before mpi4py."""

from __future__ import annotations

import os
import sys

# libfabric's module for one-sided messages, of which the engine sends none: looking for its network cards
# adds a second to each start (Open MPI 5.0.11). Another module sends two-sided messages over libfabric.
if "mpi4py.MPI" not in sys.modules:
    os.environ.setdefault("OMPI_MCA_btl", "^ofi")
