"""Births: the sources, bursts and arrays of particles that a script records for a system."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._particles.foreign import no_column
from .._particles.particles import Particles
from .._run import script_lines
from .._values import arguments
from .._values.curves import Curve, integrals
from ..errors import ArgumentError
from ..shapes import Shape, Union, as_shape, native_of
from .system_state import SystemState, engine_sets

__all__ = ["Births"]

COPIES = {"position_b", "velocity_b", "up_b"}  # copies of birth values, which gathered particles may lack


class Births:
    """Checks births and records them."""

    def __init__(self, state: SystemState) -> None:
        """Create the recorder of a system's births."""
        self._state = state

    def source(
        self,
        shape: Shape | ArrayLike,
        rate: float | Curve,
        jitter: bool,
        moving_from: Shape | ArrayLike | None,
        key: str | int | None,
    ) -> None:
        """Record a source: `System.source`."""
        where = as_shape("shape", shape)
        before = None if moving_from is None else as_shape("moving_from", moving_from)
        if before is not None and (type(before) is not type(where) or isinstance(where, Union)):
            raise ArgumentError("moving_from", before, "of the same kind as shape, and not a Union")
        session, constant, integral, scale = self._state.session, 0.0, list[float](), 0.0
        if isinstance(rate, Curve):
            settings = session.settings
            integral, scale = integrals(rate, session.frame, settings.dt, settings.substeps)
        else:
            constant = arguments.number("rate", rate, low=0, high=1e12)
        flag = arguments.flag("jitter", jitter)
        identity = script_lines.running_line(2) if key is None else arguments.key("key", key)
        source = _core.Source(
            native_of(where),
            rate=constant,
            integral=integral,
            scale=scale,
            before=None if before is None else native_of(before),
            jitter=flag,
            state=self._state.state_now(),
            number=script_lines.number_of(identity),
        )
        self._record("source", source)

    def burst(self, shape: Shape | ArrayLike, count: int) -> None:
        """Record a burst: `System.burst`."""
        where = native_of(as_shape("shape", shape))
        count = arguments.integer("count", count, high=4_000_000_000)
        self._record("burst", _core.Burst(where, count=count, state=self._state.state_now()))

    def emit(
        self, particles: Particles | None, position: ArrayLike | None, columns: dict[str, ArrayLike]
    ) -> None:
        """Record births given as arrays: `System.emit`."""
        system = self._state
        given: dict[str, Any] = {"position": position, **columns}
        if particles is not None:
            if not isinstance(particles, Particles):
                allowed = "motes.Particles; pass arrays by name: position=..."
                raise ArgumentError("particles", particles, allowed)
            given = particles.columns() | (columns if position is None else given)
        whole = particles is None and not system.attributes.keys() - COPIES - given.keys()
        if (
            by_hand := system.engine_attributes & columns.keys()
        ) and not whole:  # `emit(**gathered.columns())` is
            raise engine_sets("emit", min(by_hand))
        arrays: list[tuple[int, NDArray[np.float32]]] = []
        count: int | None = None
        for attribute, values in given.items():
            if attribute not in system.attributes:
                raise no_column(system.name, attribute, values, system.attributes)
            index, width = system.attributes[attribute]
            array = arguments.rows(attribute, values, width, count)
            count = len(array)
            arrays.append((index, array))
        self._record("emit", _core.Emit(count=count or 0, columns=arrays, state=system.state_now()))
        if system.first is not None:
            system.first.emitted(zip(given, (array for _, array in arrays), strict=True))

    def next_id(self, call: str, count: int) -> int:
        """Return the first id of the next `count` particles; raise ArgumentError if capacity is short."""
        session = self._state.session
        engine = session.begin(call)
        try:
            first, room = engine.next_birth(self._state.index)
        finally:
            session.end()
        if room < count:
            raise ArgumentError(
                call, count, f"at most {room} particles: the system's capacity has room for no more"
            )
        return int(first)

    def _record(self, call: str, birth: _core.Source | _core.Burst | _core.Emit) -> None:
        system = self._state
        engine = system.session.begin(call)
        try:
            engine.record_birth(system.index, birth)
            system.add(birth, script_lines.running_line(3))
            system.has_births = True
        finally:
            system.session.end()
