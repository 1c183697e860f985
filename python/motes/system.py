"""System: all particles that act by the same script lines (paper 3.1.3)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, actions, arguments
from .actions.base import Where
from .actions.recorder import Recorder
from .distributions import distribution
from .errors import ArgumentError, MotesError
from .expressions import compile_condition
from .particles import LocalParticles, Particles
from .rendering import Sprite
from .shapes import Shape, as_shape

if TYPE_CHECKING:
    from .world import World

__all__ = ["System"]


class System(Recorder):
    """A particle system; made by `World.system`. Calls record, and run when the frame ends.

    Every rank makes the same calls in the same order; each does its role's part of them. None of the
    recording methods communicates.
    """

    def __init__(self, world: World, index: int, name: str, definition: dict[str, Any]) -> None:
        """Belong to a world; scripts call `World.system`."""
        self.world = world
        self.name = name
        self._index = index
        self._definition = definition
        self._sprite: Sprite = definition["sprite"]
        names = [*_core.builtin_attributes(), *((a[0], a[1]) for a in definition["attributes"])]
        self._attributes = {attribute: (i, width) for i, (attribute, width) in enumerate(names)}
        self._columns = _first_components(names)
        self._given: dict[int, _core.Distribution] = {}
        self._state: list[tuple[int, _core.Distribution]] = []
        self._list: list[Any] = []
        self._callbacks: list[Callable[[LocalParticles], object]] = []

    # --- what newborn particles get, and births

    def configure(self, **state: Any) -> None:
        """Set what newborn particles get from here on: velocity, color, lifetime, a user's attribute, ...

        Each is a value, a shape (drawn uniformly from it), `Uniform(lo, hi)` or `Normal(mean, sigma)`.
        Calls add up.
        """
        made = {}
        for attribute, value in state.items():
            if attribute not in self._attributes or attribute == "position":
                known = ", ".join(name for name in self._attributes if name != "position")
                raise ArgumentError("configure", attribute, f"an attribute of '{self.name}': {known}")
            index, width = self._attributes[attribute]
            made[index] = distribution(attribute, width, value)
        self._given.update(made)
        self._state = sorted(self._given.items(), key=lambda pair: pair[0])

    def source(self, shape: Shape | ArrayLike, rate: float, jitter: bool = False) -> None:
        """Bear `rate` particles a second in `shape`: frame k bears floor(rate t(k+1)) - floor(rate t(k)).

        `jitter` spreads them over the (sub)step: each has aged and travelled a random part of it. Paper
        3.2.1.
        """
        where = as_shape("shape", shape).core
        rate = arguments.number("rate", rate, low=0, high=1e12)
        self._bear(_core.Birth.source(where, rate, arguments.flag("jitter", jitter), self._state), "source")

    def burst(self, shape: Shape | ArrayLike, count: int) -> None:
        """Bear `count` particles in `shape`, once in this frame."""
        where = as_shape("shape", shape).core
        count = arguments.integer("count", count, high=4_000_000_000)
        self._bear(_core.Birth.burst(where, count, self._state), "burst")

    def vertex(self, position: ArrayLike) -> None:
        """Bear one particle at `position`."""
        self.burst(arguments.triple("position", position), count=1)

    def emit(self, *, position: ArrayLike, **columns: ArrayLike) -> None:
        """Bear the particles of these arrays: `position` (n, 3), others (n, 3) or (n,), one row a particle.

        Attributes that are not given come from `configure`. The arrays must be the same on every rank.
        """
        given = {"position": position, **columns}
        arrays: list[tuple[int, NDArray[np.float32]]] = []
        count: int | None = None
        for attribute, values in given.items():
            if attribute not in self._attributes:
                raise ArgumentError("emit", attribute, f"an attribute of '{self.name}'")
            index, width = self._attributes[attribute]
            array = _rows(attribute, values, width, count)
            count = len(array)
            arrays.append((index, array))
        self._bear(_core.Birth.emit(count or 0, arrays, self._state), "emit")

    def _bear(self, birth: _core.Birth, name: str) -> None:
        self.world._engine_for(name).record_birth(self._index, birth)
        self._list.append(birth)

    def spawn(
        self, *, into: System, on: str = "death", count: int, inherit_velocity: float = 0, where: Where = None
    ) -> None:
        """Let events of this frame bear particles of system `into`: `count` for each parent.

        `on`: "birth", "death" or "collision" (with what it bounces off; once a frame). Children appear where
        the parent is at the frame's end, when the next frame starts, with what `into.configure` says now plus
        `inherit_velocity` times the parent's velocity. They are numbered in the order of the parents' ids.
        """
        if not isinstance(into, System) or into.world is not self.world:
            raise ArgumentError("into", into, "a system of the same world")
        shapes: list[_core.Shape] = []
        spawn = _core.Spawn(
            into=into._index,
            on=arguments.choice("on", on, ("birth", "death", "collision")),
            count=arguments.integer("count", count, low=1, high=1_000_000),
            inherit_velocity=arguments.number("inherit_velocity", inherit_velocity, low=-1e6, high=1e6),
            state=into._state,
            where=compile_condition(where, self._columns, shapes),
            shapes=shapes,
        )
        self.world._engine_for("spawn").record_spawn(self._index, spawn)
        self._list.append(spawn)

    # --- actions

    def apply(self, action: actions.Action | Sequence[actions.Action]) -> None:
        """Record an action, or each of a list."""
        for one in action if isinstance(action, (list, tuple)) else [action]:
            value = actions.as_action(one)
            engine = self.world._engine_for(type(value).__name__)
            engine.record_action(self._index, value.compiled(self._columns))
            self._list.append(value)

    def callback(self, function: Callable[[LocalParticles], object], *, where: Where = None) -> None:
        """Call `function(particles)` here in the list, on each calculator, with views of its particles.

        It must act on each particle alone, and not look at how many there are: newborn particles may come in
        a call of their own. With sub-steps it is called in each. With `where`, it sees only the particles in
        a shape or for which a comparison holds: their columns are copies, which are written back behind it,
        and there is no call where there are none.
        """
        if not callable(function):
            raise ArgumentError("function", function, "a function of particles")
        name = str(getattr(function, "__qualname__", type(function).__name__))
        shapes: list[_core.Shape] = []
        callback = _core.Callback(
            name=name,
            number=len(self._callbacks),
            where=compile_condition(where, self._columns, shapes),
            shapes=shapes,
        )
        engine = self.world._engine_for("callback")
        if self.world._recording is not None:
            self.world._recording.refuse(self.world.frame, f"'{self.name}' calls {name} back")
        engine.record_callback(self._index, callback)
        self._callbacks.append(function)
        self._list.append(function)

    def _call_back(self, number: int, begin: int, chosen: NDArray[np.uint32] | None) -> None:
        engine = self.world._engine_for("callback")
        view = LocalParticles(engine, self._index, self._attributes, begin, chosen)
        try:
            self._callbacks[number](view)
            view._write_back()
        finally:
            view._close()

    @property
    def recorded(self) -> list[Any]:
        """This frame's list so far: actions and births in order."""
        return list(self._list)

    # --- reading

    @contextmanager
    def local(self) -> Iterator[LocalParticles]:
        """Give zero-copy views of this rank's particles, where the script stands; valid inside only.

        Does not communicate, but runs what was recorded so far; reading changes nothing that comes out. With
        sub-steps one sees a preview, in which all of them have run; writing into it makes it count, and then
        the rest of the list runs behind it. Positions that are written take their particles to their owners
        when the frame ends.
        """
        engine = self.world._engine_for("local")
        preview = engine.run_pending(self._index)
        recording = self.world._recording
        view = LocalParticles(
            engine, self._index, self._attributes, read_only=recording is not None, preview=preview
        )
        try:
            yield view
            view._keep_preview()
        except ValueError as error:
            if recording is not None and "read-only" in str(error):
                recording.refuse(self.world.frame, f"the script writes particles of '{self.name}'")
            raise
        finally:
            view._close()
            engine.touched(self._index)

    def gather(self, *, to: int | str = 0) -> Particles:
        """Copy all particles, sorted by id, to rank 0 or to "all". Collective.

        Elsewhere the result is falsy and empty.
        """
        if not isinstance(to, (int, str)) or isinstance(to, bool) or to not in (0, "all"):
            raise ArgumentError("to", to, "0 or 'all'")
        return Particles(self.world._engine_for("gather").gather(self._index, to == "all"))

    @property
    def sprite(self) -> Sprite:
        """How the particles are drawn; may change between frames."""
        return self._sprite

    @sprite.setter
    def sprite(self, value: Sprite) -> None:
        if not isinstance(value, Sprite):
            raise ArgumentError("sprite", value, "a motes.Sprite")
        self._sprite = value
        if self.world._engine is not None:
            self.world._engine.set_sprite(self._index, value.core)

    @property
    def count(self) -> int:
        """Particles on all ranks, as last agreed."""
        return 0 if self.world._engine is None else self.world._engine.count(self._index)

    @property
    def born(self) -> int:
        """Particles born so far: the next id."""
        return 0 if self.world._engine is None else self.world._engine.born(self._index)

    @property
    def dropped(self) -> int:
        """Births that the capacity has dropped so far."""
        return 0 if self.world._engine is None else self.world._engine.dropped(self._index)

    @property
    def cuts(self) -> NDArray[np.float32]:
        """The numbers between the calculators' domains (m), as last agreed; one fewer than calculators."""
        if self.world._engine is None:
            raise MotesError("cuts exist inside `with world:` only")
        return np.asarray(self.world._engine.cuts(self._index), np.float32)

    def __repr__(self) -> str:
        """Show name and size."""
        return f"<System {self.name!r}, {self.count} particles>"


def _first_components(names: Iterable[tuple[str, int]]) -> dict[str, tuple[int, int]]:
    columns, first = {}, 0
    for name, width in names:
        columns[name] = (first, width)
        first += width
    return columns


def _rows(attribute: str, values: Any, width: int, count: int | None) -> NDArray[np.float32]:
    allowed = f"finite numbers of shape (n, {width})" if width > 1 else "finite numbers of shape (n,)"
    array = np.ascontiguousarray(arguments.floats(attribute, values, np.float32, allowed))
    fits = array.ndim == 2 and array.shape[1] == width if width > 1 else array.ndim == 1
    endless = attribute == "lifetime" and (array > -np.inf).all()
    if not fits or not (np.isfinite(array).all() or endless):
        raise ArgumentError(attribute, values, allowed)
    if count is not None and len(array) != count:
        raise ArgumentError(attribute, values, f"of {count} rows, as the position")
    return array
