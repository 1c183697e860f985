"""Views that detect writing, even if no value changes or there are no particles.

With sub-steps, `System.local` shows a preview in the middle of a frame. It is kept only if the script writes
into it. That must not depend on the particles of one rank, so even a write that changes nothing counts.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["WrittenView", "noticing"]

WRITERS = frozenset({np.copyto, np.put, np.place, np.putmask, np.fill_diagonal, np.put_along_axis})
"""NumPy functions that write into their first argument."""


class WrittenView(np.ndarray):
    """An array over another array's memory that reports writes; created by `noticing`."""

    _on_write: Callable[[], None] | None

    def __array_finalize__(self, other: NDArray[Any] | None) -> None:
        """Let slices of a view report writes, too."""
        self._on_write = getattr(other, "_on_write", None)

    def _note(self) -> None:
        if self._on_write is not None:
            self._on_write()

    def __setitem__(self, key: Any, value: Any) -> None:
        """Write items."""
        self._note()
        super().__setitem__(key, value)

    def fill(self, value: Any) -> None:
        """Write one value everywhere."""
        self._note()
        super().fill(value)

    def sort(self, *arguments: Any, **keywords: Any) -> None:
        """Sort in place."""
        self._note()
        super().sort(*arguments, **keywords)

    def partition(self, *arguments: Any, **keywords: Any) -> None:
        """Partition in place."""
        self._note()
        super().partition(*arguments, **keywords)

    def put(self, *arguments: Any, **keywords: Any) -> None:
        """Write at flat indices."""
        self._note()
        super().put(*arguments, **keywords)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **keywords: Any) -> Any:
        """Compute with plain arrays; `out=`, which `a += b` uses, is a write."""
        out = keywords.get("out", ())
        for target in (*out, *(inputs[:1] if method == "at" else ())):
            if isinstance(target, WrittenView):
                target._note()
        if out:
            keywords["out"] = tuple(_plain(target) for target in out)
        result = getattr(ufunc, method)(*map(_plain, inputs), **keywords)
        return out[0] if len(out) == 1 else result

    def __array_function__(self, function: Any, types: Any, arguments: Any, keywords: Any) -> Any:
        """Call a NumPy function; report a write if it is one of `WRITERS`."""
        if function in WRITERS and arguments and isinstance(arguments[0], WrittenView):
            arguments[0]._note()
        return super().__array_function__(function, types, arguments, keywords)


def noticing(view: NDArray[Any], on_write: Callable[[], None]) -> NDArray[Any]:
    """Return a view of the same memory that calls `on_write` before each write."""
    watched = view.view(WrittenView)
    watched._on_write = on_write
    return watched


def _plain(value: Any) -> Any:
    return value.view(np.ndarray) if isinstance(value, WrittenView) else value
