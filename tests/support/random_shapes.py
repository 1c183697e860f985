"""Numbers, vectors and shapes drawn by hypothesis, for random scripts."""

from __future__ import annotations

from functools import cache
from typing import Any

from hypothesis import strategies as st

__all__ = ["SURFACES", "directions", "numbers", "plus", "shapes", "triples"]

Text = st.SearchStrategy[str]


@cache
def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    """Draw numbers with few decimals, which float32 usually rounds."""
    return st.integers(round(low * 1000), round(high * 1000)).map(lambda n: n / 1000)


@cache
def triples(low: float, high: float) -> st.SearchStrategy[tuple[float, float, float]]:
    """Draw three numbers."""
    return st.tuples(numbers(low, high), numbers(low, high), numbers(low, high))


@cache
def directions() -> st.SearchStrategy[tuple[float, float, float]]:
    """Draw a vector that is not nearly zero."""
    return triples(-1, 1).filter(lambda v: sum(c * c for c in v) > 1e-3)


def plus(a: Any, b: Any) -> tuple[float, ...]:
    """Add vectors."""
    return tuple(round(p + q, 3) for p, q in zip(a, b, strict=True))


EDGES = [((2.0, 0.25, 0.0), (0.125, 1.5, 0.25)), ((0.0, 1.75, 0.5), (1.0, 0.0, -1.0))]
WITHOUT_SURFACE = ("Point", "Line", "Blob")
SURFACES = ("Plane", "Box", "Sphere", "Disc", "Rectangle", "Triangle", "Cylinder", "Cone")


@cache
@st.composite
def simple_shapes(draw: st.DrawFn, kinds: tuple[str, ...]) -> str:
    """Draw a shape other than a union."""
    kind, place = draw(st.sampled_from(kinds)), draw(triples(-2, 2))
    radius = draw(numbers(0.125, 2))
    ring = f"{radius}, {radius * draw(st.sampled_from([0.0, 0.5, 1.0]))}"
    if kind == "Point":
        return f"Point({place})"
    if kind == "Blob":
        return f"Blob({place}, {radius / 2})"
    if kind == "Sphere":
        return f"Sphere({place}, {ring})"
    if kind == "Box":
        return f"Box({place}, {plus(place, draw(triples(0, 2)))})"
    if kind in ("Rectangle", "Triangle"):
        u, v = draw(st.sampled_from(EDGES))
        edges = (u, v) if kind == "Rectangle" else (plus(place, u), plus(place, v))
        return f"{kind}({place}, {edges[0]}, {edges[1]})"
    way = draw(directions())
    if kind in ("Plane", "Disc"):
        return f"{kind}({place}, {way}{f', {ring}' if kind == 'Disc' else ''})"
    end = plus(place, way)
    return f"Line({place}, {end})" if kind == "Line" else f"{kind}({place}, {end}, {ring})"


@cache
def shapes(kinds: tuple[str, ...] = WITHOUT_SURFACE + SURFACES) -> Text:
    """Draw any shape, including unions."""
    one = simple_shapes(kinds)
    return one | one | st.lists(one, min_size=2, max_size=4).map(lambda parts: f"Union({', '.join(parts)})")
