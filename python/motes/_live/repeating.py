"""Reads the steering that a run repeats, before it starts; all ranks agree on it."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from .._run import same_script
from .._values import environment
from ..errors import ArgumentError
from . import steer_file

__all__ = ["Repeated", "agree", "checked"]


class Repeated(NamedTuple):
    """The steering of the run that is repeated."""

    path: str
    seed: int
    rows: dict[int, dict[str, Any]]


def checked(given: Any) -> str | None:
    """Return the path in MOTES_STEERING, or else the one in World's argument `steering`, or None."""
    import os

    path: str | None = environment.read("MOTES_STEERING")
    if path is not None:
        return path
    if given is None:
        return None
    if (
        not isinstance(given, (str, os.PathLike))
        or not os.fspath(given)
        or isinstance(os.fspath(given), bytes)
    ):
        raise ArgumentError("steering", given, f"None or the path of a {steer_file.NAME}")
    return os.fspath(given)


def agree(path: str, *, reads: bool, seed: int | None, broadcast: Callable[[bytes], bytes]) -> Repeated:
    """Read the file on the rank that `reads`, check its script and seed, and broadcast it.

    Collective. Raises ArgumentError on all ranks.
    """
    packed = b""
    if reads:
        try:
            header, rows = _read(path, seed)
            content: dict[str, Any] = {"seed": header["seed"], "rows": list(rows.items())}
        except ArgumentError as error:
            content = {"allowed": error.allowed}
        packed = zlib.compress(json.dumps(content).encode())
    content = json.loads(zlib.decompress(broadcast(packed)))
    if "allowed" in content:
        raise ArgumentError("steering", path, content["allowed"])
    return Repeated(path, content["seed"], {frame: row for frame, row in content["rows"]})


def _read(path: str, seed: int | None) -> tuple[steer_file.Header, dict[int, dict[str, Any]]]:
    header, rows = steer_file.read(path)
    what = f"a {steer_file.NAME} of a run"
    if seed is not None and header["seed"] != seed:
        raise ArgumentError("steering", path, f"{what} with seed {seed}: this one has seed {header['seed']}")
    now = same_script.facts()
    if header["script_sha256"] != now["sha256"] and not environment.read("MOTES_ANYWAY"):
        allowed = f"{what} of this script: {_difference(Path(path), header, now)} (--anyway repeats it)"
        raise ArgumentError("steering", path, allowed)
    return header, rows


def _difference(path: Path, header: steer_file.Header, now: dict[str, Any]) -> str:
    """Return how the script has changed, if the log beside the file has its text."""
    try:
        text = json.loads((path.parent / "run.json").read_bytes())["script"]
    except (OSError, ValueError, KeyError, TypeError):
        return "the script has changed since, or is a different one"
    then = {"arguments": now["arguments"], "sha256": header["script_sha256"], "text": text}
    return same_script.difference(then, now)
