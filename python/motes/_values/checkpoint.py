"""Checkpoint: how often a run is saved, and where."""

from __future__ import annotations

import os
from typing import Any

from ..errors import ArgumentError
from . import arguments
from .values import Value, value

__all__ = ["Checkpoint"]


@value()
class Checkpoint(Value):
    """Periodic checkpoints: all particles are written to disk while the run continues.

    A run of the same script with the same directory continues from the newest complete checkpoint, on any
    number of ranks, in any roles. Checkpoints are taken when the loop of `world.frames(n)` begins an
    iteration: what the script computes in that loop must depend only on the frame's number and the particles.

    Attributes:
        directory: on a file system that all ranks see; each checkpoint is a folder in it.
        every: frames from one checkpoint to the next.
        keep: how many complete checkpoints are kept; with two, the run survives a damaged one.
        pickles: whether a custom balancer's state is saved and loaded by pickle if it holds more than
            numbers, text, lists, dicts and arrays. Loading a pickle can run code chosen by the author of the
            checkpoint.
    """

    directory: str | os.PathLike[str]
    every: int = 48
    keep: int = 2
    pickles: bool = False

    def __post_init__(self) -> None:
        """Check the fields."""
        if not isinstance(self.directory, (str, os.PathLike)) or not os.fspath(self.directory):
            raise ArgumentError("directory", self.directory, "a directory's path")
        self.__dict__.update(
            directory=os.fspath(self.directory),
            every=arguments.integer("every", self.every, low=1, high=2**62),
            keep=arguments.integer("keep", self.keep, low=1, high=10**6),
            pickles=arguments.flag("pickles", self.pickles),
        )


def checked(given: Any) -> Checkpoint | None:
    """Return `World`'s argument `checkpoint` as a Checkpoint, or None."""
    if given is None or isinstance(given, Checkpoint):
        return given
    if isinstance(given, (str, os.PathLike)) and os.fspath(given):
        return Checkpoint(given)
    raise ArgumentError("checkpoint", given, "None, a directory's path or Checkpoint(...)")
