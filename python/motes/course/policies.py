"""Evenings 3 to 6: policies that play games."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..replay.history import Floats
from ._games import Game, Hidden, Result, Seen, machine
from ._secret import Secret
from .asking import Asked
from .grades import Part

__all__ = ["GAMES", "graded", "practice"]

FRAMES = 40


def _still(secret: Secret, frames: int = FRAMES) -> list[float]:
    return [secret.uniform(0.15, 0.85)] * frames


def _drift(secret: Secret, frames: int = FRAMES) -> list[float]:
    start, end = secret.shuffled([secret.uniform(0.12, 0.25), secret.uniform(0.75, 0.88)])
    return [start + (end - start) * frame / (frames - 1) for frame in range(frames)]


def _jumps(secret: Secret, low: int, high: int, frames: int = FRAMES) -> list[float]:
    places: list[float] = []
    spots = [0.14, 0.5, 0.86]
    while len(places) < frames:
        here = [spot for spot in spots if not places or abs(spot - places[-1]) > 0.1]
        places += [secret.one_of(here)] * secret.whole(low, high)
    return places[:frames]


def _steady(calculators: int, frames: int = FRAMES) -> Floats:
    return np.ones((frames, calculators))


def _slow_from(frame: int, who: int, part: float, calculators: int) -> Floats:
    slow = _steady(calculators)
    slow[frame:, who] = part
    return slow


def _measured(secret: Secret, calculators: int, deviation: float) -> Floats:
    """Return nearly normal noise, in which 3 of 100 samples take up to twice as long."""
    noise = secret.noise((FRAMES, calculators), deviation)
    for row in noise:
        for c in range(calculators):
            if secret.uniform() < 0.03:
                row[c] += secret.uniform(0.5, 1.0)
    return np.maximum(noise, -0.5)


def _third(key: str) -> list[Game]:
    """Make games of equal machines, a noisy clock, and at most one real change."""
    count, cheap = 8, machine([1.0] * 8, 2e-7)
    games = []
    for name in ("nothing happens", "a burst", "a machine slows down"):
        secret = Secret(key, f"3 {name}")
        noise = _measured(secret, count, 0.06)
        frame, slow, part = secret.whole(10, 18), _steady(count), 0.0
        if name == "a burst":
            part = 0.5
        elif name == "a machine slows down":
            slow = _slow_from(frame, secret.whole(0, count - 1), 0.45, count)
        load = Hidden(_still(secret), part=part, slow=slow, born=frame)
        games.append(Game(name, load, cheap, noise))
    return games


def _fourth(key: str) -> list[Game]:
    """Make games of machines with unknown speeds, some of which have no particles at first."""
    games = []
    for name in ("an even load", "a crowd that drifts", "a machine that gets slower"):
        secret = Secret(key, f"4 {name}")
        speeds = secret.shuffled([1.0, 1.0, 0.8, 0.5, 0.4, 0.25])
        noise = _measured(secret, 6, 0.04)
        slow, places, part = _steady(6), _still(secret), 0.0
        if name == "a crowd that drifts":
            places, part = _drift(secret), 1.0
        elif name == "a machine that gets slower":
            slow = _slow_from(secret.whole(12, 18), speeds.index(0.8), 0.35, 6)
        load = Hidden(places, part=part, slow=slow, width=0.12)
        games.append(Game(name, load, machine(speeds, 5e-8), noise))
    return games


def _fifth(key: str) -> list[Game]:
    """Make games in which moving particles is cheap, and games in which it is expensive."""
    games = []
    for network, move_s in (("fast network", 1e-8), ("slow network", 2e-6)):
        for name in ("a crowd that stays", "a crowd that jumps", "a crowd near the end"):
            secret = Secret(key, f"5 {name} {network}")
            places = _jumps(secret, 3, 5) if name == "a crowd that jumps" else _still(secret)
            born = {"a crowd that stays": secret.whole(3, 8), "a crowd that jumps": 0}.get(name)
            load = Hidden(
                places,
                part=0.6,
                slow=_steady(6),
                born=FRAMES - secret.whole(5, 7) if born is None else born,
            )
            options = {"move_s": move_s, "frames": FRAMES}
            games.append(Game(f"{name}, {network}", load, machine([1.0] * 6, move_s), options=options))
    return games


def _sixth(key: str) -> list[Game]:
    """Make games of all kinds."""
    games = []
    for kind in ("equal machines", "two kinds of machines"):
        for name in ("a burst", "a crowd that drifts", "a crowd that jumps", "a machine slows down"):
            secret = Secret(key, f"6 {name} {kind}")
            speeds = [1.0] * 8 if kind == "equal machines" else secret.shuffled([1.0] * 4 + [0.4] * 4)
            frame = secret.whole(8, 15)
            slow = 1 - np.abs(secret.noise((FRAMES, 8), 0.02))
            places, part, born = _still(secret), 0.0, 0
            if name == "a burst":
                part, born = 0.5, frame
            elif name == "a crowd that drifts":
                places, part = _drift(secret), 0.6
            elif name == "a crowd that jumps":
                places, part = _jumps(secret, 6, 12), 0.5
            else:
                slow[frame:, secret.whole(0, 7)] *= 0.4
            load = Hidden(places, part=part, slow=slow, born=born)
            games.append(Game(f"{name}, {kind}", load, machine(speeds, 4e-7), raw=False))
    return games


GAMES: dict[int, Callable[[str], list[Game]]] = {3: _third, 4: _fourth, 5: _fifth, 6: _sixth}
"""The games of each evening, from a key."""


def practice(evening: int, key: str) -> Game:
    """Return the game whose log an evening's notebook reads: like the hidden ones, but not one of them."""
    secret = Secret(key, f"practice {evening}")
    if evening in GAMES:
        games = GAMES[evening](f"{key}\npractice")
        return games[{3: 2, 4: 1, 5: 1, 6: 5}[evening]]
    speeds = secret.shuffled([1.0, 1.0, 0.9, 0.9, 0.8, 0.5])
    noise = np.maximum(secret.noise((FRAMES, 6), 0.02), -0.1)
    load = Hidden(_still(secret), part=0.4, slow=_steady(6), width=0.15)
    return Game("practice", load, machine(speeds, 1e-7), noise)


def graded(asked: Asked, games: Sequence[Game]) -> list[Part]:
    """Let a submission play each game, and return points and hints."""
    return [_part(game.play(_policy(asked, game))) for game in games]


def _policy(asked: Asked, game: Game) -> Seen:
    smoothing = asked.make(game.options)
    return Seen(asked.decide, raw=game.raw, noise=game.noise, smoothing=smoothing)


def _part(result: Result) -> Part:
    return Part(result.name, result.points, _hint(result), result)


def _hint(result: Result) -> str:
    """Return a hint about what to look at; "" from 90 points on."""
    moved, enough = result.moved, result.full_moved
    if result.points >= 90:
        return ""
    if result.static and moved:
        return f"static cuts are best here, but you moved {moved:,} particles: when is moving worth it?"
    if not moved:
        return "you moved nothing, but moving pays here"
    if moved > 2 * enough:
        return (
            f"you moved {moved:,} particles, but {enough:,} are enough: do you follow noise or brief changes?"
        )
    if moved < 0.6 * enough:
        return f"you moved {moved:,} particles, but {enough:,} are needed: do you move too few, or too late?"
    return "you move about as much as needed: are you late, or are your shares off?"
