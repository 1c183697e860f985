"""Seconds of a recorded run's frames under another balancer, and how uncertain they are."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ..balance import policy_of
from .costs import Costs
from .frames import simulate

if TYPE_CHECKING:
    from ..balance import Balancer
    from .frames import Step
    from .history import Recorded

__all__ = ["Estimate", "estimated"]

Floats = npt.NDArray[np.float64]
MOVING = 0.2
"""Part of the migrants that a replay may miss, or see too many of, where it moves cuts."""
BUSIEST = 0.03
"""Part by which a calculator's particles may be wrong, since the log tells where they are in sixteenths."""
ROUGH = 0.02
"""Part of a frame that is uncertain in any case."""
DEALT = 0.15
"""The same if ranks share the picture: who draws what, and how, is planned anew in each frame."""
UNKNOWN = 0.25
"""The same for a log that does not tell what moving particles costs."""
VARIANTS = ((1.0, False), (1.0 + MOVING, False), (1.0 - MOVING, False), (1.0, True))
"""Assumptions: a factor for migrants beyond those recorded, and whether pictures cost what they did then."""


class Estimate:
    """The run's clocks under the other balancer and, for comparison, under its own."""

    def __init__(self, costs: Costs, *, decentralised: bool) -> None:
        """Start at the first frame. `decentralised`: neighbours compare their loads before they answer."""
        self._costs, self._decentralised = costs, decentralised
        self._variants = VARIANTS if costs.draw_s.any() else VARIANTS[:-1]
        self._now = [costs.clocks() for _ in self._variants]
        self._rows: list[list[float]] = []
        self._acted: list[float] = []

    def add(self, step: Step) -> None:
        """Run the next frame."""
        costs = self._costs
        now = [
            clocks.frame(costs.of_step(step, self._decentralised, moving=moving, as_drawn=as_drawn))
            for clocks, (moving, as_drawn) in zip(self._now, self._variants, strict=True)
        ]
        self._rows.append([float(costs.actual_s[step.k]), float(costs.then_s[step.k]), *now])
        self._acted.append(float(step.seconds.max()))

    def seconds(self) -> tuple[Floats, Floats, Floats]:
        """Return the frames' seconds, and their lower and upper bounds, (frames,) each.

        A frame takes what it took in the run, and the difference between the clocks of both balancers. The
        bounds are the frames under the assumptions that make the run shortest and longest.
        """
        actual, then, *now = np.array(self._rows).reshape(len(self._rows), 2 + len(self._variants)).T
        estimates = [actual + one - then for one in now]
        if then.sum() > 0:  # what the clocks do not explain may grow with the rest
            estimates.append(
                actual * (now[0].sum() / then.sum()) + (now[0] - then * (now[0].sum() / then.sum()))
            )
        estimates = [np.maximum(one, 0.0) for one in estimates]
        best, sums = estimates[0], [float(one.sum()) for one in estimates]
        changed = bool(np.any(now[0] != then))
        known = self._costs.known and self._costs.measured
        parts = np.full(len(best), ROUGH if known else UNKNOWN)
        parts[self._costs.shared_pictures] += DEALT
        margin = (parts * best + BUSIEST * np.array(self._acted)) * changed
        low = np.maximum(estimates[int(np.argmin(sums))] - margin, 0.0)
        return best, low, estimates[int(np.argmax(sums))] + margin


def estimated(history: Recorded, costs: Costs, balancer: Balancer) -> tuple[Floats, Floats, Floats]:
    """Return the seconds of a run's frames under a balancer, and their bounds, (frames,) each.

    Args:
        history: the recorded loads.
        costs: the recorded costs.
        balancer: the other balancer.
    """
    estimate = Estimate(costs, decentralised=policy_of(balancer).decentralised)
    for step in simulate(history, balancer):
        estimate.add(step)
    return estimate.seconds()
