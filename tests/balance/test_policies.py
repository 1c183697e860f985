"""Balancing policies as pure functions: each of the paper's rules (3.2.5) holds for any loads."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import motes
from motes import ArgumentError, _core
from motes.balance import Diffusive, Orders, Pairwise, PrefixCuts, Proportional, Static, Targets
from motes.balance._load_table import LoadTable


def table(particles: list[int], speed: list[float] | None = None, evaluation: int = 0) -> _core.BalanceTable:
    n = len(particles)
    return _core.BalanceTable(
        12, evaluation, "snow", particles, [0.0] * n, speed or [1e6] * n, np.arange(1, n)
    )


# --- the paper's rules


# --- shares


# --- cuts


def test_more_costs_get_less_place() -> None:
    flat = (np.linspace(0, 1, 65, dtype=np.float32), np.full(64, 1000))
    second = (np.linspace(1, 2, 65, dtype=np.float32), np.full(64, 1000))
    assert _core.prefix_cuts([flat, second], [], [1, 1], [1])[0] == pytest.approx(1, abs=1e-6)
    assert _core.prefix_cuts([flat, second], [1, 3], [1, 1], [1])[0] == pytest.approx(4 / 3, abs=1e-6)
    assert _core.prefix_cuts([flat, second], [], [3, 1], [1])[0] == pytest.approx(1.5, abs=1e-6)


# --- balancers as users write them


def test_balancers_show_their_call() -> None:
    assert repr(Static()) == "Static()"
    assert repr(Pairwise(0.05)) == "Pairwise(threshold=0.05, min_particles=64, smoothing=0.5)"
    assert repr(Diffusive(over="all")).endswith('smoothing=0.5, over="all")')
    for balancer in (
        Static(),
        Pairwise(0.2, min_particles=5, smoothing=0),
        Diffusive(rate=0.25),
        Diffusive(rate=0.25, manager=False, over="all"),
        PrefixCuts(powers=[1, 2.5]),
        PrefixCuts(over="all"),
        Proportional([2, 1], min_particles=3),
    ):
        again = eval(repr(balancer), vars(motes.balance))
        assert repr(again) == repr(balancer) == balancer._policy.name
        assert again._policy.moves is (type(balancer) is not Static)
        assert again._policy.decentralised is (type(balancer) is Diffusive)
        assert again._policy.unmanaged is ("manager=False" in repr(balancer))
        assert again._policy.over_all is (balancer.over == "all")


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Pairwise(-0.1),
        lambda: Pairwise(math.nan),
        lambda: Pairwise(min_particles=-1),
        lambda: Pairwise(min_particles=1.5),
        lambda: Pairwise(smoothing=1.1),
        lambda: Pairwise(over="both"),
        lambda: Diffusive(rate=1.5),
        lambda: Diffusive(threshold="much"),
        lambda: Diffusive(manager="no"),
        lambda: PrefixCuts(powers=[]),
        lambda: PrefixCuts(powers=[1, 0]),
        lambda: PrefixCuts(powers=[1, math.nan]),
        lambda: PrefixCuts(powers="fast"),
        lambda: Proportional([0, 0]),
        lambda: Proportional([1, -1]),
        lambda: Proportional(3),
        lambda: motes.balance.Balancer()._policy,
    ],
)
def test_balancers_refuse_bad_arguments(wrong: Any) -> None:
    with pytest.raises(ArgumentError):
        wrong()


def test_a_balancer_that_cannot_decide_is_refused_where_it_is_made() -> None:
    class Hasty(motes.balance.Balancer):
        def decid(self, load: LoadTable) -> Targets:
            return Targets(load.powers)

    with pytest.raises(ArgumentError, match=r"a class with a method decide\(load\), got 'Hasty'"):
        Hasty()

    class Careful(Hasty):
        decide = Hasty.decid

    Careful()
    with pytest.raises(TypeError, match=r"Careful\(\) takes no arguments"):
        Careful(3)


def test_fixed_powers_must_fit_the_calculators() -> None:
    for balancer in (Proportional([1, 2]), PrefixCuts(powers=[1, 2])):
        with pytest.raises(ArgumentError, match=r"powers must be 3 numbers, one per calculator, got 2"):
            balancer._policy.check(3)
        with pytest.raises(ArgumentError, match=type(balancer).__name__):
            balancer._policy.plan(table([1, 2, 3]))
        balancer._policy.check(2)


class BySpeed(motes.balance.Balancer):
    """A user-defined balancer."""

    def __init__(self) -> None:
        self.seen: list[LoadTable] = []

    def decide(self, load: LoadTable) -> Targets:
        self.seen.append(load)
        return Targets(load.powers)


def test_a_users_balancer_sees_records_and_says_shares() -> None:
    balancer = BySpeed()
    policy = balancer._policy
    assert (policy.name, policy.moves, policy.decentralised, policy.over_all) == (
        "BySpeed()",
        True,
        False,
        False,
    )
    plan = policy.plan(table([10, 20, 30], [1e6, 0, 3e6], evaluation=4))
    np.testing.assert_allclose(plan.shares, [1 / 6, 2 / 6, 3 / 6])
    (load,) = balancer.seen
    assert (load.frame, load.evaluation, load.system, len(load)) == (12, 4, "snow", 3)
    records = np.asarray(load)
    assert records.dtype.names == ("particles", "seconds", "speed", "low", "high")
    assert list(records["particles"]) == [10, 20, 30] == list(load.particles)
    assert list(load["low"]) == [-math.inf, 1, 2] and load[2]["high"] == math.inf
    assert list(load.cuts) == [1, 2] and list(load.speed) == [1e6, 0, 3e6]
    assert list(load.error) == [0, 0, 0]
    assert load.imbalance == pytest.approx(1.0)
    with pytest.raises(ValueError):
        load.speed[0] = 1


def answer(value: Any) -> _core.BalancePlan:
    class Odd(motes.balance.Balancer):
        smoothing = 0.25
        over = "all"

        def decide(self, load: LoadTable) -> Any:
            return value() if callable(value) else value

    policy = Odd()._policy
    assert policy.over_all
    return policy.plan(table([100, 100, 100]))


def test_a_users_orders_become_legal() -> None:
    assert answer(Orders([(np.int64(0), 1.0, np.float32(5))])).orders == [(0, 1, 5)]
    assert answer(Orders([(0, 1, 500), (1, 0, 20), (2, 1, 7)])).orders == [(0, 1, 100), (2, 1, 7)]
    assert answer(Orders(np.array([[0, 1, 5]]))).orders == [(0, 1, 5)]
    assert answer(Orders([])).orders == []
    np.testing.assert_allclose(answer(Targets(np.array([2, 1, 1]))).shares, [0.5, 0.25, 0.25])


@pytest.mark.parametrize(
    "value",
    [
        None,
        [1, 1, 1],
        Targets([1, 2]),
        Targets([1, math.nan, 1]),
        Targets([1, math.inf, 1]),
        Targets([1, -1, 1]),
        Targets([0, 0, 0]),
        Targets([[1, 1, 1]]),
        Targets(3),
        Targets("abc"),
        Targets([]),
        Orders([(0, 2, 5)]),
        Orders([(0, 3, 5)]),
        Orders([(0, 1)]),
        Orders([(0, 1, -5)]),
        Orders([(0, 1, 0.5)]),
        Orders([(0, 1, math.nan)]),
        Orders([(0, 1, 2**64)]),
        Orders([(-1, 0, 5)]),
        Orders(5),
        Orders([("a", "b", "c")]),
        Orders([(0, 1, np.ma.masked)]),
        Orders([(0, 1, 1j)]),
        Orders(np.array([[0, 1, 5j]])),
        Orders(1 / n for n in (1, 0)),
    ],
)
def test_what_a_user_may_not_answer_names_policy_and_frame(value: Any) -> None:
    with pytest.raises(ArgumentError, match=r"Odd\(\), frame 12: .* must be "):
        answer(value)


def test_a_users_exception_comes_through_and_says_where() -> None:
    def fail() -> None:
        raise KeyError("no such machine")

    with pytest.raises(KeyError) as caught:
        answer(fail)
    assert caught.value.__notes__ == ["in the balancer Odd(), frame 12, system 'snow'"]


def test_natives_decide_as_their_policies_do() -> None:
    load = LoadTable(table([100, 0, 500]))
    assert list(Pairwise(min_particles=1).decide(load).moves) == [(0, 1, 50)]  # type: ignore[union-attr]
    np.testing.assert_array_equal(PrefixCuts(min_particles=1).decide(load).shares, [1e6] * 3)  # type: ignore[union-attr]
    assert list(Static().decide(load).moves) == []  # type: ignore[union-attr]


@pytest.mark.parametrize("name", motes.balance.BALANCERS)
def test_options_that_are_not_given_are_the_core_s(name: str) -> None:
    """The driver uses the core's defaults, scripts those of Python: both must agree."""
    ours = Proportional([1.0, 2.0]) if name == "Proportional" else getattr(motes.balance, name)()
    core = _core.policy_named(f"{name}(powers=[1, 2])" if name == "Proportional" else name)
    assert repr(ours) == core.name
    assert (ours._policy.over_all, ours._policy.smoothing) == (core.over_all, core.smoothing)
