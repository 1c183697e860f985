"""Load balancers (paper 3.2.5): they resize domains to equalise the calculators' times.

After each frame the manager knows each calculator's load: particles, seconds, speed. From the loads a
balancer computes orders between neighbours, or every calculator's share; donors then find the new cuts.
Particles and pixels never depend on the balancer. To write your own, subclass `Balancer` with one method:

    class BySpeed(motes.balance.Balancer):
        def decide(self, load):
            return motes.balance.Targets(load.powers)

The same object can balance a run, `World(balancer=BySpeed())`, or replay an earlier run's log,
`run.replay(BySpeed())`.
"""

from __future__ import annotations

import operator
from abc import abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import KW_ONLY, dataclass
from inspect import Parameter, Signature, getdoc
from typing import Any, ClassVar, Literal, Self, dataclass_transform

import numpy as np
import numpy.typing as npt

from .. import _core
from .._values import arguments
from ..errors import ArgumentError, NotAssignableError, missing, near
from ._load_table import LoadTable, table_of
from ._options import MOST, Option

__all__ = [
    "Balancer",
    "Bisection",
    "CostAware",
    "Diffusive",
    "Greedy",
    "LoadTable",
    "Orders",
    "Pairwise",
    "PrefixCuts",
    "Proportional",
    "Static",
    "Targets",
]


@dataclass(frozen=True)
class Targets:
    """Target shares of all particles.

    The engine computes new cuts for all domains at once, from the calculators' histograms, without gathering
    particles.

    Attributes:
        shares: one per calculator in the order of their domains, on any positive scale.
    """

    shares: npt.ArrayLike


@dataclass(frozen=True)
class Orders:
    """Particles to move between neighbours.

    The engine makes orders legal: it nets orders across the same cut, and no calculator gives more particles
    than it has.

    Attributes:
        moves: `(from, to, count)` tuples, with calculators numbered in the order of their domains.
    """

    moves: Iterable[tuple[int, int, int]]


class Balancer:
    """Base class of all balancers; custom balancers override `decide`.

    Attributes:
        smoothing: weight 0..1 of a calculator's previous speed against a new sample while speeds change; 0
            uses only the last frame. While samples differ only by noise, the previous speed has a larger
            weight.
        over: "system" balances each particle system separately, "all" the sum over systems.
        slabs_only: whether the balancer needs domains in a row: slabs along one axis, or stretches of a
            curve.
    """

    smoothing: float = 0.5
    over: Literal["system", "all"] = "system"
    slabs_only: ClassVar[bool] = False

    def __new__(cls, *given: Any, **named: Any) -> Self:
        """Raise if the class does not override `decide`."""
        if cls.decide is Balancer.decide:
            raise ArgumentError("balancer", cls.__name__, "a class with a method decide(load)")
        if (given or named) and cls.__init__ is object.__init__:
            raise TypeError(f"{cls.__name__}() takes no arguments")
        return super().__new__(cls)

    @abstractmethod
    def decide(self, load: LoadTable) -> Targets | Orders:
        """Decide how to balance one system after a frame. Called only on the manager.

        Args:
            load: the loads of all calculators.

        Returns:
            `Targets` with shares for all calculators, or `Orders` with particles to move between neighbours.
        """

    @property
    def _policy(self) -> _core.Policy:
        """This balancer as the engine's policy."""
        return _core.scripted_policy(self._name(), self._plan, *self._options())

    def _plan(self, table: _core.BalanceTable) -> _core.BalancePlan:
        """Call `decide`, and convert its result to the engine's plan."""
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


DEFAULT: Any = None
"""Placeholder for the default of a core balancer's option; the core defines defaults and allowed values."""


