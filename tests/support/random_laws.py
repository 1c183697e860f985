"""Random laws drawn by hypothesis: `Law` for single particles and `Interact` for pairs."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

from hypothesis import strategies as st

from motes.actions import between

__all__ = ["BETWEEN_KINDS", "law", "readable"]

Text = st.SearchStrategy[str]
BETWEEN_KINDS = [*between.__all__, "Interact"]
STATE = '{"slip": 3, "n": 1, "way": 3}'


def places(of: str, names: Sequence[str]) -> list[str]:
    """Return expressions for the attributes of one end of a pair."""
    return [f"ex.{of}.{name}" for name in names]


@st.composite
def law(
    draw: st.DrawFn,
    kind: str,
    where: Text,
    expressions: Callable[[Text], Text],
    scalars: Sequence[str],
    triples: Sequence[str],
) -> str:
    """Draw a law that changes velocities, attributes, and the state of pairs."""
    pairs = kind == "Interact"
    numbers, vectors = places("a", scalars), places("a", triples)
    remembers = pairs and draw(st.booleans())
    arguments = [f"where={draw(where)}"]
    if pairs:
        numbers += [*places("b", scalars), "ex.r"]
        vectors += [*places("b", triples), "ex.normal", "ex.relative_velocity"]
        arguments.append(f"radius={draw(st.sampled_from([0.01, 0.125, 0.3]))}")
        arguments += draw(st.sampled_from([[], [], ["other=$"]]))
    if remembers:
        numbers += ["ex.a.state.n"] * 4
        vectors += ["ex.a.state.slip", "ex.a.state.way"] * 3
        arguments.append(f"state={STATE}")
    number = expressions(st.sampled_from(numbers))
    vector = st.tuples(st.sampled_from(vectors), number).map(lambda p: f"({p[0]} * {p[1]})")
    given = {"mass": number, "heat": number, "wind": vector, "color": vector}
    if remembers:
        given |= {"slip": vector, "n": number, "way": vector}
    chosen = draw(st.lists(st.sampled_from(sorted(given)), min_size=1, max_size=4, unique=True))
    values = ", ".join(f'"{name}": {draw(given[name])}' for name in chosen)
    arguments.append(f"set={{{values}}}")
    for name in ("acceleration", "velocity", *(["spin"] if pairs else [])):
        if draw(st.booleans()):
            arguments.append(f"{name}=ex.normalize({draw(st.sampled_from(vectors))})")
    return f"{kind}({', '.join(arguments)})"


def readable(lines: list[str]) -> list[str]:
    """Remove calls that read particles after an interaction in the list: they are refused."""
    met: set[str] = set()
    kept = []
    for line in lines:
        if ".pairs(" in line or any(f".apply({name}(" in line for name in BETWEEN_KINDS):
            met |= {line[0], *re.findall(r"other=(\w)", line)}
        if not (line.removeprefix("with ")[0] in met and (".local()" in line or ".gather()" in line)):
            kept.append(line)
    return kept
