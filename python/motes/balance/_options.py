"""Options of the core's balancers, and checks of their values."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .._values import arguments
from ..errors import ArgumentError

__all__ = ["MOST", "Option", "checked_powers"]

MOST = 2**64 - 1


class Option(NamedTuple):
    """An option as described by the core's policy (`cpp/balance/policy_*.h`)."""

    kind: str
    default: Any
    most: float

    def checked(self, name: str, given: Any) -> Any:
        """Return the value of an option; raise if it is not allowed."""
        match self.kind:
            case "number":
                return arguments.number(name, given, low=0, high=self.most)
            case "count":
                return arguments.integer(name, given, high=MOST)
            case "flag":
                return arguments.flag(name, given)
            case "over":
                return arguments.choice(name, given, ("system", "all"))
            case "shares":
                return checked_powers(given, above=False)
        return None if given is None else checked_powers(given, above=True)


def checked_powers(powers: Any, *, above: bool) -> list[float]:
    """Return the checked powers of machines; all must be > 0 if `above`, else at least one."""
    allowed = f"a list of finite numbers {'>' if above else '>='} 0, one per calculator"
    values = arguments.floats("powers", powers, np.float64, allowed)
    good = values.ndim == 1 and values.size > 0 and bool(np.isfinite(values).all())
    if not good or bool((values < 0).any()) or (above and bool((values == 0).any())):
        raise ArgumentError("powers", powers, allowed)
    if not values.any():
        raise ArgumentError("powers", powers, f"{allowed}, not all 0")
    return [float(value) for value in values]