@dataclass_transform(kw_only_default=False)
class _Native(Balancer):
    """A balancer whose policy is implemented in the core: its annotations name the options."""

    _kind: ClassVar[str] = ""
    _known: ClassVar[dict[str, Option]] = {}

    def __init_subclass__(cls, **keywords: Any) -> None:
        """Read defaults and allowed values from the core, and build the constructor."""
        super().__init_subclass__(**keywords)
        if cls.__module__ != __name__:  # a user's subclass of a core balancer
            return
        cls._kind = cls.__name__
        described = {
            name: Option(kind, default, most) for name, kind, default, most in _core.policy_options(cls._kind)
        }
        declared = [name for name in cls.__annotations__ if name != "_"]
        assert set(declared) == set(described), f"{cls._kind}: options are {', '.join(described)}"
        cls._known = {name: described[name] for name in declared}
        required = cls._required()
        for name, option in cls._known.items():
            if name not in required:
                setattr(cls, name, None if option.kind == "powers" else option.default)
        cls.__init__ = _constructor(cls, declared, required)  # type: ignore[method-assign]

    @classmethod
    def _required(cls) -> list[str]:
        return [name for name, option in cls._known.items() if option.kind == "shares"]

    def __setattr__(self, name: str, given: Any) -> None:
        """Set an option; raise for unknown ones, except in users' subclasses."""
        known = [*self._known, "smoothing", "over"]
        if name not in known and type(self).__module__ == __name__:
            raise NotAssignableError(f"{type(self).__name__} has no option {name!r}{near(name, known)}")
        super().__setattr__(name, given)

    def decide(self, load: LoadTable) -> Targets | Orders:
        """Return the plan of the core's policy.

        Args:
            load: the loads of all calculators.

        Returns:
            `Targets` with shares for all calculators, or `Orders` with particles to move between neighbours.
        """
        plan = self._core_policy().plan(table_of(load))
        return Targets(plan.shares) if len(plan.shares) else Orders(plan.orders)

    @property
    def _policy(self) -> _core.Policy:
        """This balancer as the engine's policy; calls `decide` if a subclass overrides it."""
        return super()._policy if type(self).decide is not _Native.decide else self._core_policy()

    def _core_policy(self) -> _core.Policy:
        self._check()
        given = {name: getattr(self, name) for name in self._known}
        return _core.make_policy(
            self._kind, {name: value for name, value in given.items() if value is not None}
        )

    def _check(self) -> None:
        """Check the options again, because a script may have changed them since construction."""
        for name, option in self._known.items():
            setattr(self, name, option.checked(name, getattr(self, name)))

    def __repr__(self) -> str:
        """Show the call."""
        return self._core_policy().name


def _constructor(cls: type[_Native], names: list[str], required: list[str]) -> Callable[..., None]:
    """Build `__init__`: the first option may be positional, the others are keyword-only."""
    kinds = [Parameter.POSITIONAL_OR_KEYWORD, *(Parameter.KEYWORD_ONLY for _ in names[1:])]
    own = Parameter("self", Parameter.POSITIONAL_OR_KEYWORD)
    options = [
        Parameter(
            name,
            kind,
            default=Parameter.empty if name in required else getattr(cls, name),
            annotation=cls.__annotations__[name],
        )
        for name, kind in zip(names, kinds, strict=False)
    ]
    signature = Signature([own, *options])

    def init(self: _Native, *given: Any, **named: Any) -> None:
        """Set the options."""
        for name in named:
            if name not in names:
                raise TypeError(
                    f"{cls.__name__}() got an unexpected keyword argument {name!r}{near(name, names)}"
                )
        try:
            bound = signature.bind(self, *given, **named)
        except TypeError as error:
            raise TypeError(f"{cls.__name__}(): {error}") from None
        for name, value in bound.arguments.items():
            if name != "self":
                setattr(self, name, value)
        self._check()

    _, _, described = (getdoc(cls) or "").partition("Args:\n")
    init.__doc__ = "Set the options." + (f"\n\nArgs:\n{described}" if described else "")
    init.__name__, init.__qualname__ = "__init__", f"{cls.__qualname__}.__init__"
    setattr(init, "__signature__", signature)  # noqa: B010 (for introspection; `bind` above uses it)
    return init


