"""Grades of submissions: points in parts, with hints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from ._games import Result

__all__ = ["Grade", "Part"]


@dataclass(frozen=True)
class Part:
    """A part of a grade.

    Attributes:
        name: of the part.
        points: 0..100.
        hint: what to look at; "" if nothing is wrong.
        result: of the part's game; None if it is not a game.
    """

    name: str
    points: float
    hint: str = ""
    result: Result | None = field(default=None, repr=False)


@dataclass(frozen=True)
class Grade:
    """The grade of a submission.

    Attributes:
        evening: 1 to 6.
        name: of the task.
        parts: all of equal weight; empty if the submission failed.
        problem: why it failed; "" if it did not.
        printed: the first part of what it printed.
    """

    evening: int
    name: str
    parts: Sequence[Part]
    problem: str = ""
    printed: str = ""

    @property
    def score(self) -> float:
        """Points, 0..100: the mean of the parts."""
        if self.problem or not self.parts:
            return 0.0
        return round(sum(part.points for part in self.parts) / len(self.parts), 1)

    @property
    def figures(self) -> dict[str, Any]:
        """The grade as plain values."""
        return {
            "evening": self.evening,
            "name": self.name,
            "score": self.score,
            "problem": self.problem,
            "parts": [{"name": one.name, "points": one.points, "hint": one.hint} for one in self.parts],
            "printed": self.printed,
            "text": str(self),
        }

    def __str__(self) -> str:
        """Show points and hints."""
        lines = [f"evening {self.evening}, {self.name}: {self.score:g} of 100"]
        if self.problem:
            lines.append(f"  the submission fails: {self.problem}")
        width = max((len(part.name) for part in self.parts), default=0)
        lines += [f"  {one.name:{width}}  {one.points:5.1f}  {one.hint}".rstrip() for one in self.parts]
        if self.printed.strip():
            printed = self.printed.strip().splitlines()
            shown = printed[-1] if printed[0].startswith("Traceback") else printed[0]
            lines.append("  it printed, which does not count: " + shown + (" ..." if printed[1:] else ""))
        return "\n".join(lines)
