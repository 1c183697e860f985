"""The compiled part of the laboratory: benchmarks of kernels, simulated disasters. Its import starts MPI."""

from __future__ import annotations

from motes import _core

__all__ = ["lab"]

lab = _core
