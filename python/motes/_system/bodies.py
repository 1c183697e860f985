"""Bodies: cloths and ropes of tied particles, and clumps, particles that are groups of spheres."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from .._values import arguments
from .._values.ties import Ties
from .._values.values import says_near_names
from ..errors import ArgumentError
from .action_methods import ActionMethods
from .births import Births
from .system_state import SystemState

if TYPE_CHECKING:
    from .._values.clump import Clump

__all__ = ["Bodies"]

LEAST_MASS, MOST_MASS = 1e-30, 1e30  # kg


class Bodies(ActionMethods):
    """Methods that create bodies of a system's particles."""

    _state: SystemState
    _births: Births

    @says_near_names
    def cloth(
        self,
        rows: int,
        columns: int,
        origin: ArrayLike,
        along: ArrayLike,
        across: ArrayLike,
        pinned: Iterable[tuple[int, int]] = (),
    ) -> Ties:
        """Emit rows x columns particles, tied into a cloth; ids are in row-major order.

        Args:
            rows: number of rows, at least 2.
            columns: number of columns, at least 2.
            origin: position of row 0, column 0, m.
            along: vector from `origin` to the last row, m.
            across: vector from `origin` to the last column, m.
            pinned: (row, column) of particles that only the script moves.

        Returns:
            The ties, for `tie`.
        """
        from .fabrics import cloth

        return cloth(self._births, rows, columns, origin, along, across, pinned)

    @says_near_names
    def rope(self, start: ArrayLike, end: ArrayLike, count: int, pinned: Iterable[int] = ()) -> Ties:
        """Emit particles in a straight line, tied into a rope.

        Args:
            start: position of the first particle, m.
            end: position of the last particle, m.
            count: number of particles, at least 2.
            pinned: indices, 0..count - 1, of particles that only the script moves.

        Returns:
            The ties, for `tie`.
        """
        from .fabrics import rope

        return rope(self._births, start, end, count, pinned)

    @says_near_names
    def clumps(
        self,
        template: ArrayLike | Clump,
        *,
        density: float | None = None,
        position: ArrayLike | None = None,
        **columns: ArrayLike,
    ) -> Clump:
        """Make each particle of this system a clump: a rigid group of spheres that collide by `contact`.

        A clump is one particle: `position` is its centre of mass, `orientation` rotates the template, `spin`
        is its angular velocity (rad/s), `mass` its total mass, and `size[0]` scales the template (default 1).
        Record `contact` once per frame; `move` rotates clumps. Sprites draw each sphere; a mesh is drawn once
        per clump.

        Args:
            template: x, y, z and radius of 1 to 64 spheres, m, shape (n, 4); spheres may overlap. One
                template per system, given before its first particles are born.
            density: kg/m^3; configures the `mass` of newborn clumps of size 1. None: leaves `mass` unchanged.
            position: positions of clumps to emit now, m, shape (n, 3); None: emits none.
            **columns: other attributes of these clumps, as for `emit`.

        Returns:
            The template: `volume`, `inertia`, `radius`, `center`.
        """
        from .._values.clump import as_clump

        clump = as_clump(template)
        mass = None if density is None else _mass(density, clump)
        if position is None and columns:
            raise ArgumentError("position", position, "given with columns of clumps")
        state = self._state
        with state.session.usage.during("clumps()"):
            known = state.newborn.clump
            if known != clump and (known is not None or state.has_births):
                allowed = f"the only one of '{state.name}', given before its first births"
                raise ArgumentError("template", template, allowed)
            state.newborn.clump = clump
            if state.session.engine is not None:
                state.tell_clump(state.session.engine)
        if mass is not None:
            state.newborn.configure({"mass": mass})
        if position is not None:
            self._births.emit(None, position, columns)
        return clump


def _mass(density: float, clump: Clump) -> float:
    mass = arguments.number("density", density, low=0) * clump.volume
    if not LEAST_MASS < mass < MOST_MASS:
        allowed = f"such that a clump's mass, {mass:.3g} kg, is {LEAST_MASS:g} to {MOST_MASS:g} kg"
        raise ArgumentError("density", density, allowed)
    return mass
