"""Explain what costs a run's time: `Run.explain`.

A run is explained part by part (`Run.parts`), each by its own ranks; losses with the same cause add up.
"""

from __future__ import annotations

import html
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from .delays import delays
from .imbalances import imbalances, saved_s
from .losses import LEAST_PART, Loss, Part, told_s

if TYPE_CHECKING:
    from .run import Run

__all__ = ["Explanation", "Loss", "Saving", "explain", "frame_s_of", "saving_of", "told_s"]

MOST_SENTENCES = 6


@dataclass(frozen=True)
class Explanation:
    """Losses of a run's time; prints as sentences, the largest loss first.

    Attributes:
        losses: at most six losses, each with its cause, seconds per frame and a sentence.
        saving: fraction 0..1 of the run's time that perfect balance would save if moving particles cost
            nothing.
        frame_s: mean seconds per frame.
    """

    losses: tuple[Loss, ...]
    saving: float
    frame_s: float

    @property
    def sentences(self) -> list[str]:
        """The sentences, at most six."""
        if self.losses:
            return [loss.sentence for loss in self.losses]
        return [f"Nothing stands out: no single cause takes {LEAST_PART:.0%} of the frame."]

    def __str__(self) -> str:
        """Return the sentences as lines."""
        return "\n".join(self.sentences)

    __repr__ = __str__

    def html(self) -> str:
        """Return the sentences as an HTML list."""
        lines = "".join(f"<li>{html.escape(text)}</li>" for text in self.sentences)
        return f"<ol>{lines}</ol>"

    _repr_html_ = html


@dataclass(frozen=True)
class Saving:
    """What balancing would save in a part of a run, as fractions of its time."""

    part: float


def explain(run: Run) -> Explanation:
    """Return the losses of a run's time; documented in `Run.explain`."""
    parts = [Part.of(part) for part in run.parts()]
    frames = sum(part.frames for part in parts)
    found: dict[tuple[str, int | None], Loss] = {}
    for part in parts:
        for loss in (*imbalances(part), *delays(part)):
            seconds = loss.seconds * part.frames / max(frames, 1)
            if len(parts) > 1:
                loss = replace(loss, sentence=f"{loss.sentence.removesuffix('.')} (frames {part.where}).")
            same = found.get((loss.cause, loss.rank))
            if same is None:
                found[loss.cause, loss.rank] = replace(loss, seconds=seconds)
            else:
                longer = loss if seconds > same.seconds else same
                found[loss.cause, loss.rank] = replace(longer, seconds=seconds + same.seconds)
    seconds = _mean(parts)
    worth = [loss for loss in found.values() if seconds > 0 and loss.seconds >= LEAST_PART * seconds]
    worth.sort(key=lambda loss: -loss.seconds)
    return Explanation(tuple(worth[:MOST_SENTENCES]), _saving(parts), seconds)


def saving_of(run: Run) -> float:
    """Return the fraction of the run's time that perfect balance would save if moving particles cost nothing.

    The first frame is excluded, as in all of `explain`.
    """
    return _saving([Part.of(part) for part in run.parts()])


def saving_of_part(part: Part) -> Saving:
    """Estimate what balancing would save in one part of a run; NaN if its log lacks the data."""
    known = part.frame_s > 0 and not part.load.empty
    return Saving(saved_s(part) / part.frame_s if known else float("nan"))


def _saving(parts: list[Part]) -> float:
    saved = [(saving_of_part(part).part, part.frame_s * part.frames) for part in parts]
    known = [(fraction, seconds) for fraction, seconds in saved if fraction == fraction]
    whole = sum(seconds for _, seconds in known)
    return sum(fraction * seconds for fraction, seconds in known) / whole if whole > 0 else float("nan")


def frame_s_of(run: Run) -> float:
    """Return the mean seconds of a frame."""
    return _mean([Part.of(part) for part in run.parts()])


def _mean(parts: list[Part]) -> float:
    return sum(part.frame_s * part.frames for part in parts) / max(sum(part.frames for part in parts), 1)
