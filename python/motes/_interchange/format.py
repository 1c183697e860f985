"""What a format of exports says of itself, in one row beside its functions (`npz.py`, `vtp.py`, `usd.py`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from numpy.typing import NDArray

from .manifest import Manifest, SystemColumns

__all__ = ["Format"]


def _nothing() -> None:
    pass


@dataclass(frozen=True)
class Format:
    """A way to write particles."""

    kind: str
    """Its name, and the suffix of its parts."""
    index: str
    """The suffix of the file that shows all parts; empty: there is none, and the path is the folder."""
    write: Callable[..., None]
    """`write(path, columns, frame=, time=)`."""
    read: Callable[..., dict[str, NDArray[Any]]]
    """`read(path, names, frame=)`."""
    show: Callable[[Manifest, str], bytes] | None = None
    """The content of the index, whose parts are in a folder of this name."""
    mark: str = ""
    """What each index holds near its beginning: others are not ours to replace."""
    beside: Mapping[str, Callable[[SystemColumns], bytes]] = field(default_factory=dict)
    """Files that each system has once beside its parts: their suffix, and their content."""
    require: Callable[[], None] = _nothing
    """Raises MissingExtra where a package that it needs is not installed."""
    alone: bool = False
    """Whether one part can be opened by itself, also one that another program wrote."""
    mistaken: tuple[str, ...] = ()
    """Suffixes of paths that mean this format."""
