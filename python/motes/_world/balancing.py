"""Balancers and speeds of ranks that viewers choose while a run goes on; no particle depends on them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from .. import _core, balance
from .._io.output import tell
from .._system.session import Session
from .._values.space import in_a_row

if TYPE_CHECKING:
    from .._live.steering import Steering

__all__ = ["apply", "menu", "policy", "state"]

_SHOWN = ("number", "count", "flag", "over")  # kinds of options that a menu has


def policy(call: str, session: Session) -> _core.Policy:
    """Return the engine's policy for a call such as "Pairwise(threshold=0.1)".

    Raises ValueError, which says why, if there is none or if it cannot balance this world.
    """
    made = _core.policy_named(call)
    kind = getattr(balance, made.name.partition("(")[0])
    wrong = [system.name for system in session.systems if kind.slabs_only and not in_a_row(system.axes)]
    if wrong:
        raise ValueError(f"{kind.__name__} needs domains in a row; those of {wrong[0]!r} are not")
    made.check(len(session.cast[2]))
    return made


def apply(row: Mapping[str, Any], session: Session) -> None:
    """Balance as a row of the steering says, from the next frame on. All ranks call it with the same row."""
    engine = session.engine
    if engine is None:
        return
    if "balancer" in row:
        try:
            engine.set_policy(policy(row["balancer"], session))
        except ValueError as error:  # a repeated run on other ranks: the particles are the same
            if session.manages:
                tell(f"motes: frame {session.frame}: the balancer stays: {error}")
    speed = row.get("speeds", {}).get(str(session.rank))
    if speed is not None:
        engine.set_speed(speed)


def menu(session: Session) -> dict[str, Any]:
    """Return what viewers may choose from, and what does not change: ranks, log, axes of domains."""
    options = {}
    for name in _core.policy_names():
        known = _core.policy_options(name)
        try:
            policy(f"{name}()", session)
        except ValueError:  # it needs options, or other domains
            continue
        options[name] = [
            [option, kind, default, most if most < 2**53 else None]
            for option, kind, default, most in known
            if kind in _SHOWN
        ]
    settings = session.settings
    log = None if settings.log is None else os.path.abspath(settings.log)
    axes = {system.name: system.axes for system in session.systems}
    return {
        "balancers": options,
        "ranks": session.size,
        "calculators": list(session.cast[2]),
        "log": log,
        "axes": axes,
    }


def state(session: Session, steering: Steering) -> dict[str, Any]:
    """Return how the run is balanced now."""
    given = {str(rank): speed for rank, speed in session.settings.speeds.items()}
    chosen = steering.balancer or balance.policy_of(session.settings.balancer).name
    return {"balancer": chosen, "speeds": {**given, **steering.speeds}}
