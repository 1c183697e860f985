"""Balancing policies as pure functions: each of the paper's rules (3.2.5) holds for any loads."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import motes
from motes import ArgumentError, Diffusive, Orders, Pairwise, PrefixCuts, Proportional, Static, Targets, _core
from motes.load_table import LoadTable

many = settings(derandomize=True, deadline=None, max_examples=100)

counts = st.one_of(st.just(0), st.integers(0, 500), st.integers(0, 10**10))
speeds = st.one_of(st.just(0.0), st.floats(1.0, 1e9))
coordinates = st.lists(
    st.one_of(
        st.floats(-1e6, 1e6, width=32), st.sampled_from([0.0, 1.0, -0.0, math.nan, math.inf, -math.inf])
    ),
    max_size=200,
)


@st.composite
def tables(draw: Any, least: int = 1) -> _core.BalanceTable:
    particles = draw(st.lists(counts, min_size=least, max_size=12))
    speed = [draw(speeds) for _ in particles]
    seconds = [n / v if v else 0.0 for n, v in zip(particles, speed, strict=True)]
    cuts = sorted(draw(st.floats(-1e3, 1e3, width=32)) for _ in particles[1:])
    error = draw(st.one_of(st.just([0.0] * len(speed)), st.just([draw(st.floats(0, 0.3)) for _ in speed])))
    return _core.BalanceTable(3, draw(st.integers(0, 9)), "snow", particles, seconds, speed, cuts, error)


def table(particles: list[int], speed: list[float] | None = None, evaluation: int = 0) -> _core.BalanceTable:
    n = len(particles)
    return _core.BalanceTable(
        12, evaluation, "snow", particles, [0.0] * n, speed or [1e6] * n, np.arange(1, n)
    )


def obeyed(load: _core.BalanceTable, orders: list[tuple[int, int, int]]) -> np.ndarray:
    after = load.particles.astype(object)
    for source, to, count in orders:
        after[source] -= count
        after[to] += count
    return after


# --- the paper's rules


@many
@given(tables(), st.floats(0, 1), st.integers(0, 1000))
def test_pairwise_obeys_the_paper(load: _core.BalanceTable, threshold: float, least: int) -> None:
    plan = Pairwise(threshold, min_particles=least).policy.plan(load)
    power = load.complete_speed
    times = load.particles / power
    n = len(power)
    # Neighbours only; each process only sends or receives, with one neighbour.
    busy = [process for source, to, _ in plan.orders for process in (source, to)]
    assert all(abs(source - to) == 1 for source, to, _ in plan.orders)
    assert len(busy) == len(set(busy))
    # The first pair alternates; pairs from left to right; the pair after one that balances is left out.
    first = load.evaluation % 2 if n > 2 else 0
    assert list(plan.evaluated[:1]) == ([first] if first + 1 < n else [])
    ordered = {min(source, to) for source, to, _ in plan.orders}
    for one, following in pairwise(plan.evaluated):
        assert following - one == (2 if one in ordered else 1)
    if len(plan.evaluated):
        last = plan.evaluated[-1]
        assert last + (2 if last in ordered else 1) + 1 >= n
    assert ordered <= set(plan.evaluated)
    for cut in plan.evaluated:
        left, right = times[cut], times[cut + 1]
        both = int(load.particles[cut]) + int(load.particles[cut + 1])
        wanted = both * (power[cut] / (power[cut] + power[cut + 1]))
        moved = abs(int(load.particles[cut]) - wanted)
        apart = max(threshold, 3 * math.hypot(load.error[cut], load.error[cut + 1]))
        if cut in ordered:  # threshold, noise, minimum; then the load is in proportion to processing power
            source, to, count = next(order for order in plan.orders if min(order[:2]) == cut)
            assert abs(left - right) > apart * max(left, right)
            assert count >= least
            assert times[source] > times[to]
            after = obeyed(load, [(source, to, count)])
            assert abs(after[cut] - wanted) <= 0.5 + 1e-9 * both
        else:
            assert abs(left - right) <= apart * max(left, right) or moved < max(least, 1) + 0.5


@many
@given(tables(), st.sampled_from([Pairwise(0), Diffusive(0, rate=1, min_particles=0), Diffusive()]))
def test_orders_keep_the_total_and_never_take_more_than_there_is(
    load: _core.BalanceTable, balancer: motes.Balancer
) -> None:
    plan = balancer.policy.plan(load)
    after = obeyed(load, plan.orders)
    assert sum(after) == sum(load.particles.astype(object))
    assert min(after) >= 0
    assert all(count > 0 for _, _, count in plan.orders)
    assert _core.legal_plan(plan, load, "it").orders == plan.orders


@many
@given(tables(2), st.floats(0, 1))
def test_diffusion_flows_from_slow_to_fast_and_never_past_balance(
    load: _core.BalanceTable, rate: float
) -> None:
    known = _core.BalanceTable(
        0, 0, "s", load.particles, load.seconds, np.maximum(load.speed, 1), load.cuts, load.error
    )
    times = known.particles / known.speed
    for source, to, count in Diffusive(0, rate=rate, min_particles=0).policy.plan(known).orders:
        noise = 3 * math.hypot(known.error[source], known.error[to])
        assert times[source] - times[to] > noise * times[source]
        slower = min(known.speed[source], known.speed[to])
        assert count <= rate * (times[source] - times[to]) * slower / 2 + 0.5 + 1e-6 * count


@many
@given(tables(2))
def test_one_pass_over_pairs_never_makes_the_slowest_slower(load: _core.BalanceTable) -> None:
    power = load.complete_speed
    after = obeyed(load, Pairwise(0.1).policy.plan(load).orders).astype(float)
    slack = 1 / power.min()  # orders are whole particles
    assert max(after / power) <= max(load.particles / power) + slack


# --- shares


@many
@given(tables(2), st.booleans())
def test_prefix_cuts_ask_for_shares_by_speed(load: _core.BalanceTable, known: bool) -> None:
    powers = [float(c + 1) for c in range(len(load.particles))] if known else None
    plan = PrefixCuts(0.2, powers=powers, min_particles=0).policy.plan(load)
    seconds = load.particles / load.complete_speed
    above = seconds * len(seconds) / max(seconds.sum(), 1e-300) - 1
    noise = math.sqrt(9 + 2 * math.log(len(seconds))) * load.error
    assert (len(plan.shares) > 0) == bool((above > np.maximum(0.2, noise)).any())
    if len(plan.shares):
        np.testing.assert_array_equal(plan.shares, powers or load.complete_speed)
        legal = _core.legal_plan(plan, load, "it")
        assert legal.shares.sum() == pytest.approx(1)
        if known:
            measured = load.speed > 0
            np.testing.assert_allclose(
                plan.costs[measured], np.asarray(powers)[measured] / load.speed[measured]
            )


@many
@given(tables(), st.data())
def test_any_plan_becomes_legal(load: _core.BalanceTable, data: st.DataObject) -> None:
    n = len(load.particles)
    pairs = [(c, c + d) for c in range(n) for d in (-1, 1) if 0 <= c + d < n]
    if not pairs:
        return
    moves = data.draw(st.lists(st.tuples(st.sampled_from(pairs), st.integers(0, 2**64 - 1)), max_size=30))
    plan = _core.BalancePlan([(*pair, count) for pair, count in moves], [], [])
    legal = _core.legal_plan(plan, load, "it")
    given_away = np.zeros(n, object)
    over = [min(source, to) for source, to, _ in legal.orders]
    assert over == sorted(set(over)), "one order a cut, in their order"
    for source, _, count in legal.orders:
        given_away[source] += count
    assert (given_away <= load.particles.astype(object)).all()
    net = np.zeros(n, object)
    for (source, to), count in moves:
        net[min(source, to)] += min(count, 2**64 - 1) if to > source else -count
    for source, to, _ in legal.orders:
        if sum(count for _, count in moves) < 2**64:
            assert (net[min(source, to)] > 0) == (to > source)


# --- cuts


@many
@given(coordinates, st.integers(0, 250), st.booleans())
def test_gifts_never_exceed_the_order_and_fall_short_only_by_ties(
    places: list[float], wanted: int, to_left: bool
) -> None:
    x = np.asarray(places, np.float32)
    low, high = -math.inf, math.inf
    cut, count = (_core.give_left if to_left else _core.give_right)(x, wanted, low, high)
    inside = np.sort(x[(x >= low) & (x < high)])
    beyond = inside[inside < cut] if to_left else inside[inside >= cut]
    assert count == len(beyond) <= wanted
    if len(np.unique(inside)) == len(inside):
        assert count == min(wanted, len(inside))
    rest = inside[inside >= cut] if to_left else inside[inside < cut]
    if len(rest):  # the next position would move too many
        place = rest[0] if to_left else rest[-1]
        assert count + (rest == place).sum() > wanted


@many
@given(coordinates, st.integers(1, 40))
def test_histograms_count_each_finite_particle_once(places: list[float], bins: int) -> None:
    x = np.asarray(places, np.float32)
    edges, histogram = _core.histogram(x, bins)
    finite = x[np.isfinite(x)]
    assert histogram.sum() == len(finite)
    if not len(finite):
        assert len(edges) == 0
        return
    assert len(edges) == len(histogram) + 1 <= bins + 1
    assert (edges[0], edges[-1]) == (finite.min(), finite.max())
    assert (np.diff(edges) >= 0).all()
    for low, high, count in zip(edges[:-2], edges[1:-1], histogram[:-1], strict=True):
        assert ((finite >= low) & (finite < high)).sum() == count


@many
@given(st.lists(coordinates, min_size=1, max_size=6), st.data())
def test_cuts_from_prefix_sums_ascend_and_are_within_a_bin_of_ideal(
    domains: list[list[float]], data: st.DataObject
) -> None:
    n = len(domains)
    shares = np.array(data.draw(st.lists(st.integers(0, 4), min_size=n, max_size=n)), float)
    shares[0] += 1
    # Calculators in a row, as after an exchange: what is in one domain is below the next.
    kept = [np.asarray(d, np.float32) for d in domains]
    finite = [d[np.isfinite(d)] / np.float32(4e6) + np.float32(c) for c, d in enumerate(kept)]
    histograms = [_core.histogram(d, 16) for d in finite]
    before = np.arange(n - 1, dtype=np.float32) + np.float32(0.5)
    cuts = _core.prefix_cuts(histograms, [], shares, before)
    assert len(cuts) == n - 1
    assert (np.diff(cuts) >= 0).all()
    together = np.concatenate(finite)
    if not len(together):
        np.testing.assert_array_equal(cuts, before)
        return
    widest = max(int(h.max(initial=0)) for _, h in histograms)
    ideal = len(together) * np.cumsum(shares)[:-1] / shares.sum()
    for cut, wanted in zip(cuts, ideal, strict=True):
        assert abs((together < cut).sum() - wanted) <= widest + 1e-6


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
        again = eval(repr(balancer), vars(motes))
        assert repr(again) == repr(balancer) == balancer.policy.name
        assert again.policy.moves is (type(balancer) is not Static)
        assert again.policy.decentralised is (type(balancer) is Diffusive)
        assert again.policy.unmanaged is ("manager=False" in repr(balancer))
        assert again.policy.over_all is (balancer.over == "all")


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
        lambda: motes.Balancer().policy,
    ],
)
def test_balancers_refuse_bad_arguments(wrong: Any) -> None:
    with pytest.raises(ArgumentError):
        wrong()


def test_a_balancer_that_cannot_decide_is_refused_where_it_is_made() -> None:
    class Hasty(motes.Balancer):
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
            balancer.policy.check(3)
        with pytest.raises(ArgumentError, match=type(balancer).__name__):
            balancer.policy.plan(table([1, 2, 3]))
        balancer.policy.check(2)


class BySpeed(motes.Balancer):
    """A user's balancer."""

    def __init__(self) -> None:
        self.seen: list[LoadTable] = []

    def decide(self, load: LoadTable) -> Targets:
        self.seen.append(load)
        return Targets(load.powers)


def test_a_users_balancer_sees_records_and_says_shares() -> None:
    balancer = BySpeed()
    policy = balancer.policy
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
    class Odd(motes.Balancer):
        smoothing = 0.25
        over = "all"

        def decide(self, load: LoadTable) -> Any:
            return value() if callable(value) else value

    policy = Odd().policy
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


@pytest.mark.parametrize("name", ["Static", "Pairwise", "Diffusive", "PrefixCuts", "Proportional"])
def test_options_that_are_not_given_are_the_core_s(name: str) -> None:
    """The driver takes a balancer by its name, and its options from the core; scripts see them in Python."""
    ours = Proportional([1.0, 2.0]) if name == "Proportional" else getattr(motes, name)()
    core = _core.policy_named(f"{name}(powers=[1, 2])" if name == "Proportional" else name)
    assert repr(ours) == core.name
    assert (ours.policy.over_all, ours.policy.smoothing) == (core.over_all, core.smoothing)