class Static(_Native):
    """Cuts never move: the paper's static load balancing."""


class Pairwise(_Native):
    """The paper's dynamic load balancing (3.2.5): the manager balances pairs of neighbours.

    Pairs of neighbours are compared from left to right, starting alternately with the first and second pair.
    A pair whose times differ by more than the threshold divides its particles by processing power, and the
    next pair is skipped, so each calculator exchanges with only one neighbour. Times are particles divided by
    measured speed; differences within the measurement noise are ignored. Domains must lie in a row; bricks
    are not supported.

    Args:
        threshold: smallest difference in time that counts, as a fraction of the longer time.
        powers: each machine's power, one per calculator. As in the paper, the last frame's times are
            compared, and a pair divides its particles in proportion to its powers. None: use measured speeds.
        min_particles: smallest number of particles worth moving.
        smoothing: see `Balancer`.
        over: see `Balancer`.
    """

    slabs_only = True

    threshold: float = DEFAULT
    _: KW_ONLY
    powers: Sequence[float] | None = DEFAULT
    min_particles: int = DEFAULT
    smoothing: float = DEFAULT
    over: Literal["system", "all"] = DEFAULT


class Diffusive(_Native):
    """Neighbours balance among themselves (the paper's future work, section 6).

    Neighbours whose times differ exchange their loads, and part of the difference flows across the cut
    between them: first-order diffusion (G. Cybenko, 1989). The flow shrinks with the difference, so it needs
    no wide threshold and does not stall on a gradient as `Pairwise` can; but levelling an imbalance between
    distant calculators takes many frames. Domains must lie in a row.

    By default the manager detects which neighbours differ, pairs them, and collects the new cuts. With
    `manager=False` it takes no part in balancing: all neighbours compare their loads in each frame before
    they report; reports carry the new cuts, and the verdict distributes them to all ranks. Migration across
    cuts is then taken into account one frame later.

    Args:
        threshold: smallest difference in time that counts, as a fraction of the longer time.
        rate: fraction 0..1 of half the difference that flows; with 1, equal machines may oscillate.
        min_particles: smallest number of particles worth moving.
        manager: whether the manager detects which neighbours differ.
        smoothing: see `Balancer`.
        over: see `Balancer`.
    """

    slabs_only = True

    threshold: float = DEFAULT
    _: KW_ONLY
    rate: float = DEFAULT
    min_particles: int = DEFAULT
    manager: bool = DEFAULT
    smoothing: float = DEFAULT
    over: Literal["system", "all"] = DEFAULT


class PrefixCuts(_Native):
    """Moves all cuts at once, from global prefix sums along the axis; particles can skip several domains.

    Each calculator counts its particles in bins; the manager sums the bins and places the cuts to give each
    calculator its share. One evaluation is enough, wherever the imbalance is.

    Args:
        threshold: cuts move when the slowest calculator is this fraction above the mean.
        powers: each machine's power, one per calculator; other differences in measured time are then
            attributed to the places of particles, which suits particles that differ in cost. None: shares
            follow measured speeds, which suits machines that differ.
        min_particles: cuts stay while every calculator is within this many particles of its share.
        smoothing: see `Balancer`.
        over: see `Balancer`.
    """

    threshold: float = DEFAULT
    _: KW_ONLY
    powers: Sequence[float] | None = DEFAULT
    min_particles: int = DEFAULT
    smoothing: float = DEFAULT
    over: Literal["system", "all"] = DEFAULT


class Proportional(_Native):
    """Gives each calculator a fixed share of the particles, regardless of measured times.

    Args:
        powers: each calculator's share, on any scale; 0 leaves a calculator idle.
        threshold: cuts move when a calculator is off its share by more than this fraction of it and by at
            least `min_particles`.
        min_particles: see `threshold`.
        over: see `Balancer`.
    """

    powers: Sequence[float]
    _: KW_ONLY
    threshold: float = DEFAULT
    min_particles: int = DEFAULT
    over: Literal["system", "all"] = DEFAULT


