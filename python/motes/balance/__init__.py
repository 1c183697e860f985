"""Load balancers (paper 3.2.5): they change domains so that all calculators need the same time.

After each frame the manager has each calculator's load: particles, seconds, speed. A balancer turns loads
into orders for neighbours, or into every calculator's share; donors then find the new cuts. Particles and
pixels never depend on it. A balancer of your own is a subclass with one method:

    class BySpeed(motes.balance.Balancer):
        def decide(self, load):
            return motes.balance.Targets(load.powers)

The same object balances a run, `World(balancer=BySpeed())`, and replays the log of an earlier one,
`run.replay(BySpeed())`.
"""

from __future__ import annotations

import inspect
import operator
from abc import abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, Self

import numpy as np
import numpy.typing as npt

from .. import _core
from .._values import arguments
from .._values.values import says_near_names
from ..errors import ArgumentError, NotAssignableError, missing, near
from ._load_table import LoadTable, table_of

__all__ = [
    "Balancer",
    "Diffusive",
    "LoadTable",
    "Orders",
    "Pairwise",
    "PrefixCuts",
    "Proportional",
    "Static",
    "Targets",
]

MOST = 2**64 - 1


@dataclass(frozen=True)
class Targets:
    """Wanted shares of all particles.

    The engine finds the cuts from histograms of all calculators, without gathering particles, and cuts all
    domains anew at once.

    Attributes:
        shares: one per calculator in the order of their domains, on any positive scale.
    """

    shares: npt.ArrayLike


@dataclass(frozen=True)
class Orders:
    """Particles to move between neighbours.

    The engine makes them legal: orders over the same cut are added with their signs, and no calculator gives
    more particles than it has.

    Attributes:
        moves: `(from, to, count)` each, calculators numbered by their domains.
    """

    moves: Iterable[tuple[int, int, int]]


class Balancer:
    """Base of all balancers; a user's own overrides `decide`.

    Attributes:
        smoothing: weight in 0..1 of a calculator's known speed against a new sample, while speeds change; 0
            trusts only the last frame. While samples differ only by noise, the known speed has a larger
            weight.
        over: "system" balances each particle system by itself, "all" the sum over systems.
        slabs_only: whether it needs domains in a row, that is, slabs along one axis.
    """

    smoothing: float = 0.5
    over: Literal["system", "all"] = "system"
    slabs_only: ClassVar[bool] = False

    def __new__(cls, *given: Any, **named: Any) -> Self:
        """Refuse a class that cannot decide."""
        if cls.decide is Balancer.decide:
            raise ArgumentError("balancer", cls.__name__, "a class with a method decide(load)")
        if (given or named) and cls.__init__ is object.__init__:
            raise TypeError(f"{cls.__name__}() takes no arguments")
        return super().__new__(cls)

    @abstractmethod
    def decide(self, load: LoadTable) -> Targets | Orders:
        """Decide for one system's loads of one frame. Called on the manager only.

        Args:
            load: the loads of all calculators.

        Returns:
            `Targets`, shares for all calculators, or `Orders`, particles to move between neighbours.
        """

    @property
    def _policy(self) -> _core.Policy:
        """This balancer as the engine takes it."""
        return _core.scripted_policy(self._name(), self._plan, *self._options())

    def _plan(self, table: _core.BalanceTable) -> _core.BalancePlan:
        """Ask `decide`, and turn its answer into what the engine understands."""
        where = f"{self._name()}, frame {table.frame}"
        try:
            answer = self.decide(LoadTable(table))
        except BaseException as error:
            error.add_note(f"in the balancer {where}, system {table.system!r}")
            raise
        if isinstance(answer, Targets):
            plan = _core.BalancePlan([], _shares(where, answer), [])
        elif isinstance(answer, Orders):
            plan = _core.BalancePlan(_moves(where, answer), [], [])
        else:
            raise ArgumentError(f"{where}: decide's answer", answer, "Targets or Orders")
        return _core.legal_plan(plan, table, self._name())

    def _name(self) -> str:
        kind, shown = type(self).__name__, repr(self)
        return shown if kind in shown else f"{kind}: {shown}"

    def _options(self) -> tuple[float, bool]:
        smoothing = arguments.number("smoothing", self.smoothing, low=0, high=1)
        return smoothing, arguments.choice("over", self.over, ("system", "all")) == "all"

    def __repr__(self) -> str:
        """Show the class, as a call."""
        return f"{type(self).__name__}()"


