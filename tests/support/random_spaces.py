"""Random scripts in periodic space, where particles may not see each other farther than half a period."""

from __future__ import annotations

import re

from hypothesis import strategies as st

__all__ = ["PERIODS", "allowed"]

PERIODS = st.sampled_from(
    [
        *[""] * 3,
        ", periodic={'x': (-2, 1.5)}",
        ", periodic={'x': (-1, 1.5), 'z': (-2, 2)}",
        ", periodic=dict.fromkeys('xyz', (-2, 2))",
    ]
)
"""An argument of `World`, or none."""

FAR = re.compile(
    r"Tie\(|'cells'"
    r"|(Gravitate|Match\w+)\((?!.*max_radius=)"
    r"|(Collide|Contact)\((?!(.*\W)?radius=)"
    r"|other=\w(?!.*other_radius=\d)"
)


def allowed(periods: str, lines: list[str]) -> list[str]:
    """Leave out what is refused, or may see too far when particles have grown."""
    kept = [line for line in lines if not periods or not FAR.search(line)]
    return kept or ["a.move()"]
