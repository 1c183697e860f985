"""System: all particles that follow the same lines of the script (paper 3.1.3)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, NoReturn, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._particles.particles import LocalParticles, Particles, close_views, keep_preview
from .._picture.sprites import Sprite, check_change, native_of
from .._run.scenefile import Recording
from .._values.curves import Curve
from .._values.space import are_bricks
from .._values.values import at, says_near_names
from ..actions.base import Where
from ..errors import MotesError, NotAssignableError, missing, near
from ..expressions import Expression
from ..shapes import Shape
from .births import Births
from .bodies import Bodies
from .callbacks import Callbacks
from .children import Children
from .distributions import Drawn, State
from .listing import Listing
from .pairs import Pairs
from .recorded import Recorded
from .sums import Sums

if TYPE_CHECKING:
    from .._world.world import World

__all__ = ["System", "recorded_of"]

CUT = np.dtype([("axis", "U1"), ("at", np.float32)])


class System(Bodies):
    """A particle system, created by `World.system`. Calls are recorded, and run when the frame ends.

    Every rank makes the same calls in the same order; each does the part of its roles. None of the recording
    methods communicates. All of them raise MotesError outside `with world:`, inside a callback, and while
    another thread uses the world.
    """

    world: World
    """The world that it belongs to."""
    name: str

    def __init__(self, world: World, recorded: Recorded) -> None:
        """Create a system of a world; scripts call `World.system`.

        Args:
            world: the world.
            recorded: the system as the package knows it.
        """
        super().__init__(Listing(recorded, recorded_of).record)
        self.__dict__.update(world=world, name=recorded.name)
        self._recorded = recorded
        self._session = recorded.session
        self._births = Births(recorded)
        self._children = Children(recorded)
        self._callbacks = Callbacks(recorded)
        recorded.called = self._callbacks.called
        self._sums = Sums(recorded)

    # --- what newborn particles get, and births

    @overload
    def configure(self, **state: Unpack[State]) -> None: ...
    @overload
    def configure(self, **state: Drawn) -> None: ...
    def configure(self, **state: Any) -> None:
        """Set what newborn particles get from here on; attributes set by earlier calls remain.

        Args:
            **state: velocity, color, lifetime, a user's attribute, ... Each is a value, a shape (drawn
                uniformly from it), `Uniform(lo, hi)` or `Normal(mean, sigma)`; a `motes.Curve` gives each
                frame's newborn particles its value then.
        """
        self._recorded.newborn.configure(state)
        if self._recorded.first is not None:
            time = self._session.time
            self._recorded.first.configured({name: at(value, time) for name, value in state.items()})

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
        """Emit particles in a shape at a rate.

        At each frame's end the source has emitted floor(S) particles, where S is the sum of rate times `dt`
        over the frames that called it; with sub-steps, this holds at the end of each. No fraction is lost,
        also while the rate is 0 or the source is not called. Paper 3.2.1.

        Args:
            shape: where they are born, m.
            rate: particles per second; it may differ from frame to frame, and a curve is integrated.
            jitter: whether births spread over the (sub)step: each particle has aged and travelled a random
                part of it.
            moving_from: where the shape was one frame ago, if it moves: a shape of the same kind, and no
                union. Each particle is born where the shape was at the moment of its birth, on the straight
                way from a point of the one to the same point of the other, so a trail has no gaps.
            key: which source this is, so whose fraction goes on: a text or an integer; calls of a system with
                the same key are the same source. None: the line of the script that calls; several calls of a
                line (or key) in a frame are sources of their own, in their order. Where emitters of a loop
                come and go, give each a key.
        """
        self._births.source(shape, rate, jitter, moving_from, key)

    @says_near_names
    def burst(self, shape: Shape | ArrayLike, count: int = 1) -> None:
        """Emit particles in a shape, once in this frame.

        Args:
            shape: where they are born, m; a point for all at one place.
            count: how many.
        """
        self._births.burst(shape, count)

    def emit(
        self,
        particles: Particles | None = None,
        /,
        *,
        position: ArrayLike | None = None,
        **columns: ArrayLike,
    ) -> None:
        """Emit the particles of these arrays, the same on every rank, one row per particle.

        Attributes that are not given come from `configure`. Vectors of 2 numbers, (n, 2), stand for (x, y,
        0).

        Args:
            particles: those that `gather("all")` or `motes.open_particles(path)[frame]` gave, with all that
                `Particles.columns` names; they get new ids, and arrays that are also given replace their
                columns.
            position: m, shape (n, 3).
            **columns: other attributes by name, shape (n, 3) or (n,).
        """
        self._births.emit(particles, position, columns)

    @says_near_names
    def spawn(
        self,
        into: System,
        *,
        on: Literal["birth", "death", "collision", "frame"],
        count: int,
        inherit_velocity: float = 0,
        where: Where = None,
    ) -> None:
        """Let events of this frame emit particles of another system.

        Children are born at the end of this frame, where the parent is then, with the attributes that
        `into.configure` has set so far. They are numbered in the order of the parents' ids.

        Args:
            into: the system that gets the children.
            on: "birth", "death", "collision" (with what it bounces off), or "frame" (being alive at its end);
                a particle counts once per rule and frame.
            count: children for each parent.
            inherit_velocity: the part of the parent's velocity that is added to a child's.
            where: which parents: those in a shape, or for which a comparison of columns holds; None: all.
        """
        self._children.spawn("spawn", recorded_of(into), into, on, count, inherit_velocity, where)

    @says_near_names
    def trail(
        self,
        into: System,
        *,
        every: float,
        count: int = 1,
        inherit_velocity: float = 0,
        where: Where = None,
    ) -> None:
        """Let particles leave particles of another system behind at regular ages.

        They do so in the frames in which their age passes a multiple of `every`, up to half a frame early:
        once per frame at most. As `spawn(on="frame")`, which says where children are born and with what.

        Args:
            into: the system that gets the children.
            every: seconds of a parent's age from one time to the next.
            count: children each time.
            inherit_velocity: the part of the parent's velocity that is added to a child's.
            where: which parents: those in a shape, or for which a comparison of columns holds; None: all.
        """
        self._children.trail(recorded_of(into), into, every, count, inherit_velocity, where)

    # --- functions of the script

    @says_near_names
    def callback(self, function: Callable[[LocalParticles], object], *, where: Where = None) -> None:
        """Call a function here in the list, on each calculator, with views of its particles.

        It must treat each particle by itself, and not depend on how many there are: newborn particles may
        come in a separate call. It is called in each sub-step. It cannot record, step or read systems.

        Args:
            function: takes `LocalParticles`.
            where: it sees only the particles in a shape or for which a comparison holds: their columns are
                copies, which are written back afterwards, and it is not called if there are none. None: all
                particles.
        """
        self._callbacks.callback(function, where)

    @says_near_names
    def pairs(self, function: Callable[[Pairs], object], radius: float, *, where: Where = None) -> None:
        """Call a function here in the list, on each calculator, with the pairs within a radius. Paper 3.1.5.

        Each pair is seen from both of its particles. The changes that the function returns are added in the
        order of the pairs; it must treat each pair by itself.

        Args:
            function: takes `Pairs`; returns the changes of velocity of the own particles, m/s, shape (n, 3),
                or None for no change.
            radius: m.
            where: which particles: those in a shape, or for which a comparison of columns holds; None: all.
        """
        self._callbacks.pairs(function, radius, where)

    @property
    def recorded(self) -> list[Any]:
        """This frame's list so far: actions and births in order."""
        return list(self._recorded.entries)

    # --- reading

    @contextmanager
    def local(self) -> Iterator[LocalParticles]:
        """Give zero-copy views of this rank's particles at this point of the script, valid inside the block.

        Ids alone are a copy. Does not communicate, but runs what was recorded so far; reading does not change
        any result. With sub-steps the views show a preview, in which all of them have run; writing into it
        makes it count, and then the rest of the list runs after it. Particles whose positions were written go
        to their owners when the frame ends. The frame cannot end inside the block.

        Yields:
            The views: `p.position` (n, 3), `p.id` (n,), ...
        """
        session, recorded = self._session, self._recorded
        engine = session.begin("local()", reads=True)
        try:
            preview = engine.run_pending(recorded.index)
        finally:
            session.end()
        refuse = None if session.recording is None else partial(self._refuse_writing, session.recording)
        view = LocalParticles(
            engine,
            recorded.index,
            recorded.attributes,
            refuse_writing=refuse,
            preview=preview,
            watched=session.survives,
        )
        recorded.views.append(len(recorded.entries))
        session.open_views.append(recorded)
        if recorded.first is not None:
            recorded.first.free = True
        try:
            yield view
            keep_preview(view)
        finally:
            session.open_views.remove(recorded)
            recorded.views.pop()
            if close_views(view) and not recorded.views:
                engine.release_views(recorded.index)
            engine.touched(recorded.index)

    def _refuse_writing(self, recording: Recording) -> NoReturn:
        recording.refuse(self._session.frame, f"the script writes particles of '{self.name}'")

    @says_near_names
    def gather(self, *, to: Literal[0, "all"] = 0, unwrapped: bool = False) -> Particles:
        """Copy all particles, sorted by id. Collective.

        Args:
            to: 0: to rank 0 alone; "all": to every rank.
            unwrapped: where particles of a periodic world would be had they never wrapped: `position` is
                float64, and `crossings` is left out.

        Returns:
            The particles; elsewhere the result is falsy and empty.
        """
        from .gathering import gathered

        return gathered(self._recorded, to, unwrapped)

    @says_near_names
    def total(self, expression: Expression | ArrayLike, *, where: Where = None) -> Any:
        """Sum an expression over all particles. Collective.

        The exact sum of the expression's float32 values, rounded once, whatever the ranks, threads and order;
        so it equals `math.fsum` of these values. With NaN, or both infinities, it is NaN; with one infinity
        it is that one; of no particles it is 0. `total(1)` counts.

        Args:
            expression: a number or a vector per particle.
            where: which particles: those in a shape, or for which a comparison of columns holds; None: all.

        Returns:
            A float, or for a vector an array of 3; on every rank.
        """
        return self._sums.total(expression, where)

    @says_near_names
    def histogram(
        self,
        expression: Expression,
        edges: ArrayLike,
        weights: Expression | float | None = None,
        *,
        where: Where = None,
    ) -> NDArray[Any]:
        """Count particles by an expression, or sum `weights` in each bin. Collective.

        Bin i holds edges[i] <= value < edges[i + 1], the last one its upper edge too, as in
        `numpy.histogram`. Values outside and NaN are left out.

        Args:
            expression: a number per particle.
            edges: ascending numbers, at least 2; the outer ones may be infinite.
            weights: what is added up in each bin; None: particles are counted.
            where: which particles: those in a shape, or for which a comparison of columns holds; None: all.

        Returns:
            Counts, int64, or sums, float64, exact and rounded once as those of `total`; on every rank.
        """
        return self._sums.histogram(expression, edges, weights, where)

    @says_near_names
    def tally(
        self,
        low: ArrayLike,
        high: ArrayLike,
        shape: Sequence[int],
        weights: Expression | float | None = None,
        *,
        where: Where = None,
    ) -> NDArray[Any]:
        """Count particles in a grid of cells, or sum `weights` in each. Collective.

        The cells' edges are those of `numpy.linspace(low[0], high[0], nx + 1)` and so on; a cell holds its
        lower faces, not its upper ones. Particles outside are left out.

        Args:
            low: the grid's lowest corner, m.
            high: its highest corner, m.
            shape: the number of cells along each axis, (nx, ny, nz).
            weights: what is added up in each cell; None: particles are counted.
            where: which particles: those in a shape, or for which a comparison of columns holds; None: all.

        Returns:
            Counts, int64, or sums, float64, exact and rounded once as those of `total`, indexed [ix, iy, iz];
            on every rank.
        """
        return self._sums.tally(low, high, shape, weights, where)

    # --- what is known without asking other ranks

    @property
    def sprite(self) -> Sprite:
        """How the particles are drawn; may change between frames."""
        return self._recorded.sprite

    @sprite.setter
    def sprite(self, value: Sprite) -> None:
        check_change(self._recorded.sprite, value)
        native = native_of(value, self._recorded.columns)
        with self._session.usage.during("setting the sprite"):
            self._recorded.sprite = value
            if self._session.engine is not None:
                self._session.engine.set_sprite(self._recorded.index, native)

    @property
    def axis(self) -> str | None:
        """What its domains cut: one axis (slabs), several (bricks), a curve, or None (dealt out by id)."""
        return None if self._recorded.axes == "id" else self._recorded.axes

    @property
    def count(self) -> int:
        """Particles on all ranks, as last agreed."""
        return 0 if self._session.engine is None else self._session.engine.count(self._recorded.index)

    @property
    def born(self) -> int:
        """Particles born so far: the next id."""
        return 0 if self._session.engine is None else self._session.engine.born(self._recorded.index)

    @property
    def dropped(self) -> int:
        """Births that the capacity has dropped so far."""
        return 0 if self._session.engine is None else self._session.engine.dropped(self._recorded.index)

    @property
    def cuts(self) -> NDArray[Any]:
        """The cuts between domains, as last agreed; one fewer than calculators.

        Slabs: their positions (m), ascending, float32. By id (`axis=None`) or along a curve: the same, on the
        interval 0..1.
        Bricks: records with the fields `axis` ("x", "y" or "z") and `at` (m), in the order of the domains
        between which they stand: of n domains the first n // 2 lie below cut n // 2 - 1, and so on.
        """
        if self._session.engine is None:
            raise MotesError("cuts exist inside `with world:` only")
        tree = self._session.engine.cuts(self._recorded.index)
        if are_bricks(self._recorded.axes):
            return np.array([("xyz"[axis], at) for axis, at in tree], CUT)
        return np.array([at for _, at in tree], np.float32)

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse what is not an attribute of the system, and say how to set a particle's attribute."""
        if name.startswith("_") or name == "sprite":
            object.__setattr__(self, name, value)
        else:
            self._refuse(name)

    def _refuse(self, name: str) -> NoReturn:
        if name in self._recorded.attributes:
            raise NotAssignableError(
                f"{name} belongs to particles, not to a system: configure({name}=...) gives it to newborn "
                f"particles, set({name}=...) to living ones"
            )
        if hasattr(type(self), name) or name in ("world", "name"):
            raise NotAssignableError(f"{name} of a system cannot be assigned")
        known = ["sprite", *self._recorded.attributes]
        raise NotAssignableError(f"a system has no attribute {name!r} to assign{near(name, known)}")

    def __getattr__(self, name: str) -> Any:
        """Raise the error for an attribute that does not exist, with what to use instead."""
        recorded = self.__dict__.get("_recorded")
        if recorded is not None and name in recorded.attributes:
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


def recorded_of(system: object) -> Recorded | None:
    """Return what the package knows of a system of the script; None for anything else."""
    return system._recorded if isinstance(system, System) else None
