"""Evening 1: find the slow machine in a log's seconds, and what balance would save.

Perfectly shared work takes all particles divided by the sum of the machines' speeds. That is less than the
mean of the seconds, unless all machines are equally fast.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from motes.replay.history import Floats

from ._secret import Secret
from .asking import Asked
from .grades import Part

__all__ = ["Case", "answers", "cases", "graded"]

FRAMES, CALCULATORS = 30, 6
NUMBERS = ("load_balance", "communication", "parallel", "saving_s")


@dataclass(frozen=True)
class Case:
    """A log's content: arrays (frames, calculators), and the wall-clock seconds of each frame (frames,)."""

    name: str
    seconds: Floats
    particles: Floats
    frame_s: Floats


def cases(key: str) -> list[Case]:
    """Make logs from a key, each with one problem."""
    return [_case(key, name) for name in ("a crowd", "a slow machine", "an idle machine", "a slow network")]


def _case(key: str, name: str) -> Case:
    secret = Secret(key, f"1 {name}")
    share = np.array([secret.uniform(0.9, 1.1) for _ in range(CALCULATORS)])
    speed = np.array([secret.uniform(0.9, 1.1) for _ in range(CALCULATORS)])
    crowded, slow, idle = secret.shuffled(range(CALCULATORS))[:3]
    share[crowded] *= 1.3
    speed[slow] *= 0.6
    rest = 0.1
    if name == "a crowd":
        share[crowded] *= 4
    elif name == "a slow machine":
        speed[slow] *= 0.4
    elif name == "an idle machine":
        share[slow] *= 0.3  # so the slowest machine does not take longest
    elif name == "a slow network":
        rest = 3.0
    drift = np.array([[secret.uniform(0.95, 1.05) for _ in range(CALCULATORS)] for _ in range(FRAMES)])
    particles = np.rint(20_000 * share * drift)
    particles[: FRAMES // 3, idle] = 0
    seconds = particles / (1e7 * speed) * (1 + np.maximum(secret.noise(particles.shape, 0.02), -0.1))
    longest = seconds.max(axis=1)
    frame_s = longest + rest * longest.mean() * np.array([secret.uniform(0.9, 1.1) for _ in range(FRAMES)])
    return Case(name, seconds, particles, frame_s)


def answers(case: Case) -> dict[str, Any]:
    """Return the right answers."""
    mean, longest = case.seconds.mean(axis=1).sum(), case.seconds.max(axis=1).sum()
    frames = case.frame_s.sum()
    waiting, rest = longest - mean, frames - longest
    speeds = case.particles.sum(axis=0) / case.seconds.sum(axis=0)
    shared = case.particles.sum() / speeds.sum()
    return {
        "load_balance": mean / longest,
        "communication": longest / frames,
        "parallel": mean / frames,
        "saving_s": (longest - shared) / len(case.frame_s),
        "slow": int(np.argmin(speeds)),
        "crowded": int(np.argmax(case.particles.sum(axis=0))),
        "first": "balance" if waiting > rest else "communication",
    }


def graded(asked: Asked, logs: list[Case]) -> list[Part]:
    """Let a submission report on each log, and grade its reports."""
    told = [(case, answers(case), _report(asked, case)) for case in logs]
    parts = []
    for name in answers(logs[0]):
        wrong = [_wrong(name, case, right[name], given) for case, right, given in told]
        parts.append(Part(name, round(100 * wrong.count("") / len(wrong), 1), next(filter(None, wrong), "")))
    return parts


def _report(asked: Asked, case: Case) -> Any:
    given = {"seconds": case.seconds, "particles": case.particles, "frame_s": case.frame_s}
    return asked.call("report", **{name: array.tolist() for name, array in given.items()})


def _waiting_s(case: Case) -> float:
    """Return the mean of the seconds for which calculators wait in a frame."""
    return float((case.seconds.max(axis=1) - case.seconds.mean(axis=1)).mean())


def _wrong(name: str, case: Case, right: Any, given: Any) -> str:
    """Return a hint, or "" if the answer is right."""
    if not isinstance(given, dict) or name not in given:
        return f"report does not return a dict with {name!r}"
    value = given[name]
    if name not in NUMBERS:
        if name == "slow" and value == int(np.argmax(case.seconds.sum(axis=0))) != right:
            return f"in {case.name!r} you name the calculator that takes longest: is its machine the slowest?"
        return "" if value == right else f"in {case.name!r} it is a different one"
    if not isinstance(value, (int, float)) or isinstance(value, bool) or not math.isfinite(value):
        return f"{name!r} must be a finite number"
    if math.isclose(value, right, rel_tol=1e-6):
        return ""
    if math.isclose(value, 1 / right, rel_tol=1e-6):
        return "that is its inverse: an efficiency is at most 1"
    if name == "saving_s" and math.isclose(value, right * len(case.frame_s), rel_tol=1e-6):
        return "that is for the whole run: what is it per frame?"
    if name == "saving_s" and math.isclose(value, _waiting_s(case), rel_tol=1e-6):
        return "that is the mean wait: fast machines can take more than their share, so balance saves more"
    if name != "saving_s" and abs(value - right) < 0.05 * right:
        return "nearly: add up the seconds of all frames before you divide"
    return f"not in {case.name!r}: who waits for whom, and how long?"