class _Native(Balancer):
    """A balancer whose policy is implemented in the core."""

    def __init__(self, smoothing: float, over: Literal["system", "all"]) -> None:
        self.smoothing = smoothing
        self.over = over

    def __setattr__(self, name: str, given: Any) -> None:
        """Set an option; refuse unknown ones, unless a user's subclass has them."""
        known = [*inspect.signature(type(self)).parameters, "smoothing", "over"]
        if name not in known and type(self).__module__ == __name__:
            raise NotAssignableError(f"{type(self).__name__} has no option {name!r}{near(name, known)}")
        super().__setattr__(name, given)

    def decide(self, load: LoadTable) -> Targets | Orders:
        """Decide by the core's policy. Called on the manager only.

        Args:
            load: the loads of all calculators.

        Returns:
            What the policy plans for these loads.
        """
        plan = self._policy.plan(table_of(load))
        return Targets(plan.shares) if len(plan.shares) else Orders(plan.orders)

    def _check(self) -> None:
        """Check the options, which a script may have changed since: `_policy` is what the engine takes."""
        self.smoothing, _ = self._options()

    def __repr__(self) -> str:
        """Show the call."""
        return self._policy.name


class Static(_Native):
    """Cuts stay where they are: the paper's static load balancing."""

    def __init__(self) -> None:
        """Take no options."""
        super().__init__(Balancer.smoothing, Balancer.over)

    @property
    def _policy(self) -> _core.Policy:
        """This balancer as the engine takes it."""
        return _core.static_policy()


class Pairwise(_Native):
    """The paper's dynamic load balancing (3.2.5), by the manager, between neighbours.

    Pairs of neighbours are compared from left to right, starting alternately with the first and second pair.
    A pair whose times differ by more than the threshold divides its particles by processing power, and the
    next pair is skipped: each calculator either gives or takes, and with one neighbour only. Times are
    particles over measured speed; a difference that the noise of the measurement can explain does not count.
    Domains must be slabs: in bricks no neighbour is the next one.
    """

    slabs_only = True

    @says_near_names
    def __init__(
        self,
        threshold: float = 0.10,
        *,
        powers: Sequence[float] | None = None,
        min_particles: int = 64,
        smoothing: float = 0.5,
        over: Literal["system", "all"] = "system",
    ) -> None:
        """Set the options.

        Args:
            threshold: smallest difference in time that counts, as a fraction of the longer time.
            powers: each machine's power, one per calculator, as in the paper: the last frame's times are
                compared, and a pair divides its particles in proportion to its powers. None: measured speeds.
            min_particles: fewer are not worth a message.
            smoothing: see `Balancer`.
            over: see `Balancer`.
        """
        super().__init__(smoothing, over)
        self.threshold = threshold
        self.powers = powers
        self.min_particles = min_particles
        self._check()

    def _check(self) -> None:
        super()._check()
        self.threshold = arguments.number("threshold", self.threshold, low=0, high=1)
        self.powers = None if self.powers is None else _powers(self.powers, above=True)
        self.min_particles = arguments.integer("min_particles", self.min_particles, high=MOST)

    @property
    def _policy(self) -> _core.Policy:
        """This balancer as the engine takes it."""
        self._check()
        return _core.pairwise_policy(self.threshold, self.powers or [], self.min_particles, *self._options())


class Diffusive(_Native):
    """Neighbours decide by themselves (the paper's future work, section 6).

    Neighbours whose times differ tell each other their loads, and part of the difference flows over the cut
    between them: first-order diffusion (G. Cybenko, 1989). The flow fades with the difference, so it needs no
    wide threshold and does not stall on a gradient as `Pairwise` can; but an imbalance between distant
    calculators takes many frames. Domains must be slabs.

    With a manager, that one sees which neighbours differ, brings them together, and collects the new cuts.
    With `manager=False` it plans nothing and is asked nothing: all neighbours compare their loads in each
    frame, before they report. Reports carry the new cuts along, and the verdict brings them to all ranks.
    What crosses a cut by itself then counts one frame later.
    """

    slabs_only = True

    @says_near_names
    def __init__(
        self,
        threshold: float = 0.005,
        *,
        rate: float = 0.8,
        min_particles: int = 64,
        manager: bool = True,
        smoothing: float = 0.5,
        over: Literal["system", "all"] = "system",
    ) -> None:
        """Set the options.

        Args:
            threshold: smallest difference in time that counts, as a fraction of the longer time.
            rate: part of half the difference that flows, in 0..1; with 1 equal machines may oscillate.
            min_particles: fewer are not worth a message.
            manager: whether it says which neighbours differ.
            smoothing: see `Balancer`.
            over: see `Balancer`.
        """
        super().__init__(smoothing, over)
        self.threshold = threshold
        self.rate = rate
        self.min_particles = min_particles
        self.manager = manager
        self._check()

    def _check(self) -> None:
        super()._check()
        self.threshold = arguments.number("threshold", self.threshold, low=0, high=1)
        self.rate = arguments.number("rate", self.rate, low=0, high=1)
        self.min_particles = arguments.integer("min_particles", self.min_particles, high=MOST)
        self.manager = arguments.flag("manager", self.manager)

    @property
    def _policy(self) -> _core.Policy:
        """This balancer as the engine takes it."""
        self._check()
        return _core.diffusive_policy(
            self.threshold, self.rate, self.min_particles, self.manager, *self._options()
        )


