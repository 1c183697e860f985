"""Checks for the arguments of `World` and `World.system` that are more than a number or a name."""

from __future__ import annotations

import os
import re
from collections.abc import Container, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from .._live import repeating
from .._mpi import alone, rank_process
from .._picture.rendering import Renderer
from .._picture.sprites import Sprite
from .._run import sweeping
from .._run.excerpt import Excerpt
from .._run.process import process
from .._run.settings import RunSettings
from .._system.system import state_of
from .._system.system_state import SystemState, engine_attributes
from .._values import arguments, environment
from .._values.checkpoint import checked as checkpoint_of
from .._values.live import checked as live_of
from .._values.space import AXES, BY_ID, CURVES, Period, in_a_row, periods_of
from ..balance import BALANCERS, Balancer, Static, for_any_domains
from ..errors import ArgumentError

if TYPE_CHECKING:
    from mpi4py import MPI


__all__ = [
    "axis",
    "balancer",
    "check_periods",
    "check_room",
    "directory",
    "interval",
    "leader",
    "ranks_of",
    "renderer",
    "settings",
    "spans",
    "sprite",
    "system_name",
    "user_attributes",
]

ALLOWED_AXES = f"{', '.join(map(repr, (*AXES, *CURVES)))} or None"


def settings(
    *,
    cast: tuple[int, int, Sequence[int]],
    speeds: Mapping[int, float],
    **given: Any,
) -> RunSettings:
    """Check the arguments of a world and return the run's settings; environment variables take precedence.

    `cast`, `speeds`: which rank plays which role, and the ranks' speeds, as given by `roles`.
    """
    given = dict(sweeping.given_with(given))
    seed, axes, log = given["seed"], axis(given["axis"]), directory(given["log"])
    excerpt = Excerpt.current()
    is_still = excerpt is not None and excerpt.still is not None
    own_log = log if excerpt is None or log is None else os.fspath(excerpt.beside(Path(log)))
    space, periods = interval(given["space"]), periods_of(given["periodic"])
    check_periods(axes, space, periods)
    checked = RunSettings(
        seed=None if seed is None else arguments.integer("seed", seed, high=2**64 - 1),
        dt=arguments.number("dt", given["dt"], low=1e-9, high=1e9),
        substeps=arguments.integer("substeps", given["substeps"], low=1, high=10_000),
        axis=axes,
        space=space,
        periodic=periods,
        roles=cast,
        balancer=balancer(given["balancer"], axes),
        combine=arguments.choice("combine", given["combine"], ("one_by_one", "together", "overlapped")),
        births=environment.births(given["births"]),
        fan_out=environment.fan_out(given["fan_out"]),
        skin=environment.skin(),
        threads=environment.threads(given["threads"]),
        clock=arguments.choice("clock", given["clock"], ("cpu", "wall")),
        digest=arguments.flag("digest", given["digest"]),
        log=None if is_still else own_log,
        spans=spans(given["spans"], log=log) and not is_still,
        speeds=speeds,
        stall_s=environment.stall_s(),
        checkpoint=checkpoint_of(given["checkpoint"]),
        on_loss=arguments.choice("on_loss", given["on_loss"], ("stop", "recover")),
        live=None if is_still else live_of(given["live"]),
        steering=repeating.checked(given["steering"]),
        excerpt=excerpt,
        whole_log=None if excerpt is None or environment.read("MOTES_PREVIEW") else log,
    )
    if not environment.read("MOTES_REHEARSAL"):
        return checked
    return checked._replace(log=None, spans=False, checkpoint=None, live=None, steering=None)


def axis(value: Any, world: str | None = None) -> str:
    """Return the axes that domains cut, sorted ("x", "xz", ...), or a curve's name, or `BY_ID` for None.

    `world`: the axes that the value "world" stands for; None: "world" is not allowed.
    """
    if world is not None and isinstance(value, str) and value == "world":
        return world
    if value is None:
        return BY_ID
    if isinstance(value, str) and value in CURVES:
        return value
    if not isinstance(value, str) or not value or len(set(value)) != len(value) or set(value) - set("xyz"):
        known = (*AXES, *CURVES) if world is None else ("world", *AXES, *CURVES)
        raise ArgumentError("axis", value, ALLOWED_AXES, known=known)
    return "".join(sorted(value))


def check_room(axes: str, space: Any, periods: Sequence[Period]) -> None:
    """Check that space is bounded on all sides if domains are stretches of a curve through its cells."""
    if axes in CURVES and len(periods) < 3 and not isinstance(space, tuple):
        allowed = f"(low, high), m, for axis={axes!r}: a curve needs a finite space"
        raise ArgumentError("space", space, allowed)


def check_periods(axes: str, space: Any, periods: Sequence[Period]) -> None:
    """Check `space` if domains cut only periodic axes: domains then divide the periods."""
    ends = {"xyz"[axis]: (low, high) for axis, low, high in periods}
    cut = "xyz" if axes in CURVES else axes
    if not isinstance(space, tuple) or not set(cut) <= ends.keys():
        return
    first, last = (float(np.float32(end)) for end in space)
    for name in cut:
        low, high = ends[name]
        if not (low <= first and last <= high) and not (first <= low and high <= last):
            allowed = f"within or around ({low:g}, {high:g}), the period of {name!r}, which domains divide"
            raise ArgumentError("space", space, f"{allowed}, or not given")


