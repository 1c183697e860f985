"""The description of an export format; `npz.py`, `vtp.py` and `usd.py` each end with theirs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
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
    """The format's name, and the suffix of its parts."""
    index: str
    """The suffix of the index file, which lists all parts; empty: the path is a folder without index."""
    write: Callable[..., None]
    """Writes a part: `write(path, columns, frame=, time=)`, with `drawn=` also what sprites make of it."""
    read: Callable[..., dict[str, NDArray[Any]]]
    """Reads columns of a part: `read(path, names, frame=)`."""
    show: Callable[[Manifest, str], bytes] | None = None
    """`show(manifest, folder)` returns the index of the parts in a folder of that name."""
    mark: str = ""
    """Text near the beginning of each index: a file without it is not an export's and is not replaced."""
    beside: Mapping[str, Callable[[SystemColumns], bytes]] = field(default_factory=dict)
    """Files written once per system, beside its parts: from suffix to content."""
    require: Callable[[], None] = _nothing
    """Raises MissingExtraError if a package that the format needs is not installed."""
    begin: Callable[[], None] = _nothing
    """Imports and initialises the format's library; the script's thread calls it before others write."""
    drawn: Callable[[Path, int], Any] | None = None
    """`drawn(path, frame)` returns what sprites made of a part, for `write`; None: it has no sprites."""
    alone: bool = False
    """Whether a single file can be opened without a manifest, even one that another program wrote."""
    mistaken: tuple[str, ...] = ()
    """Wrong suffixes of paths that suggest this format."""