class PrefixCuts(_Native):
    """Moves all cuts at once, from global prefix sums along the axis; particles may skip several domains.

    Each calculator counts its particles in bins; the manager adds up the bins and places the cuts so that
    each calculator gets its share. One evaluation is enough, wherever the imbalance is.
    """

    @says_near_names
    def __init__(
        self,
        threshold: float = 0.05,
        *,
        powers: Sequence[float] | None = None,
        min_particles: int = 64,
        smoothing: float = 0.5,
        over: Literal["system", "all"] = "system",
    ) -> None:
        """Set the options.

        Args:
            threshold: cuts move when the slowest calculator is this fraction above the mean.
            powers: each machine's power, one per calculator: the rest of the measured time is the cost of the
                place, which suits particles that differ in cost. None: shares follow measured speeds, which
                suits machines that differ.
            min_particles: cuts stay while no calculator is this many particles off its share.
            smoothing: see `Balancer`.
            over: see `Balancer`.
        """
        super().__init__(smoothing, over)
        self.threshold = threshold
        self.powers = powers
        self.min_particles = min_particles
        self._check()

    def _check(self) -> None:
        super()._check()
        self.threshold = arguments.number("threshold", self.threshold, low=0)
        self.powers = None if self.powers is None else _powers(self.powers, above=True)
        self.min_particles = arguments.integer("min_particles", self.min_particles, high=MOST)

    @property
    def _policy(self) -> _core.Policy:
        """This balancer as the engine takes it."""
        self._check()
        return _core.prefix_cuts_policy(
            self.threshold, self.powers or [], self.min_particles, *self._options()
        )


class Proportional(_Native):
    """Fixed shares of the particles, whatever the clock says: cuts follow the particles alone."""

    @says_near_names
    def __init__(
        self,
        powers: Sequence[float],
        *,
        threshold: float = 0.05,
        min_particles: int = 64,
        over: Literal["system", "all"] = "system",
    ) -> None:
        """Set the options.

        Args:
            powers: each calculator's share, on any scale; 0 leaves a calculator idle.
            threshold: cuts move when a calculator is off its share by more than this fraction of it,
            min_particles: and by at least this many particles.
            over: see `Balancer`.
        """
        super().__init__(Balancer.smoothing, over)
        self.powers = powers
        self.threshold = threshold
        self.min_particles = min_particles
        self._check()

    def _check(self) -> None:
        super()._check()
        self.powers = _powers(self.powers, above=False)
        self.threshold = arguments.number("threshold", self.threshold, low=0)
        self.min_particles = arguments.integer("min_particles", self.min_particles, high=MOST)

    @property
    def _policy(self) -> _core.Policy:
        """This balancer as the engine takes it."""
        self._check()
        return _core.proportional_policy(self.powers, self.threshold, self.min_particles, *self._options())


BALANCERS = tuple(kind.__name__ for kind in (Static, Pairwise, Diffusive, PrefixCuts, Proportional))


def __getattr__(name: str) -> Any:
    raise missing("motes.balance", name, __all__)


def __dir__() -> list[str]:
    return [*__all__]


def policy_of(balancer: Balancer) -> _core.Policy:
    """Return what the engine takes for a balancer, for the rest of the package."""
    return balancer._policy


def _powers(powers: Any, *, above: bool) -> list[float]:
    allowed = f"a list of finite numbers {'>' if above else '>='} 0, one per calculator"
    values = arguments.floats("powers", powers, np.float64, allowed)
    good = values.ndim == 1 and values.size > 0 and bool(np.isfinite(values).all())
    if not good or bool((values < 0).any()) or (above and bool((values == 0).any())):
        raise ArgumentError("powers", powers, allowed)
    if not values.any():
        raise ArgumentError("powers", powers, f"{allowed}, not all 0")
    return [float(value) for value in values]


def _shares(where: str, targets: Targets) -> list[float]:
    allowed = "numbers, one per calculator"
    shares = arguments.floats(f"{where}: shares", targets.shares, np.float64, allowed)
    if shares.ndim != 1 or shares.size == 0:
        raise ArgumentError(f"{where}: shares", targets.shares, allowed)
    return [float(share) for share in shares]


def _moves(where: str, orders: Orders) -> list[tuple[int, int, int]]:
    allowed = "a list of (from, to, count), integers >= 0"
    moves = []
    try:  # whatever the list is, and whatever numbers are in it
        for move in orders.moves:
            source, to, count = (_whole(number) for number in move)
            if min(source, to) < 0 or max(source, to) >= 2**31 or not 0 <= count <= MOST:
                raise ValueError
            moves.append((source, to, count))
    except Exception as error:
        raise ArgumentError(f"{where}: orders", orders.moves, allowed) from error
    return moves


def _whole(number: Any) -> int:
    try:
        return operator.index(number)
    except TypeError:
        if not isinstance(number, (float, np.floating)) or int(number) != number:
            raise ValueError from None
    return int(number)
