"""System: the particles that obey the same lines of the script (paper 3.1.3)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, NoReturn, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._particles.particles import LocalParticles, Particles, close_views, keep_preview
from .._picture.sprites import Sprite, check_change
from .._run.scenefile import Recording
from .._values.curves import Curve
from .._values.space import are_bricks
from .._values.values import at, joined, says_near_names
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
from .sums import Sums
from .system_state import SystemState

if TYPE_CHECKING:
    from .._world.world import World
    from ..shapes._mesh import Mesh

__all__ = ["System", "state_of"]

CUT = np.dtype([("axis", "U1"), ("at", np.float32)])


class System(Bodies):
    """A particle system, created by `World.system`. Calls are recorded, and run when the frame ends.

    Every rank makes the same calls in the same order; the engine gives each its role. The recording methods
    do not communicate. They raise MotesError outside `with world:`, inside a callback, and while another
    thread uses the world.
    """

    world: World
    """The world to which the system belongs."""
    name: str

    def __init__(self, world: World, state: SystemState) -> None:
        """Create a system of a world; scripts call `World.system`.

        Args:
            world: the world.
            state: the package's internal state of the system.
        """
        super().__init__(Listing(state, state_of).record)
        self.__dict__.update(world=world, name=state.name)
        self._state = state
        self._session = state.session
        self._births = Births(state)
        self._children = Children(state)
        self._callbacks = Callbacks(state)
        state.called = self._callbacks.called
        self._sums = Sums(state)

    # --- births

    @overload
    def configure(self, **state: Unpack[State]) -> None: ...
    @overload
    def configure(self, **state: Drawn) -> None: ...
    def configure(self, **state: Any) -> None:
        """Set attributes of newborn particles from here on; attributes set by earlier calls remain.

        Args:
            **state: velocity, color, lifetime, a user-defined attribute, ... Each is a value, a shape (drawn
                uniformly from it), `Uniform(lo, hi)` or `Normal(mean, sigma)`; a `motes.Curve` is evaluated
                at each frame's start.
        """
        state = {name: joined(value) for name, value in state.items()}
        self._state.newborn.configure(state)
        if self._state.first is not None:
            time = self._session.time
            self._state.first.configured({name: at(value, time) for name, value in state.items()})

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

        By the end of each frame (or sub-step) the source has emitted floor(S) particles in total, where S is
        the sum of rate times `dt` over the frames that called it. Fractions of a particle carry over, even
        while the rate is 0 or the source is not called. Paper 3.2.1.

        Args:
            shape: where particles are born, m.
            rate: particles per second; it may differ from frame to frame, and a curve is integrated.
            jitter: whether births are spread over the (sub)step: each particle has already aged and moved for
                a random part of it.
            moving_from: the shape one frame ago, if it moves: of the same kind, and no Union. Each particle
                is born where the shape was at its moment of birth, so a trail has no gaps. Points of the
                shape move in straight lines.
            key: identifies the source whose fraction carries over: a string or an integer; calls with the
                same key are the same source. None: the calling line of the script. Several calls with one
                line (or key) in a frame are separate sources, told apart by their order. If emitters of a
                loop come and go, give each a key.
        """
        self._births.source(shape, rate, jitter, moving_from, key)

    @says_near_names
    def burst(self, shape: Shape | ArrayLike, count: int = 1) -> None:
        """Emit particles in a shape, once in this frame.

        Args:
            shape: where particles are born, m; at a point, all are born there.
            count: the number of particles.
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
        """Emit particles given as arrays with one row per particle, the same on every rank.

        Attributes that are not given come from `configure`. Vectors of 2 numbers, (n, 2), stand for (x, y,
        0).

        Args:
            particles: the result of `gather("all")` or `motes.open_particles(path)[frame]`, to emit with all
                columns of `Particles.columns`; they get new ids, and arrays passed as well replace their
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

        Children are born at the parent's position at the end of this frame, with the attributes that
        `into.configure` has set so far. Their ids follow the order of the parents' ids.

        Args:
            into: the system that gets the children.
            on: "birth", "death", "collision" (with what it bounces off), or "frame" (alive at the frame's
                end); a particle triggers each rule at most once per frame.
            count: children per parent.
            inherit_velocity: the fraction of the parent's velocity that is added to the child's.
            where: which parents: those inside a shape, or those that satisfy a comparison of columns; None:
                all.
        """
        self._children.spawn("spawn", state_of(into), into, on, count, inherit_velocity, where)

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
        """Let particles emit particles of another system at regular ages.

        A parent emits in each frame in which its age passes a multiple of `every`, up to half a frame early
        and at most once per frame. Children are born as in `spawn(on="frame")`.

        Args:
            into: the system that gets the children.
            every: seconds of a parent's age between two emissions.
            count: children per emission.
            inherit_velocity: the fraction of the parent's velocity that is added to the child's.
            where: which parents: those inside a shape, or those that satisfy a comparison of columns; None:
                all.
        """
        self._children.trail(state_of(into), into, every, count, inherit_velocity, where)

    # --- functions of the script

    @says_near_names
    def callback(self, function: Callable[[LocalParticles], object], *, where: Where = None) -> None:
        """Call a function here in the list, on each calculator, with views of its particles.

        The function must treat particles independently and not depend on their number: newborn particles may
        come in a separate call. It is called in each sub-step. It cannot record, step or read systems.

        Args:
            function: takes `LocalParticles`.
            where: which particles the function sees: those inside a shape, or those that satisfy a comparison
                of columns. Their columns are copies, which are written back afterwards; without such
                particles the function is not called. None: all.
        """
        self._callbacks.callback(function, where)

    @says_near_names
    def pairs(self, function: Callable[[Pairs], object], radius: float, *, where: Where = None) -> None:
        """Call a function here in the list, on each calculator, with the pairs within a radius. Paper 3.1.5.

        Each pair appears twice, once for each of its particles. The function must treat pairs independently;
        the changes that it returns are added in the order of the pairs.

        Args:
            function: takes `Pairs`; returns the changes of the particles' velocities, m/s, shape (n, 3), or
                None for no change.
            radius: largest distance between the particles of a pair, m.
            where: which particles: those inside a shape, or those that satisfy a comparison of columns; None:
                all.
        """
        self._callbacks.pairs(function, radius, where)

    @property
    def recorded(self) -> list[Any]:
        """This frame's list so far: actions and births in order."""
        return list(self._state.entries)

    # --- reading

    @contextmanager
    def local(self) -> Iterator[LocalParticles]:
        """Give zero-copy views of this rank's particles at this point of the script, valid inside the block.

        Only ids are a copy. Does not communicate, but runs the calls recorded so far; reading does not change
        any result. With sub-steps, the views show a preview in which all sub-steps have run; writing into a
        view makes the preview the actual state, and the rest of the list runs after it. Particles whose
        positions were written migrate to their owners when the frame ends. The frame cannot end inside the
        block.

        Yields:
            The views: `p.position` (n, 3), `p.id` (n,), ...
        """
        session, state = self._session, self._state
        engine = session.begin("local()", reads=True)
        try:
            preview = engine.run_pending(state.index)
        finally:
            session.end()
        refuse = None if session.recording is None else partial(self._refuse_writing, session.recording)
        view = LocalParticles(
            engine,
            state.index,
            state.attributes,
            refuse_writing=refuse,
            preview=preview,
            watched=session.survives,
        )
        state.views.append(len(state.entries))
        session.open_views.append(state)
        if state.first is not None:
            state.first.free = True
        try:
            yield view
            keep_preview(view)
        finally:
            session.open_views.remove(state)
            state.views.pop()
            if close_views(view) and not state.views:
                engine.release_views(state.index)
            engine.touched(state.index)

    def _refuse_writing(self, recording: Recording) -> NoReturn:
        recording.refuse(self._session.frame, f"the script writes particles of '{self.name}'")

    @says_near_names
    def gather(self, *, to: Literal[0, "all"] = 0, unwrapped: bool = False) -> Particles:
        """Copy all particles, sorted by id. Collective.

        Args:
            to: 0: only to rank 0; "all": to every rank.
            unwrapped: whether to return positions in a periodic world as if they had never wrapped:
                `position` is float64, and `crossings` is left out.

        Returns:
            The particles; on ranks that do not get them, the result is falsy and empty.
        """
        from .gathering import gathered

        return gathered(self._state, to, unwrapped)

    @says_near_names
    def surface(self, cell: float, *, radius: float | None = None) -> Mesh:
        """Return the surface of all particles as a closed mesh, such as the skin of a liquid. Collective.

        A particle alone becomes a ball of `radius`. Particles up to about 2 * `radius` apart merge: the
        surface of a block of particles 2 * `radius` apart is flat, `radius` outside the outer centres. It
        does not reach across periodic borders: there it is closed on both sides. Particles whose position is
        not finite are left out.

        Args:
            cell: side of the cells that the surface is cut into, m: 1/16 to 2 times `radius`. Half of it is
                fine enough for most uses.
            radius: radius of a particle, m: half the distance between neighbours; None: `cell`.

        Returns:
            The mesh, the same on every rank, and for any number of ranks. `Solid` draws it, `Mesh.save`
            writes it to a file.

        Raises:
            ArgumentError: if there are no particles, an argument is out of range, or the grid would not fit
                in memory: the cells near particles are too many (2 GB), or too far from the origin.
        """
        from .surfacing import surfaced

        return surfaced(self._state, cell, radius)

    @says_near_names
    def total(self, expression: Expression | ArrayLike, *, where: Where = None) -> Any:
        """Sum an expression over all particles. Collective.

        The sum of the expression's float32 values is exact and rounded once, as by `math.fsum`, independent
        of ranks, threads and order. It is NaN if a value is NaN or both infinities occur, infinite if one
        occurs, and 0 without particles. `total(1)` counts particles.

        Args:
            expression: a number or a vector per particle.
            where: which particles: those inside a shape, or those that satisfy a comparison of columns; None:
                all.

        Returns:
            On every rank, a float, or for a vector an array of 3.
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

        Bin i holds edges[i] <= value < edges[i + 1]; the last bin includes its upper edge, as in
        `numpy.histogram`. NaN and values outside the edges are left out.

        Args:
            expression: a number per particle.
            edges: ascending numbers, at least 2; the first and the last may be infinite.
            weights: the expression to sum in each bin; None: count particles.
            where: which particles: those inside a shape, or those that satisfy a comparison of columns; None:
                all.

        Returns:
            On every rank, counts (int64), or sums (float64), exact and rounded once like those of `total`.
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

        Along x the cells' edges are `numpy.linspace(low[0], high[0], nx + 1)`, and so on; a cell includes its
        lower faces, but not its upper ones. Particles outside the grid are left out.

        Args:
            low: the grid's lowest corner, m.
            high: the grid's highest corner, m.
            shape: the number of cells along each axis, (nx, ny, nz).
            weights: the expression to sum in each cell; None: count particles.
            where: which particles: those inside a shape, or those that satisfy a comparison of columns; None:
                all.

        Returns:
            On every rank, counts (int64), or sums (float64), exact and rounded once like those of `total`,
            indexed [ix, iy, iz].
        """
        return self._sums.tally(low, high, shape, weights, where)

    # --- known without communication

    @property
    def sprite(self) -> Sprite:
        """How the particles are drawn; may change between frames."""
        return self._state.sprite

    @sprite.setter
    def sprite(self, value: Sprite) -> None:
        check_change(self._state.sprite, value)
        with self._session.usage.during("setting the sprite"):
            self._state.show_as(value, self._session.engine)

    @property
    def axis(self) -> str | None:
        """What its domains cut: one axis (slabs), several (bricks), a curve, or None (assigned by id)."""
        return None if self._state.axes == "id" else self._state.axes

    @property
    def count(self) -> int:
        """The number of particles on all ranks, as last agreed."""
        return 0 if self._session.engine is None else self._session.engine.count(self._state.index)

    @property
    def born(self) -> int:
        """The number of particles born so far, which is the next id."""
        return 0 if self._session.engine is None else self._session.engine.born(self._state.index)

    @property
    def dropped(self) -> int:
        """The number of births dropped so far because the system was at capacity."""
        return 0 if self._session.engine is None else self._session.engine.dropped(self._state.index)

    @property
    def cuts(self) -> NDArray[Any]:
        """The cuts between domains, as last agreed; one fewer than calculators.

        Slabs: the cuts' positions (m), ascending, float32. By id (`axis=None`) or along a curve: positions
        within 0..1.
        Bricks: records with the fields `axis` ("x", "y" or "z") and `at` (m), in the order of the domains
        that they separate: of n domains, the first n // 2 lie below cut n // 2 - 1, and so on recursively.
        """
        if self._session.engine is None:
            raise MotesError("cuts exist only inside `with world:`")
        tree = self._session.engine.cuts(self._state.index)
        if are_bricks(self._state.axes):
            return np.array([("xyz"[axis], at) for axis, at in tree], CUT)
        return np.array([at for _, at in tree], np.float32)

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse names other than `sprite`; for a particle's attribute, say how to set it."""
        if name.startswith("_") or name == "sprite":
            object.__setattr__(self, name, value)
        else:
            self._refuse(name)

    def _refuse(self, name: str) -> NoReturn:
        if name in self._state.attributes:
            raise NotAssignableError(
                f"{name} belongs to particles, not to a system: configure({name}=...) gives it to newborn "
                f"particles, set({name}=...) to living ones"
            )
        if hasattr(type(self), name) or name in ("world", "name"):
            raise NotAssignableError(f"{name} of a system cannot be assigned")
        known = ["sprite", *self._state.attributes]
        raise NotAssignableError(f"a system has no attribute {name!r} to assign{near(name, known)}")

    def __getattr__(self, name: str) -> Any:
        """Raise AttributeError, with a hint at what to use instead."""
        state = self.__dict__.get("_state")
        if state is not None and name in state.attributes:
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


def state_of(system: object) -> SystemState | None:
    """Return the internal state of a script's system; None for anything else."""
    return system._state if isinstance(system, System) else None