class Bisection(_Native):
    """Compares the halves of all domains, then those of each half, and so on; balanced halves keep their cut.

    Where two halves differ, the cut between them and all cuts below it move at once.

    Args:
        threshold: smallest difference between two halves that counts, as a fraction of the longer time.
        min_particles: smallest number of particles worth moving.
        smoothing: see `Balancer`.
        over: see `Balancer`.
    """

    threshold: float = DEFAULT
    _: KW_ONLY
    min_particles: int = DEFAULT
    smoothing: float = DEFAULT
    over: Literal["system", "all"] = DEFAULT


class CostAware(_Native):
    """Moves all cuts at once like `PrefixCuts`, but only if moving costs less than it saves.

    Args:
        move_cost: cost of giving or taking a particle, in units of its actions' time per frame.
        horizon: number of frames for which a balance is expected to last.
        min_particles: cuts stay while every calculator is within this many particles of its share.
        smoothing: see `Balancer`.
        over: see `Balancer`.
    """

    move_cost: float = DEFAULT
    _: KW_ONLY
    horizon: float = DEFAULT
    min_particles: int = DEFAULT
    smoothing: float = DEFAULT
    over: Literal["system", "all"] = DEFAULT


class Greedy(_Native):
    """Moves particles repeatedly from the slowest calculator to its faster neighbour, in a row of domains.

    Args:
        threshold: smallest difference in time that counts, as a fraction of the longer time.
        min_particles: smallest number of particles worth moving.
        smoothing: see `Balancer`.
        over: see `Balancer`.
    """

    slabs_only = True
    threshold: float = DEFAULT
    _: KW_ONLY
    min_particles: int = DEFAULT
    smoothing: float = DEFAULT
    over: Literal["system", "all"] = DEFAULT


BALANCERS = tuple(_core.policy_names())
"""Names of the core's balancers."""


def one_of_each(powers: Sequence[float]) -> list[Balancer]:
    """Return one of each core balancer, with defaults, and `powers` where required."""
    return [kind(**dict.fromkeys(kind._required(), powers)) for kind in _kinds()]


def without_options() -> list[Balancer]:
    """Return one of each core balancer that needs no options."""
    return [kind() for kind in _kinds() if not kind._required()]


def by_name(text: str) -> Balancer:
    """Return the core balancer, with defaults, whose lower-case name starts with `text`."""
    kinds = {kind.__name__.lower(): kind for kind in _kinds() if not kind._required()}
    matches = [kind for name, kind in kinds.items() if text and name.startswith(text)]
    if len(matches) != 1:
        raise ArgumentError("balancer", text, ", ".join(kinds), known=kinds)
    return matches[0]()


def for_any_domains() -> str:
    """Return the names of the balancers that do not need domains in a row, for errors."""
    names = ", ".join(kind.__name__ for kind in _kinds() if not kind.slabs_only)
    return f"{names} or your own that returns Targets"


def _kinds() -> list[type[_Native]]:
    return [globals()[name] for name in BALANCERS]


def __getattr__(name: str) -> Any:
    raise missing("motes.balance", name, __all__)


def __dir__() -> list[str]:
    return [*__all__]


def policy_of(balancer: Balancer) -> _core.Policy:
    """Return the engine's policy for a balancer; for use elsewhere in the package."""
    return balancer._policy


def _shares(where: str, targets: Targets) -> list[float]:
    allowed = "numbers, one per calculator"
    shares = arguments.floats(f"{where}: shares", targets.shares, np.float64, allowed)
    if shares.ndim != 1 or shares.size == 0:
        raise ArgumentError(f"{where}: shares", targets.shares, allowed)
    return [float(share) for share in shares]


def _moves(where: str, orders: Orders) -> list[tuple[int, int, int]]:
    allowed = "a list of (from, to, count), integers >= 0"
    moves = []
    try:  # the list and its numbers can be any objects
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
