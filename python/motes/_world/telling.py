"""Telling: the progress and the warnings of a run; only the manager prints them."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import Any

from .._notebook import kernel
from .._run.progress import Progress
from .._system.session import Session
from .._values import environment
from ..errors import MotesWarning

__all__ = ["Telling", "warn"]


class Telling:
    """Shows how far a run is, in the way that the script or the environment chose."""

    def __init__(self, way: str | Callable[[dict[str, Any]], None], usual: bool) -> None:
        """Store `World(progress=)`; `usual`: it is the default, which notebooks replace by a bar."""
        self._way = way
        self._in_cell = usual and environment.read("MOTES_PROGRESS") is None
        self._progress: Progress | None = None

    def start(self, hosts: Sequence[str]) -> bool:
        """Start showing progress; return whether a notebook shows the loop instead."""
        in_cell = self._in_cell and len(hosts) == 1 and kernel.running()
        self._progress = Progress("off" if in_cell else self._way, hosts)
        return in_cell

    def show(self, session: Session, *, last: bool = False) -> None:
        """Show how far the run is."""
        if session.manages and self._progress is not None and session.engine is not None:
            self._progress.update(session.engine.last_row, total=session.total, last=last)


def warn(session: Session, text: str, level: int) -> None:
    """Issue a MotesWarning on the manager, for the line of the script `level` calls up the stack."""
    if session.manages:
        warnings.warn(text, MotesWarning, stacklevel=level)
