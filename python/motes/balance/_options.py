"""The options of the core's balancers: what they are allowed to be."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .._values import arguments
from ..errors import ArgumentError

__all__ = ["MOST", "Option", "checked_powers"]

MOST = 2**64 - 1


class Option(NamedTuple):
    """An option as the core describes it, beside the policy that has it (`cpp/balance/policy_*.h`)."""

    kind: str
    default: Any
    most: float

    def checked(self, name: str, given: Any) -> Any:
        """Return the value that an option is given, if it is allowed."""
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
    """Return the powers of machines; `above`: all of them must be above 0, else one at least."""
    allowed = f"a list of finite numbers {'>' if above else '>='} 0, one per calculator"
    values = arguments.floats("powers", powers, np.float64, allowed)
    good = values.ndim == 1 and values.size > 0 and bool(np.isfinite(values).all())
    if not good or bool((values < 0).any()) or (above and bool((values == 0).any())):
        raise ArgumentError("powers", powers, allowed)
    if not values.any():
        raise ArgumentError("powers", powers, f"{allowed}, not all 0")
    return [float(value) for value in values]
