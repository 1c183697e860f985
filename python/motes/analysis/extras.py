"""The packages of the extra `analysis`, imported when they are needed."""

from __future__ import annotations

import importlib
from typing import Any

__all__ = ["matplotlib", "pandas"]


def pandas() -> Any:
    """Import pandas, or say how to install it."""
    return _import("pandas", "tables of a run's log need pandas")


def matplotlib(module: str = "matplotlib") -> Any:
    """Import matplotlib, or one of its modules, or say how to install it."""
    return _import(module, "plots of a run's log need matplotlib")


def _import(module: str, need: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ImportError(f'{need}: pip install "motes[analysis]" ({error})', name=module) from error
