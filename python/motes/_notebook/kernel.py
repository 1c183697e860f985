"""Detects whether this process is the kernel of a notebook."""

from __future__ import annotations

import sys

__all__ = ["running"]


def running() -> bool:
    """Return whether this process is a Jupyter kernel. Imports nothing: a kernel has loaded IPython."""
    ipython = sys.modules.get("IPython")
    if ipython is None:
        return False
    shell = ipython.get_ipython()
    return getattr(shell, "kernel", None) is not None