def leader(systems: Sequence[SystemState], domains_of: Any, axes: str | None, space: Any) -> SystemState:
    """Return the system whose domains a new one shares; check that the new system's axis and space agree."""
    given = state_of(domains_of)
    if given is None or not any(system is given for system in systems):
        raise ArgumentError("domains_of", domains_of, "None or an earlier system of this world")
    leader = systems[given.leads]
    whose = f"that of {leader.name!r}, whose domains it shares"
    if axis(axes, leader.axes) != leader.axes:
        raise ArgumentError(
            "axis", axes, f"{None if leader.axes == BY_ID else leader.axes!r}, {whose}, or not given"
        )
    wanted = leader.definition["space"]
    if space is not None and interval(space) != wanted:
        raise ArgumentError("space", space, f"{wanted!r}, {whose}, or not given")
    return leader


def balancer(value: Any, axes: str) -> Balancer:
    """Return `value`, or `Static()` for None; check that the balancer can move cuts of `axes`."""
    if value is None:
        return Static()
    if not isinstance(value, Balancer):
        raise ArgumentError("balancer", value, "None or a balancer of motes.balance", known=BALANCERS)
    if value.slabs_only and not in_a_row(axes):
        allowed = for_any_domains()
        raise ArgumentError("balancer", value, f"{allowed} for axis={None if axes == BY_ID else axes!r}")
    return value


def ranks_of(comm: Any) -> tuple[MPI.Intracomm, Sequence[int], int]:
    """Return a communicator, its ranks, and the number of ranks that these are numbered among.

    The communicator is `comm`; for None, that of all ranks, or of the survivors once ranks were lost.
    """
    if rank_process.is_fork():
        if comm is not None:
            raise ArgumentError("comm", comm, "None in a forked process, where MPI does not work")
        return alone.communicator(), range(1), 1
    from mpi4py import MPI

    if comm is None and process.left is not None:
        left = process.left
        ranks = left.Get_group().Translate_ranks(None, MPI.COMM_WORLD.Get_group())
        return left, [int(rank) for rank in ranks], MPI.COMM_WORLD.size
    if comm is None:
        comm = MPI.COMM_WORLD
    if not isinstance(comm, MPI.Intracomm) or not comm:
        raise ArgumentError("comm", comm, "None or an mpi4py intracommunicator that has not been freed")
    return comm, range(comm.size), comm.size


def directory(log: Any) -> str | None:
    """Return `log` as a string, or None."""
    if log is None:
        return None
    if not isinstance(log, (str, os.PathLike)):
        raise ArgumentError("log", log, "None or a directory's path")
    return os.fspath(log)


def spans(value: Any, *, log: Any) -> bool:
    """Return `value`, True or False; raise ArgumentError if it is True without a log."""
    if arguments.flag("spans", value) and log is None:
        raise ArgumentError("spans", value, "False without a log")
    return bool(value)


def renderer(argument: str, value: Any) -> Renderer | None:
    """Return `value`, a renderer or None."""
    if value is not None and not isinstance(value, Renderer):
        raise ArgumentError(argument, value, "None or a motes.Renderer")
    return value


def sprite(value: Any) -> Sprite:
    """Return `value`, or the default sprite for None."""
    if value is None:
        return Sprite()
    if not isinstance(value, Sprite):
        raise ArgumentError("sprite", value, "None or a motes.Sprite")
    return value


def system_name(name: Any, *, taken: Container[str]) -> None:
    """Check the name of a new system."""
    if not isinstance(name, str) or not name:
        raise ArgumentError("name", name, "a non-empty string")
    if name in taken:
        error = ArgumentError("name", name, "a new one")
        error.args = (f"a system named {name!r} already exists; names are unique",)
        raise error
    if any("\ud800" <= letter <= "\udfff" for letter in name):
        raise ArgumentError("name", name, "a string without surrogates, which are halves of characters")


def interval(space: Any) -> tuple[float, float] | str | None:
    """Return `space`: (lo, hi), None or "fit"."""
    if space is None:
        return None
    if isinstance(space, str) and space == "fit":
        return space
    if isinstance(space, str) or not isinstance(space, (tuple, list)) or len(space) != 2:
        raise ArgumentError("space", space, "(lo, hi), None or 'fit'", known=("fit",))
    low = arguments.number("space", space[0], low=-1e12, high=1e15)
    high = arguments.number("space", space[1], low=-1e12, high=1e15)
    if not low < high:
        raise ArgumentError("space", space, "(lo, hi) with lo < hi")
    return low, high


def user_attributes(
    attributes: Mapping[str, Any], periods: Sequence[Period], sprite: Sprite
) -> list[tuple[str, int, tuple[float, float, float]]]:
    """Return name, width and initial value of each attribute, and of those that periods and ribbons add."""
    if not isinstance(attributes, Mapping):
        raise ArgumentError("attributes", attributes, "a dict of names and initial values")
    added = [(name, width, (0.0, 0.0, 0.0)) for name, width in engine_attributes(periods, sprite)]
    taken = {"id", *(name for name, _ in _core.builtin_attributes()), *(name for name, _, _ in added)}
    definitions = []
    for name, value in attributes.items():
        if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) or name in taken:
            raise ArgumentError(
                "attributes", name, "new names of letters, digits and _ that begin with a letter"
            )
        if isinstance(value, (int, float, np.integer, np.floating)):
            definitions.append((name, 1, (arguments.number(name, value), 0.0, 0.0)))
        else:
            definitions.append((name, 3, arguments.triple(name, value)))
    return definitions + added
