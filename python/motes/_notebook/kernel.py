"""Whether this process is the kernel of a notebook."""

from __future__ import annotations

import sys

__all__ = ["running"]


def running() -> bool:
    """Whether cells of a Jupyter notebook run in this process. Imports nothing: a kernel has IPython."""
    ipython = sys.modules.get("IPython")
    if ipython is None:
        return False
    shell = ipython.get_ipython()
    return getattr(shell, "kernel", None) is not None
