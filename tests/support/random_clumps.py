"""Random clumps drawn by hypothesis: systems whose particles are groups of spheres."""

from __future__ import annotations

import re

from hypothesis import strategies as st

__all__ = ["templates", "with_clumps"]

SMALL = 'Set(attribute="size", value=minimum(maximum(column("size"), 0.125), 0.5))'
WALLS = ("()", "(Plane((0, -1, 0), (0, 1, 0)),)", "(Box((-2, -2, -2), (2, 2, 2)), Sphere((0, -3, 0), 2))")


def thousandths(low: int, high: int) -> st.SearchStrategy[float]:
    """Draw numbers in steps of a thousandth."""
    return st.integers(low, high).map(lambda n: n / 1000)


@st.composite
def templates(draw: st.DrawFn) -> dict[str, list[tuple[float, ...]]]:
    """Draw which of the systems a and b have clumps: the spheres by the system's name."""
    sphere = st.tuples(*[thousandths(-200, 200)] * 3, thousandths(50, 200))
    chosen = draw(st.sampled_from(["", "", "", "a", "b", "ab"]))
    return {name: draw(st.lists(sphere, min_size=1, max_size=3)) for name in chosen}


@st.composite
def with_clumps(draw: st.DrawFn, lines: list[str], names: dict[str, object], periodic: bool) -> list[str]:
    """Let the clumps of each of these systems meet once, each sphere with its own radius.

    In periodic space they are small, so they do not see farther than half a period.
    """
    for name in names:
        contact = f"{name}.apply(Contact("
        facts = f"stiffness={draw(thousandths(1000, 500_000))}, friction={draw(thousandths(0, 1000))}"
        text = f"{contact}{facts}, walls={draw(st.sampled_from(WALLS))}))"
        lines.insert(draw(st.integers(0, len(lines))), text)
        places = [place for place, line in enumerate(lines) if line.startswith(contact)]
        lines = [line for place, line in enumerate(lines) if place not in places[1:]]
        lines[places[0]] = re.sub(r"(?<= )radius=[^,]+, ", "", lines[places[0]])
        if periodic:
            lines.insert(places[0], f"{name}.apply({SMALL})")
    return lines
