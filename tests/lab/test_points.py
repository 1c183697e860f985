"""Points are calibrated per key: the course's solutions pass, and policies that look at nothing do not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from motes.balance import Balancer, LoadTable, Orders, Targets
from motes_lab.course import policies
from motes_lab.course._texts import own

Answer = Targets | Orders
STAY = Orders([])


class Blind(Balancer):
    """A policy of one line."""

    def __init__(self, decide: Callable[[LoadTable], Answer]) -> None:
        self._decide = decide

    def decide(self, load: LoadTable) -> Answer:
        return self._decide(load)


def even(load: LoadTable) -> Answer:
    return Targets(np.ones(len(load)))


def powers(load: LoadTable) -> Answer:
    return Targets(load.powers)


BLIND: dict[str, Callable[[LoadTable], Answer]] = {
    "never": lambda load: STAY,
    "even": even,
    "powers": powers,
    "a ramp": lambda load: Targets(1.0 + np.arange(len(load))),
    "the same again": lambda load: Targets(load.particles + 1.0),
    "fewer to the full": lambda load: Targets(1.0 / (load.particles + 1.0)),
    "less to the late": lambda load: Targets(1.0 / np.maximum(load.seconds, 1e-9)),
    "roots": lambda load: Targets(np.sqrt(load.powers)),
    "in between": lambda load: Targets(load.particles + load.particles.mean()),
    "even, every second": lambda load: even(load) if load.frame % 2 else STAY,
    "even, every sixth": lambda load: even(load) if load.frame % 6 == 3 else STAY,
    "powers, every ninth": lambda load: powers(load) if load.frame % 9 == 4 else STAY,
    "powers, every twelfth": lambda load: powers(load) if load.frame % 12 == 5 else STAY,
    "powers, once": lambda load: powers(load) if load.frame == 16 else STAY,
    "even, then never": lambda load: even(load) if load.frame < 15 else STAY,
    "powers, in the end": lambda load: powers(load) if load.frame > 25 else STAY,
    "even if full": lambda load: even(load) if load.particles.max() > 1.4 * load.particles.mean() else STAY,
    "powers if full": lambda load: (
        powers(load) if load.particles.max() > 1.6 * load.particles.mean() else STAY
    ),
    "powers if late": lambda load: powers(load) if load.seconds.max() > 1.35 * load.seconds.mean() else STAY,
    "powers if uneven": lambda load: powers(load) if load.imbalance > 1.25 else STAY,
}
"""Policies that look at nothing, or at one number; not those with which the games are calibrated."""


def check(evening: int, key: str) -> None:
    games = policies.GAMES[evening](key)
    scores = {
        name: float(np.mean([game.play(game.seen(Blind(decide))).points for game in games]))
        for name, decide in BLIND.items()
    }
    assert max(scores.values()) < 40, {name: score for name, score in scores.items() if score >= 40}
    solved = [game.play(game.seen(own(evening)(**game.options))).points for game in games]
    assert 70 <= np.mean(solved) <= 100, solved


@pytest.mark.timeout(600)
@pytest.mark.parametrize("key", ["our secret"])
@pytest.mark.parametrize("evening", policies.GAMES)
def test_solutions_pass_and_blind_policies_do_not(evening: int, key: str) -> None:
    check(evening, key)


@pytest.mark.slow
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("tens", range(20))
@pytest.mark.parametrize("evening", policies.GAMES)
def test_solutions_pass_and_blind_policies_do_not_with_200_keys(evening: int, tens: int) -> None:
    for key in range(10 * tens, 10 * tens + 10):
        check(evening, f"teacher {key}")


def test_what_a_policy_knows_of_one_network_is_not_enough() -> None:
    for game in policies.GAMES[5]("network"):
        still = game.options["move_s"] > 5e-7
        assert game.play(game.seen(Blind(BLIND["never" if still else "even"]))).points == 0


def test_points_run_from_the_best_simple_policy_to_the_best_known() -> None:
    game = policies.game(3, 0, "points")
    zero_s, full_s, best = game.bounds
    assert game.is_fair and zero_s == min(game.simple_s()) > 1.1 * game.own.seconds
    assert best.seconds <= full_s <= game.own.seconds and best.seconds >= best.optimum_s
    assert game.play(game.seen(own(3)())).points == pytest.approx(80, abs=0.1)
