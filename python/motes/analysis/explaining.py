"""Explain what costs a run's time: `Run.explain`.

A run is explained part by part (`Run.parts`), each by its own ranks; losses with the same cause add up.
"""

from __future__ import annotations

import html
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from .delays import delays
from .imbalances import imbalances, most_saved, saving_of_part
from .losses import LEAST_PART, Loss, Part, told_s
from .saving import Saving

if TYPE_CHECKING:
    from .run import Run

__all__ = ["Explanation", "Loss", "Saving", "explain", "frame_s_of", "most_saved_by", "told_s"]

MOST_SENTENCES = 6


@dataclass(frozen=True)
class Explanation:
    """Losses of a run's time; prints as sentences, the largest loss first.

    Attributes:
        losses: at most six losses, each with its cause, seconds per frame and a sentence.
        saving: part of the run's time that the best other balancer would save; below 0: it would lose.
        frame_s: mean seconds per frame.
        low: lower bound of `saving`.
        high: upper bound.
        balancer: its name, such as "PrefixCuts"; "": none could be replayed.
    """

    losses: tuple[Loss, ...]
    saving: float
    frame_s: float
    low: float = float("nan")
    high: float = float("nan")
    balancer: str = ""

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


def explain(run: Run) -> Explanation:
    """Return the losses of a run's time; documented in `Run.explain`."""
    parts = [Part.of(part) for part in run.parts()]
    frames = sum(part.frames for part in parts)
    losses: dict[tuple[str, int | None], Loss] = {}
    for part in parts:
        for loss in (*imbalances(part), *delays(part)):
            seconds = loss.seconds * part.frames / max(frames, 1)
            if len(parts) > 1:
                loss = replace(loss, sentence=f"{loss.sentence.removesuffix('.')} (frames {part.where}).")
            same = losses.get((loss.cause, loss.rank))
            if same is None:
                losses[loss.cause, loss.rank] = replace(loss, seconds=seconds)
            else:
                longer = loss if seconds > same.seconds else same
                losses[loss.cause, loss.rank] = replace(longer, seconds=seconds + same.seconds)
    seconds = _mean(parts)
    worth = [loss for loss in losses.values() if seconds > 0 and loss.seconds >= LEAST_PART * seconds]
    worth.sort(key=lambda loss: -loss.seconds)
    found_saving = _saving(parts)
    return Explanation(
        tuple(worth[:MOST_SENTENCES]),
        found_saving.part,
        seconds,
        found_saving.low,
        found_saving.high,
        found_saving.balancer,
    )


def most_saved_by(run: Run) -> float:
    """Return the part of the run's time that perfect balance would save if it cost nothing."""
    parts = [Part.of(part) for part in run.parts()]
    return _weighted((most_saved(part), part.frame_s * part.frames) for part in parts)


def _saving(parts: list[Part]) -> Saving:
    """Combine what balancing would save in each part, weighted by its seconds."""
    savings = [(saving_of_part(part), part.frame_s * part.frames) for part in parts]
    bounds = ("part", "low", "high")
    part, low, high = (
        _weighted((getattr(one, name), seconds) for one, seconds in savings) for name in bounds
    )
    known = [(seconds, one.balancer) for one, seconds in savings if one.part == one.part]
    return Saving(part, low, high, max(known, default=(0.0, ""))[1])


def _weighted(values: Iterable[tuple[float, float]]) -> float:
    """Return the mean of values, each with its weight; NaN counts as not given."""
    known = [(value, weight) for value, weight in values if value == value]
    whole = sum(weight for _, weight in known)
    return sum(value * weight for value, weight in known) / whole if whole > 0 else float("nan")


def frame_s_of(run: Run) -> float:
    """Return the mean seconds of a frame."""
    return _mean([Part.of(part) for part in run.parts()])


def _mean(parts: list[Part]) -> float:
    return sum(part.frame_s * part.frames for part in parts) / max(sum(part.frames for part in parts), 1)
