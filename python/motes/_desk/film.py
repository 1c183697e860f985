"""The pictures of all frames that the desk has seen, encoded, within a budget of memory."""

from __future__ import annotations

from bisect import bisect_right
from typing import NamedTuple

__all__ = ["Film", "Shot"]


class Shot(NamedTuple):
    """The newest picture of a frame."""

    take: int
    """The number of the run that drew it, counted from 1."""
    data: bytes
    """A JPEG file."""


class Film:
    """Encoded pictures by frame. When they exceed the budget, every second one is dropped."""

    def __init__(self, budget: int) -> None:
        """`budget`: the most bytes of pictures."""
        self._budget = budget
        self._shots: dict[int, Shot] = {}
        self._order: list[int] | None = []  # the frames, sorted; None: not known
        self._spans: list[list[int]] | None = []  # None: not known
        self.bytes = 0
        self.step = 1
        """The most frames from one picture to the next where none was missed."""

    def add(self, frame: int, shot: Shot) -> None:
        """Keep a picture in place of an earlier one of its frame."""
        before = self._shots.get(frame)
        if before is not None:
            self.bytes -= len(before.data)
            if before.take != shot.take:
                self._spans = None
        elif self._order is not None and (not self._order or frame > self._order[-1]):
            self._order.append(frame)
            if self._spans is not None:
                self._lengthen(self._spans, frame, shot.take)
        else:
            self._order = self._spans = None
        self._shots[frame] = shot
        self.bytes += len(shot.data)
        while self.bytes > self._budget and len(self._shots) > 2:
            self._thin()

    def at(self, frame: int) -> tuple[int, Shot] | None:
        """Return the last picture that is not after a frame, and its own frame; None: there is none."""
        frames = self._sorted()
        found = bisect_right(frames, frame)
        if found == 0 or frame - frames[found - 1] >= self.step:
            return None
        return frames[found - 1], self._shots[frames[found - 1]]

    def spans(self) -> list[list[int]]:
        """Return the stretches of frames that have pictures of one take: [first, last, take]."""
        if self._spans is None:
            self._spans = []
            for frame in self._sorted():
                self._lengthen(self._spans, frame, self._shots[frame].take)
        return [list(span) for span in self._spans]

    def _lengthen(self, spans: list[list[int]], frame: int, take: int) -> None:
        """Add a frame behind all others."""
        if spans and frame - spans[-1][1] <= self.step and take == spans[-1][2]:
            spans[-1][1] = frame
        else:
            spans.append([frame, frame, take])

    def _thin(self) -> None:
        """Drop every second picture, but neither the first nor the last."""
        frames = self._sorted()
        for frame in frames[1:-1:2]:
            self.bytes -= len(self._shots.pop(frame).data)
        self._order = self._spans = None
        self.step *= 2

    def _sorted(self) -> list[int]:
        if self._order is None:
            self._order = sorted(self._shots)
        return self._order
