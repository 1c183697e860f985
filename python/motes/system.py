"""System: all particles that follow the same lines of the script (paper 3.1.3)."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, NoReturn, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, actions, arguments
from ._run import script_lines
from .actions.base import Where
from .actions.recorder import Recorder
from .children import Children
from .conditions import columns_of, condition_of
from .curves import Curve, integrals, moving_part
from .distributions import Drawn, State, distribution
from .errors import ArgumentError, MotesError, NotAssignable, missing, near
from .fabrics import Fabrics
from .first_frame import FirstFrame
from .interchange.foreign import no_column
from .pairs import Pairs
from .particles import LocalParticles, Particles
from .shapes import Shape, Union, as_shape
from .sprites import Sprite
from .sums import Sums
from .values import Moving, Value, at, says_near_names

if TYPE_CHECKING:
    from .scenefile import Recording
    from .world import World

__all__ = ["System"]

CUT = np.dtype([("axis", "U1"), ("at", np.float32)])


class System(Recorder, Children, Fabrics, Sums):
    """A particle system, created by `World.system`. Calls are recorded, and run when the frame ends.

    Every rank makes the same calls in the same order; each does the part of its roles. None of the recording
    methods communicates. All of them raise MotesError outside `with world:`, inside a callback, and while
    another thread uses the world.
    """

    world: World
    """The world that it belongs to."""
    name: str

    def __init__(self, world: World, index: int, name: str, axes: str, definition: dict[str, Any]) -> None:
        """Create a system of a world; scripts call `World.system`."""
        names = [*_core.builtin_attributes(), *((a[0], a[1]) for a in definition["attributes"])]
        self._attributes = {attribute: (i, width) for i, (attribute, width) in enumerate(names)}
        self.__dict__.update(world=world, name=name)
        self._index = index
        self._axes = axes
        followed: int = definition["domains_of"]
        self._leads = index if followed < 0 else followed  # whose domains it has: its own, or another's
        self._definition = definition
        self._sprite: Sprite = definition["sprite"]
        self._columns = columns_of(names)
        self._given: dict[int, _core.Distribution] = {}
        self._state: list[tuple[int, _core.Distribution]] = []
        self._moving: dict[str, Moving | Value] = {}  # what `configure` was given that changes with time
        self._list: list[Any] = []
        self._lines: list[script_lines.Line] = []  # where each was recorded
        self._callbacks: list[Callable[[Any], object]] = []
        self._views: list[int] = []  # for each open `local()`: how long the list was when it opened
        self._first: FirstFrame | None = FirstFrame()
        self._has_births = False  # or children, in a list so far

    # --- what newborn particles get, and births

    @overload
    def configure(self, **state: Unpack[State]) -> None: ...
    @overload
    def configure(self, **state: Drawn) -> None: ...
    def configure(self, **state: Any) -> None:
        """Set what newborn particles get from here on: velocity, color, lifetime, a user's attribute, ...

        Each is a value, a shape (drawn uniformly from it), `Uniform(lo, hi)` or `Normal(mean, sigma)`.
        Attributes set by earlier calls remain. A `motes.Curve` gives each frame's newborn its value then.
        """
        made = {}
        for attribute, value in state.items():
            if attribute not in self._attributes or attribute == "position":
                names = [name for name in self._attributes if name != "position"]
                allowed = f"an attribute of '{self.name}': {', '.join(names)}"
                raise ArgumentError("configure", attribute, allowed, known=names)
            moving = moving_part(value)
            index, width = self._attributes[attribute]
            for time in moving:
                made[index] = distribution(attribute, width, at(value, time))
            if not moving:
                made[index] = distribution(attribute, width, value)
        self._given.update(made)
        for attribute, value in state.items():
            self._moving.pop(attribute, None)
            if moving_part(value):
                self._moving[attribute] = value
        self._sort_state()
        if self._first is not None:
            self._first.configured({name: at(value, self.world.time) for name, value in state.items()})

    def _sort_state(self) -> None:
        self._state = sorted(self._given.items(), key=lambda pair: pair[0])

    def _state_now(self) -> list[tuple[int, _core.Distribution]]:
        """Return what newborn particles get in this frame."""
        for attribute, value in self._moving.items():
            index, width = self._attributes[attribute]
            self._given[index] = distribution(attribute, width, at(value, self.world.time))
        if self._moving:
            self._sort_state()
        return self._state

    def _configured(self) -> tuple[dict[int, bytes], dict[str, Any]]:
        """Return what `configure` has set so far, to be pickled."""
        return {index: given.to_bytes() for index, given in self._given.items()}, dict(self._moving)

    def _configure_again(self, configured: tuple[Mapping[int, bytes], Mapping[str, Any]]) -> None:
        """Go on with what an earlier run had configured."""
        given, moving = configured
        self._given = {index: _core.Distribution.from_bytes(text) for index, text in given.items()}
        self._moving = dict(moving)
        self._sort_state()

    def _forget_list(self) -> None:
        """Start an empty list: the frame has run, or an earlier run has done it."""
        self._list.clear()
        self._lines.clear()
        self._callbacks.clear()

    @says_near_names
    def source(
        self,
        shape: Shape | ArrayLike,
        rate: float | Curve,
        jitter: bool = False,
        moving_from: Shape | ArrayLike | None = None,
        *,
        key: str | int | None = None,
    ) -> None:
        """Emit `rate` particles per second in `shape`.

        The rate may be another one in each frame, and a curve is integrated: at each frame's end the source
        has emitted floor(S) particles, where S is the sum of rate times `dt` over the frames that called it.
        No fraction is lost, also while the rate is 0 or the source is not called. With sub-steps, this holds
        at the end of each.

        `key` says which source this is, so whose fraction goes on: a text or an integer. Calls of a system
        with the same key are the same source. Without one, it is the line of the script that calls; of
        several calls of a line (or key) in a frame, the first one, the second one and so on are sources of
        their own. Where emitters of a loop come and go, give each a key.

        `jitter` spreads them over the (sub)step: each has aged and travelled a random part of it.

        `moving_from`: where the shape was one frame ago, if it moves: a shape of the same kind, and no union.
        Each particle is born where the shape was at the moment of its birth, on the straight way from a point
        of the one to the same point of the other. So a trail has no gaps, however fast the shape is. Paper
        3.2.1.
        """
        where = as_shape("shape", shape)
        before = None if moving_from is None else as_shape("moving_from", moving_from)
        if before is not None and (type(before) is not type(where) or isinstance(where, Union)):
            raise ArgumentError("moving_from", before, f"a {type(where).__name__}, as shape is, and no Union")
        world, given, until, scale = self.world, 0.0, list[float](), 0.0
        if isinstance(rate, Curve):
            until, scale = integrals(rate, world.frame, world.dt, world._settings.substeps)
        else:
            given = arguments.number("rate", rate, low=0, high=1e12)
        flag = arguments.flag("jitter", jitter)
        start = None if before is None else before.core
        said = script_lines.running_line(1) if key is None else arguments.key("key", key)
        number = script_lines.number_of(said)
        birth = _core.Birth.source(where.core, given, flag, self._state_now(), start, until, scale, number)
        self._record_birth("source", birth)

    @says_near_names
    def burst(self, shape: Shape | ArrayLike, count: int) -> None:
        """Emit `count` particles in `shape`, once in this frame."""
        where = as_shape("shape", shape).core
        count = arguments.integer("count", count, high=4_000_000_000)
        self._record_birth("burst", _core.Birth.burst(where, count, self._state_now()))

    def vertex(self, position: ArrayLike) -> None:
        """Emit one particle at `position`."""
        self.burst(arguments.triple("position", position), count=1)

    def emit(
        self,
        particles: Particles | None = None,
        /,
        *,
        position: ArrayLike | None = None,
        **columns: ArrayLike,
    ) -> None:
        """Emit the particles of these arrays, one row per particle: `position` (n, 3), others (n, 3) or (n,).

        Vectors of 2 numbers, (n, 2), stand for (x, y, 0). Attributes that are not given come from
        `configure`. The arrays must be the same on every rank.

        `particles`: those that `gather("all")` or `motes.open_particles(path)[frame]` gave, with all that
        `Particles.columns` names; arrays that are also given replace its columns. They get new ids.
        """
        given: dict[str, Any] = {"position": position, **columns}
        if particles is not None:
            if not isinstance(particles, Particles):
                allowed = "motes.Particles; arrays go by name: position=..."
                raise ArgumentError("particles", particles, allowed)
            given = particles.columns() | (columns if position is None else given)
        arrays: list[tuple[int, NDArray[np.float32]]] = []
        count: int | None = None
        for attribute, values in given.items():
            if attribute not in self._attributes:
                raise no_column(self.name, attribute, values, self._attributes)
            index, width = self._attributes[attribute]
            array = arguments.rows(attribute, values, width, count)
            count = len(array)
            arrays.append((index, array))
        self._record_birth("emit", _core.Birth.emit(count or 0, arrays, self._state_now()))
        if self._first is not None:
            self._first.emitted(zip(given, (array for _, array in arrays), strict=True))

    def _record_birth(self, call: str, birth: _core.Birth) -> None:
        world = self.world
        engine = world._begin(call)
        try:
            engine.record_birth(self._index, birth)
            self._list.append(birth)
            self._lines.append(script_lines.running_line(2))
            self._has_births = True
        finally:
            world._usage.end()

    # --- actions

    def apply(self, action: actions.Action | Sequence[actions.Action]) -> None:
        """Record an action, or each of a list."""
        for one in action if isinstance(action, (list, tuple)) else (action,):
            self._record(actions.as_action(one), 2)

    def _record(self, action: actions.Action, depth: int = 3) -> None:
        """Record an action; `depth` calls of the package stand between the script and the engine."""
        world = self.world
        if action.moves:
            action = action.at_time(world.time)
        engine = world._begin(type(action).__name__)
        try:
            line = script_lines.running_line(depth)
            other = getattr(action, "other", None)
            if other is None:
                engine.record_action(self._index, action.compiled(self._columns))
            else:
                self._check_other(other)
                engine.record_interaction(self._index, other._index, action.compiled(self._columns))
                other._list.append(action)
                other._lines.append(line)
            self._list.append(action)
            self._lines.append(line)
        finally:
            world._usage.end()

    def _check_other(self, other: object) -> None:
        if not isinstance(other, System) or other.world is not self.world or other is self:
            raise ArgumentError("other", other, "another system of the same world")

    @says_near_names
    def callback(self, function: Callable[[LocalParticles], object], *, where: Where = None) -> None:
        """Call `function(particles)` here in the list, on each calculator, with views of its particles.

        It must treat each particle by itself, and not depend on how many there are: newborn particles may
        come in a separate call. It is called in each sub-step. It cannot record, step or read systems. With
        `where`, it sees only the particles in a shape or for which a comparison holds: their columns are
        copies, which are written back afterwards, and it is not called if there are none.
        """
        if not callable(function):
            raise ArgumentError("function", function, "a function of particles")
        shapes: list[_core.Shape] = []
        callback = _core.Callback(
            name=_name_of(function),
            number=len(self._callbacks),
            where=condition_of(where, self._columns, shapes),
            shapes=shapes,
        )
        self._record_function("callback", function, partial(_core.Engine.record_callback, callback=callback))

    def _record_function(
        self, call: str, function: Callable[[Any], object], record: Callable[..., None]
    ) -> None:
        world = self.world
        engine = world._begin(call)
        try:
            if world._recording is not None:
                world._recording.refuse(world.frame, f"'{self.name}' calls {_name_of(function)} back")
            record(engine, self._index)
            self._callbacks.append(function)
            self._list.append(function)
            self._lines.append(script_lines.running_line(3))
        finally:
            world._usage.end()

    def _called(self, number: int, begin: int, chosen: Any, pairs: Any) -> NDArray[np.float32] | None:
        if pairs is not None:
            return self._call_pairs(number, pairs)
        self._call_back(number, begin, chosen)
        return None

    def _call_back(self, number: int, begin: int, chosen: NDArray[np.uint32] | None) -> None:
        engine = self.world._engine_for("callback")
        function = self._callbacks[number]
        view = LocalParticles(engine, self._index, self._attributes, begin, chosen)
        try:
            with self.world._usage.callback(f"{_name_of(function)!r} of system {self.name!r}"):
                function(view)
            view._write_back()
        finally:
            if view._close():
                engine.release_views(self._index)

    @says_near_names
    def pairs(self, function: Callable[[Pairs], object], radius: float, *, where: Where = None) -> None:
        """Call `function(pairs)` here in the list, on each calculator, with the pairs within `radius` metres.

        Each pair is seen from both of its particles; `function` returns the changes of velocity of the own
        ones, shape (n, 3), or None for no change. They are added in the order of the pairs. It must treat
        each pair by itself. Paper 3.1.5.
        """
        if not callable(function):
            raise ArgumentError("function", function, "a function of pairs")
        name = _name_of(function)
        shapes: list[_core.Shape] = []
        condition = condition_of(where, self._columns, shapes)
        within = arguments.number("radius", radius, low=0)
        numbers = {"radius": within, "number": len(self._callbacks), "name": zlib.crc32(name.encode())}
        action = _core.Action("pairs", numbers, shapes, condition)
        self._record_function("pairs", function, partial(_core.Engine.record_action, action=action))

    def _call_pairs(self, number: int, arrays: tuple[NDArray[Any], ...]) -> NDArray[np.float32] | None:
        function = self._callbacks[number]
        pairs = Pairs(*arrays)
        with self.world._usage.callback(f"{_name_of(function)!r} of system {self.name!r}"):
            changes = function(pairs)
        return None if changes is None else pairs._checked(changes)

    @property
    def recorded(self) -> list[Any]:
        """This frame's list so far: actions and births in order."""
        return list(self._list)

    # --- reading

    @contextmanager
    def local(self) -> Iterator[LocalParticles]:
        """Give zero-copy views of this rank's particles at this point of the script, valid inside the block.

        Ids alone are a copy. Does not communicate, but runs what was recorded so far; reading does not change
        any result. With sub-steps the views show a preview, in which all of them have run; writing into it
        makes it count, and then the rest of the list runs after it. Particles whose positions were written go
        to their owners when the frame ends. The frame cannot end inside the block.
        """
        world = self.world
        engine = world._begin("local()", reads=True)
        try:
            preview = engine.run_pending(self._index)
        finally:
            world._usage.end()
        refuse = None if world._recording is None else partial(self._refuse_writing, world._recording)
        view = LocalParticles(
            engine,
            self._index,
            self._attributes,
            refuse_writing=refuse,
            preview=preview,
            watched=world._recovery is not None,
        )
        self._views.append(len(self._list))
        world._open_views.append(self)
        if self._first is not None:
            self._first.free = True
        try:
            yield view
            view._keep_preview()
        finally:
            world._open_views.remove(self)
            self._views.pop()
            if view._close() and not self._views:
                engine.release_views(self._index)
            engine.touched(self._index)

    def _refuse_writing(self, recording: Recording) -> NoReturn:
        recording.refuse(self.world.frame, f"the script writes particles of '{self.name}'")

    def gather(self, *, to: int | str = 0) -> Particles:
        """Copy all particles, sorted by id, to rank 0 or to "all". Collective.

        Elsewhere the result is falsy and empty.
        """
        if not isinstance(to, (int, str)) or isinstance(to, bool) or to not in (0, "all"):
            raise ArgumentError("to", to, "0 or 'all'")
        engine = self.world._begin("gather()", reads=True)
        try:
            return Particles(engine.gather(self._index, to == "all"))
        finally:
            self.world._end_call(engine)

    @property
    def sprite(self) -> Sprite:
        """How the particles are drawn; may change between frames."""
        return self._sprite

    @sprite.setter
    def sprite(self, value: Sprite) -> None:
        if not isinstance(value, Sprite):
            raise ArgumentError("sprite", value, "a motes.Sprite")
        world = self.world
        with world._usage.during("setting the sprite"):
            self._sprite = value
            if world._engine is not None:
                world._engine.set_sprite(self._index, value.core)

    @property
    def axis(self) -> str | None:
        """What its domains cut: one axis (slabs), several (bricks), or None (particles dealt out by id)."""
        return None if self._axes == "id" else self._axes

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
    def cuts(self) -> NDArray[Any]:
        """The cuts between domains, as last agreed; one fewer than calculators.

        Slabs: their positions (m), ascending, float32. By id (`axis=None`): the same, on the interval 0..1.
        Bricks: records with the fields `axis` ("x", "y" or "z") and `at` (m), in the order of the domains
        between which they stand: of n domains the first n // 2 lie below cut n // 2 - 1, and so on.
        """
        if self.world._engine is None:
            raise MotesError("cuts exist inside `with world:` only")
        tree = self.world._engine.cuts(self._index)
        if self.axis is None or len(self.axis) == 1:
            return np.array([at for _, at in tree], np.float32)
        return np.array([("xyz"[axis], at) for axis, at in tree], CUT)

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse what is not an attribute of the system, and say how to set a particle's attribute."""
        if name.startswith("_") or name == "sprite":
            object.__setattr__(self, name, value)
        else:
            self._refuse(name)

    def _refuse(self, name: str) -> NoReturn:
        if name in self._attributes:
            raise NotAssignable(
                f"{name} belongs to particles, not to a system: configure({name}=...) gives it to newborn "
                f"particles, set({name}=...) to living ones"
            )
        if hasattr(type(self), name) or name in ("world", "name"):
            raise NotAssignable(f"{name} of a system cannot be assigned")
        known = ["sprite", *self._attributes]
        raise NotAssignable(f"a system has no attribute {name!r} to assign{near(name, known)}")

    def __getattr__(self, name: str) -> Any:
        """Raise the error for an attribute that does not exist, with what to use instead."""
        if name in self.__dict__.get("_attributes", ()):
            raise AttributeError(
                f"{name} belongs to particles, not to a system: read it in `with system.local() as p:` or "
                "from system.gather()",
                name=name,
                obj=None,
            )
        raise missing("a system", name, [known for known in dir(type(self)) if known[0] != "_"])

    def __repr__(self) -> str:
        """Show name and size."""
        return f"<System {self.name!r}, {self.count} particles>"


def _name_of(function: object) -> str:
    return str(getattr(function, "__qualname__", type(function).__name__))
