"""Random worlds: balancers, and periodic space, where reach is limited to half a period."""

from __future__ import annotations

import inspect
import re
from functools import cache

from hypothesis import strategies as st

from motes import balance

__all__ = ["PERIODS", "allowed", "balancers"]

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
    r"'cells'"
    r"|(Gravitate|Match\w+)\((?!.*max_radius=)"
    r"|(Collide|Contact)\((?!(.*\W)?radius=)"
    r"|other=\w(?!.*other_radius=\d)"
)


def allowed(periods: str, lines: list[str]) -> list[str]:
    """Remove calls that are refused, or whose reach may become too large when particles grow."""
    kept = [line for line in lines if not periods or not FAR.search(line)]
    return kept or ["a.move()"]


@cache
def balancers(*, rows: bool) -> list[str]:
    """Return every balancer that needs no argument, with options that make it balance as often as possible.

    `rows`: whether domains form rows, as some balancers require.
    """
    calls = ["None"]
    eager = {"threshold": 0.001, "min_particles": 1}
    for name in balance.__all__:
        kind = getattr(balance, name)
        if not inspect.isclass(kind) or not issubclass(kind, balance.Balancer) or kind is balance.Balancer:
            continue
        if kind.slabs_only and not rows:
            continue
        takes = inspect.signature(kind).parameters
        if all(parameter.default is not parameter.empty for parameter in takes.values()):
            arguments = ", ".join(f"{name}={value}" for name, value in eager.items() if name in takes)
            calls.append(f"motes.balance.{name}({arguments})")
    return calls
