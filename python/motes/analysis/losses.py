"""A part of a run, as `Run.explain` looks at it, and a loss that it finds there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pandas import DataFrame, Series

    from .run import Run

__all__ = ["LEAST_PART", "Loss", "Part", "told_s"]

LEAST_PART = 0.02
"""Losses below this fraction of the frame are not reported."""


@dataclass(frozen=True)
class Loss:
    """Time lost per frame to one cause.

    Attributes:
        cause: "imbalance", "moving imbalance", "thrashing", "slow rank", "network", "small frames", "script",
            "picture", "log", "talk", "checkpoint", "recovery", "system"; or the role of a rank for which
            others wait: "manager", "image generator" or "rank".
        seconds: mean seconds lost per frame.
        rank: the rank responsible; None: all ranks.
        sentence: description of the loss, and advice.
    """

    cause: str
    seconds: float
    rank: int | None
    sentence: str


@dataclass(frozen=True)
class Part:
    """Frames of a run in which ranks and roles stay the same (`Run.parts`).

    Attributes:
        run: its facts and rows.
        seconds: seconds of each frame. Like the next two, without the part's first frame, which opens files,
            allocates memory or restores a world, unless fewer than three would remain.
        load: rows of run.load.
        times: rows of run.times, with zero where a log of an earlier version has nothing.
    """

    run: Run
    seconds: Series
    load: DataFrame
    times: DataFrame

    @classmethod
    def of(cls, run: Run) -> Part:
        """Return a part of a run."""
        seconds = _settled(run.frames).set_index("frame")["t_frame_s"].fillna(0.0)
        return cls(run, seconds, _settled(run.load), _settled(run.times).fillna(0.0))

    @property
    def frames(self) -> int:
        """Number of frames, the first included."""
        return len(self.run.frames)

    @property
    def where(self) -> str:
        """The first frame and the last one, as text."""
        return f"{self.run.frames['frame'].min()} to {self.run.frames['frame'].max()}"

    @property
    def frame_s(self) -> float:
        """Mean seconds of a frame."""
        return float(self.seconds.mean()) if len(self.seconds) else 0.0

    @property
    def crowded(self) -> bool:
        """Whether several ranks had to share a core."""
        cores = self.run.facts.get("cores")
        return bool(cores) and len(set(self.run.hosts.values())) == 1 and self.run.ranks > int(cores or 0)

    def costs(self, seconds: float) -> str:
        """Return seconds per frame as text, compared with the whole frame."""
        return f"{told_s(seconds)} of a frame's {told_s(self.frame_s)}"


def _settled(table: DataFrame) -> DataFrame:
    later = table[table["frame"] > table["frame"].min()]
    return later if later["frame"].nunique() >= 3 else table


def told_s(seconds: float) -> str:
    """Return seconds as text: "12.3 ms"."""
    return f"{seconds:.3g} s" if seconds >= 1 else f"{seconds * 1e3:.3g} ms"
