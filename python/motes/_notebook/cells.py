"""Shows progress below a notebook's cell while the loop of `World.frames` runs in it.

One output is updated in place: a bar, a line of progress and the last picture. The saved notebook keeps it.
"""

from __future__ import annotations

import base64
import html
import importlib
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._run.progress import reached
from .stills import still

__all__ = ["CellProgress"]

EVERY_S = 0.5
LEAST_WIDTH = 480  # of the bar


class CellProgress:
    """The output of one loop."""

    def __init__(self, total: int, done: int, particles: int) -> None:
        """Show the start of the loop, with `done` of `total` frames done."""
        display: Any = importlib.import_module("IPython.display").display

        self._total = total
        self._first = done
        self._start = self._shown = time.monotonic()
        self._pixels: NDArray[np.uint8] | None = None
        self._frame = 0  # of the last picture
        self._handle: Any = display(self._content(done, particles), raw=True, display_id=True)

    def picture(self, pixels: NDArray[np.uint8], frame: int) -> None:
        """Keep a picture for the next output."""
        self._pixels, self._frame = pixels, frame

    def due(self) -> bool:
        """Return whether the output may be updated: at most twice per second."""
        return time.monotonic() - self._shown >= EVERY_S

    def show(self, done: int, particles: int) -> None:
        """Update the output."""
        content = self._content(done, particles)
        self._handle.update(content, raw=True)
        self._shown = time.monotonic()

    def _content(self, done: int, particles: int) -> dict[str, str]:
        fps = (done - self._first) / max(time.monotonic() - self._start, 1e-9)
        text = reached(done, total=self._total, fps=fps, particles=particles)
        bar = f'<progress value="{done}" max="{self._total}" style="width: 100%"></progress>'
        line = f'<div style="font-variant-numeric: tabular-nums">{html.escape(text)}</div>'
        width, image = self._image()
        page = f'<div style="max-width: {max(width, LEAST_WIDTH)}px">{bar}{line}{image}</div>'
        return {"text/html": page, "text/plain": text}

    def _image(self) -> tuple[int, str]:
        """Return the picture's width and the element that shows it."""
        if self._pixels is None:
            return 0, ""
        small, kind, data = still(self._pixels)
        source = f"data:{kind};base64,{base64.b64encode(data).decode()}"
        return small, f'<img alt="frame {self._frame}" style="max-width: 100%" src="{source}">'
