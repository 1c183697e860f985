"""The scripts that make pages of the documentation, as modules."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import pytest

__all__ = ["script_of_docs"]

DOCS = Path(__file__).resolve().parents[2] / "docs"


def script_of_docs(name: str) -> Any:
    """Load a script; skip the test if the source tree has only the tests."""
    path = next(DOCS.glob(f"**/scripts/{name}.py"), None)
    if path is None:
        pytest.skip(f"scripts/{name}.py stands in the source tree", allow_module_level=True)
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
