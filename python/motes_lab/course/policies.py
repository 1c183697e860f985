"""Evenings 3 to 6: policies that play games."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import count

import numpy as np

from motes.replay.history import Floats

from ._games import Game, Hidden, Result, Seen, machine
from ._secret import Secret
from .asking import Asked
from .grades import Part

__all__ = ["GAMES", "MADE", "game", "graded", "practice"]

FRAMES = 144
"""Frames of a game: so many that luck evens out."""


def _measured(secret: Secret, calculators: int, deviation: float) -> Floats:
    """Draw relative errors of seconds: nearly normal, but one in ten far too long, and one far too short."""
    noise = secret.noise((FRAMES, calculators), deviation)
    for row in noise:
        for c in range(calculators):
            kind = secret.uniform()
            if kind < 0.1:
                row[c] = secret.uniform(1.8, 3.0)
            elif kind < 0.2:
                row[c] = -secret.uniform(0.45, 0.65)
    return np.maximum(noise, -0.8)


def _changing(secret: Secret, speeds: Sequence[float], part: float) -> Floats:
    """Slow down one of the fast machines after another, each for some 25 frames."""
    slow = np.ones((FRAMES, len(speeds)))
    fast = [machine for machine, speed in enumerate(speeds) if speed > 0.6]
    start, who = secret.whole(10, 22), -1
    while start < FRAMES:
        end = start + secret.whole(18, 32)
        who = secret.one_of([machine for machine in fast if machine != who])
        slow[start:end, who] = part
        start = end
    return slow


def _resting(secret: Secret, jumps: tuple[int, int]) -> list[float]:
    """Draw the places of a crowd that jumps every few frames, rests for a while, jumps again, and so on."""
    places: list[float] = []
    while len(places) < FRAMES:
        for still in (False, True):
            end = len(places) + secret.whole(*(24, 34) if still else (14, 22))
            while len(places) < end:
                place = secret.uniform(0.07, 0.93)
                while places and abs(place - places[-1]) < 0.2:
                    place = secret.uniform(0.07, 0.93)
                places += [place] * (end - len(places) if still else secret.whole(*jumps))
    return places[:FRAMES]


def _third(secret: Secret, name: str) -> Game:
    """Make a game of equal machines and a noisy clock, in which other machines are slow now and then."""
    noise, speeds = _measured(secret, 8, 0.06), [1.0] * 8
    crowd = 0.5 if "burst" in name else 0.0
    slow = _changing(secret, speeds, 0.3 if "very" in name else 0.4)
    place = [secret.uniform(0.15, 0.85)] * FRAMES
    load = Hidden(place, part=crowd, slow=slow, born=secret.whole(35, 70))
    return Game(name, load, machine(speeds, 2e-7), noise, evening=3)


def _fourth(secret: Secret, name: str) -> Game:
    """Make a game of machines with unknown speeds, some of which may have no particles at first."""
    speeds = secret.shuffled([1.0, 1.0, 0.8, 0.5, 0.4, 0.25])
    noise = _measured(secret, 6, 0.04)
    places, part = [secret.uniform(0.15, 0.85)] * FRAMES, 0.6 if "crowd" in name else 0.0
    if "drifts" in name:
        start, end = secret.shuffled([secret.uniform(0.12, 0.25), secret.uniform(0.75, 0.88)])
        begins, lasts = secret.whole(30, 60), secret.whole(10, 16)
        gone = np.clip((np.arange(FRAMES) - begins) / lasts, 0, 1)
        places = list(start + (end - start) * gone)
    load = Hidden(places, part=part, slow=_changing(secret, speeds, 0.35), width=0.12)
    return Game(name, load, machine(speeds, 1e-7), noise, evening=4)


def _fifth(secret: Secret, name: str) -> Game:
    """Make a game in which moving particles pays at times."""
    move_s = 4e-7 if "fast" in name else 1e-6 if "very" in name else 7e-7
    jumps = (1, 2) if "fast" in name else (1, 3)
    load = Hidden(_resting(secret, jumps), part=0.7, slow=np.ones((FRAMES, 6)), width=0.06)
    options = {"move_s": move_s, "frames": FRAMES}
    return Game(name, load, machine([1.0] * 6, move_s), options=options, evening=5)


def _sixth(secret: Secret, name: str) -> Game:
    """Make a game with everything at once."""
    slower = {"equal": [1.0] * 4, "two": [0.4] * 4, "three": [0.6, 0.6, 0.4, 0.4]}[name.split()[0]]
    speeds = secret.shuffled([1.0] * 4 + slower)
    slow = 1 - np.abs(secret.noise((FRAMES, 8), 0.02))
    slow[secret.whole(60, 90) :, secret.whole(0, 7)] *= 0.4
    load = Hidden(_resting(secret, (1, 2)), part=0.6, slow=slow, width=0.06)
    return Game(name, load, machine(speeds, 5e-7), raw=False, evening=6)


MADE: dict[int, tuple[Callable[[Secret, str], Game], tuple[str, ...]]] = {
    3: (_third, ("slow machines", "very slow machines", "a burst, and slow machines")),
    4: (_fourth, ("an even load", "a crowd", "a crowd that drifts")),
    5: (_fifth, ("a fast network", "a slow network", "a very slow network")),
    6: (_sixth, ("equal machines", "two kinds of machines", "three kinds of machines")),
}
"""What makes a game of each evening from random numbers and its name, and the names of its games."""


def game(evening: int, index: int, key: str) -> Game:
    """Draw one of an evening's games: the first fair one.

    Args:
        evening: 3 to 6.
        index: of the game, from 0 on.
        key: decides what is drawn.

    Returns:
        A game in which no simple policy comes close to the course's own solution.
    """
    make, names = MADE[evening]
    name = names[index]
    drawn = (make(Secret(key, f"{evening} {name} {draw}"), name) for draw in count())
    return next(one for one in drawn if one.is_fair)


def games(evening: int, key: str) -> list[Game]:
    """Draw all games of an evening from a key."""
    return [game(evening, index, key) for index in range(len(MADE[evening][1]))]


GAMES: dict[int, Callable[[str], list[Game]]] = {evening: partial(games, evening) for evening in MADE}
"""The games of each evening, from a key."""


def practice(evening: int, key: str) -> Game:
    """Return the game whose log an evening's notebook reads: like the hidden ones, but not one of them."""
    if evening in MADE:
        return game(evening, {3: 0, 4: 2, 5: 0, 6: 1}[evening], f"{key}\npractice")
    secret, frames = Secret(key, f"practice {evening}"), 40
    speeds = secret.shuffled([1.0, 1.0, 0.9, 0.9, 0.8, 0.5])
    noise = np.maximum(secret.noise((frames, 6), 0.02), -0.1)
    places = [secret.uniform(0.15, 0.85)] * frames
    load = Hidden(places, part=0.4, slow=np.ones((frames, 6)), width=0.15)
    return Game("practice", load, machine(speeds, 1e-7), noise)


def graded(asked: Asked, hidden: Sequence[Game]) -> list[Part]:
    """Let a submission play each game, and return points and hints."""
    return [_part(one.play(_policy(asked, one))) for one in hidden]


def _policy(asked: Asked, hidden: Game) -> Seen:
    smoothing = asked.make(hidden.options)
    return Seen(asked.decide, raw=hidden.raw, noise=hidden.noise, smoothing=smoothing)


def _part(result: Result) -> Part:
    return Part(result.name, result.points, _hint(result), result)


def _hint(result: Result) -> str:
    """Return a hint about what to look at; "" from 90 points on."""
    moved, enough = result.moved, result.full_moved
    if result.points >= 90:
        return ""
    if not moved:
        return "you moved nothing, but moving pays here"
    if moved > 2 * enough:
        return (
            f"you moved {moved:,} particles, but {enough:,} are enough: do you follow noise or brief changes?"
        )
    if moved < 0.6 * enough:
        return f"you moved {moved:,} particles, but {enough:,} are needed: do you move too few, or too late?"
    return "you move about as much as needed: are you late, or are your shares off?"
