"""Checkpoint: how often a run is saved, and where."""

from __future__ import annotations

import os
from typing import Any, Literal

from ..errors import ArgumentError
from . import arguments
from .values import Value, value

__all__ = ["AUTO", "Checkpoint"]

AUTO = "auto"


@value()
class Checkpoint(Value):
    """Periodic checkpoints: all particles are written to disk while the run continues.

    A run of the same script with the same directory continues from the newest complete checkpoint, on any
    number of ranks, in any roles. Checkpoints are taken when the loop of `world.frames(n)` begins an
    iteration: what the script computes in that loop must depend only on the frame's number and the particles.

    Attributes:
        directory: on a file system that all ranks see; each checkpoint is a folder in it.
        every: frames from one checkpoint to the next; "auto": as many as `seconds` last.
        keep: how many complete checkpoints are kept; with two, the run survives a damaged one. With "auto",
            older ones are kept, too.
        pickles: whether a custom balancer's state is saved and loaded by pickle if it holds more than
            numbers, text, lists, dicts and arrays. Loading a pickle can run code chosen by the author of the
            checkpoint.
        seconds: with "auto": how long computing any frame from the checkpoint before it may take, without
            pictures and on the same machines. Then `motes frame` and `World.seek` reach each frame quickly.
        gigabytes: with "auto": the space for checkpoints, 1e9 bytes each. When it is used up, the checkpoints
            that are closest to others go, so that more seconds lie between those left.
    """

    directory: str | os.PathLike[str]
    every: int | Literal["auto"] = 48
    keep: int = 2
    pickles: bool = False
    seconds: float = 2
    gigabytes: float = 10

    def __post_init__(self) -> None:
        """Check the fields."""
        if not isinstance(self.directory, (str, os.PathLike)) or not os.fspath(self.directory):
            raise ArgumentError("directory", self.directory, "a directory's path")
        self.__dict__.update(
            directory=os.fspath(self.directory),
            every=_every(self.every),
            keep=arguments.integer("keep", self.keep, low=1, high=10**6),
            pickles=arguments.flag("pickles", self.pickles),
            seconds=arguments.number("seconds", self.seconds, low=0, high=1e9),
            gigabytes=arguments.number("gigabytes", self.gigabytes, low=0, high=1e9),
        )


def _every(given: Any) -> int | str:
    if isinstance(given, str):
        if given != AUTO:
            raise ArgumentError("every", given, "a number of frames >= 1, or 'auto'", known=(AUTO,))
        return given
    return arguments.integer("every", given, low=1, high=2**62)


def checked(given: Any) -> Checkpoint | None:
    """Return `World`'s argument `checkpoint` as a Checkpoint, or None."""
    if given is None or isinstance(given, Checkpoint):
        return given
    if isinstance(given, (str, os.PathLike)) and os.fspath(given):
        return Checkpoint(given)
    raise ArgumentError("checkpoint", given, "None, a directory's path or Checkpoint(...)")
