"""What a run of `motes sweep` takes from outside, and what it reports: MOTES_SWEEP names a file with both.

The file is JSON: `controls` (name -> text), `seed` and `balancer` (or null), `log` and `result` (paths), and
`probe`. A run with `probe` only writes which controls the script has, and ends before its first frame.
The first world of the script is the one that counts.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import balance
from .._io import files
from .._values import environment
from ..errors import ArgumentError

if TYPE_CHECKING:
    from .._picture.frame import Frame

__all__ = ["Report", "claim", "default_of", "given_with"]

STILL = "last.png"
"""The name of the last picture, beside the result."""


@cache
def _wishes() -> dict[str, Any] | None:
    path = environment.read("MOTES_SWEEP")
    if path is None:
        return None
    try:
        read: dict[str, Any] = json.loads(Path(path).read_bytes())
    except (OSError, ValueError):
        raise ArgumentError("MOTES_SWEEP", path, "a file of `motes sweep`") from None
    return read


def given_with(given: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the arguments of a world with what the sweep sets."""
    wishes = _wishes()
    if wishes is None:
        return given
    chosen = {**given, "log": None, "spans": False}
    if not _claimed and not wishes["probe"]:
        chosen |= {"log": wishes["log"], "spans": given["spans"]}
    if wishes["seed"] is not None:
        chosen["seed"] = wishes["seed"]
    if wishes["balancer"] is not None:
        chosen["balancer"] = balance.by_name(wishes["balancer"].lower())
    return chosen


def default_of(name: Any, value: Any, choices: Any) -> Any:
    """Return the default value of a control: the sweep's, or the script's. Raises ArgumentError."""
    wishes = _wishes()
    if wishes is None or name not in wishes["controls"]:
        return value
    text = wishes["controls"][name]
    if choices is not None:
        return next((one for one in choices if str(one) == text), text)
    if isinstance(value, bool):
        if text.lower() not in ("true", "false", "0", "1"):
            raise ArgumentError(name, text, "true or false")
        return text.lower() in ("true", "1")
    try:
        number = float(text)
    except ValueError:
        raise ArgumentError(name, text, "a number") from None
    return int(number) if isinstance(value, int) and number.is_integer() else number


_claimed: list[Report] = []


def claim() -> Report | None:
    """Return the report of the script's first world, if this is that world in a sweep; else None."""
    wishes = _wishes()
    if wishes is None or _claimed:
        return None
    _claimed.append(Report(wishes))
    return _claimed[0]


class Report:
    """What a world reports to the sweep."""

    def __init__(self, wishes: dict[str, Any]) -> None:
        """Store where to."""
        self._path = Path(wishes["result"])
        self.probe: bool = wishes["probe"]
        """Whether the script ends before its first frame."""
        self.last: Frame | None = None
        """The last picture, on the image generator."""

    def write_controls(self, controls: Iterable[str], axis: str) -> None:
        """In a probe, write which controls the script has, and the world's axis; on the manager."""
        self._write({"controls": sorted(controls), "axis": axis})

    def save_still(self) -> str:
        """Save the last picture, on the image generator, and return its digest; "": there is none here."""
        if self.last is None:
            return ""
        self.last.save(self._path.with_name(STILL))
        return self.last.digest()

    def write(self, *, particles: str, picture: str, frames: int, count: int) -> None:
        """Write the result, on the manager."""
        content = {"particles": particles, "picture": picture, "frames": frames, "count": count}
        self._write(content)

    def _write(self, content: dict[str, Any]) -> None:
        files.write_whole(self._path, json.dumps(content).encode())
