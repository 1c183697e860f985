"""Skips what needs the laboratory's compiled part, which the preset `dev` leaves out."""

from __future__ import annotations

from pathlib import Path

import pytest

from motes import _core

__all__ = ["IS_LEFT_OUT", "needs_compiled"]

IS_LEFT_OUT = not hasattr(_core, "lab") and Path(_core.__file__).parts[-3:-1] == ("python", "motes")
"""Whether the core is one of a checkout, built without the laboratory; an installed one has it."""
needs_compiled = pytest.mark.skipif(IS_LEFT_OUT, reason="the core was built without the laboratory")
