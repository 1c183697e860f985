"""Particles as NumPy arrays: views of this rank's particles, copies of all ranks' particles."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from .. import _extras
from ..errors import ArgumentError, MotesError, NotAssignableError, NotHereError, near
from . import by_id
from .written_views import noticing

if TYPE_CHECKING:
    from .. import _core

__all__ = ["LocalParticles", "Particles", "close_views", "keep_preview", "write_back"]


class LocalParticles:
    """Views of this rank's particles of one system: `p.position` (n, 3), `p.age` (n,), `p.id` (n,), ...

    Writing into a view changes the particles: `p.velocity[:] = ...`. `p.id` is a read-only copy. Memory for
    an attribute that has one value for all particles is allocated when the attribute is read. The order of
    particles has no meaning. When the block ends, views become read-only, and writing into arrays made from
    them no longer changes particles.
    """

    __slots__ = (
        "_attributes",
        "_before",
        "_begin",
        "_chosen",
        "_engine",
        "_refuse_writing",
        "_strict",
        "_system",
        "_views",
        "_written",
    )

    _engine: _core.Engine | None
    _views: dict[str, NDArray[Any]]
    _refuse_writing: Callable[[], NoReturn] | None
    _before: dict[str, bytes] | None
    _strict: bool
    _written: bool
    _attributes: dict[str, tuple[int, int]]
    _chosen: NDArray[np.uint32] | None
    _system: int
    _begin: int

    def __init__(
        self,
        engine: _core.Engine,
        system: int,
        attributes: dict[str, tuple[int, int]],
        begin: int = 0,
        chosen: NDArray[np.uint32] | None = None,
        *,
        refuse_writing: Callable[[], NoReturn] | None = None,
        preview: bool = False,
        watched: bool = False,
    ) -> None:
        """Create views of the particles from `begin` on, or of those at the indices `chosen`.

        `refuse_writing` makes the views read-only: it is called when the script writes, and raises.
        `preview`: views show a copy, which is discarded unless the script writes into it. `watched`: the
        engine is notified of any write.
        """
        self._engine = engine
        self._system = system
        self._attributes = attributes
        self._begin = 0 if chosen is not None else begin
        self._chosen = chosen
        self._views = {}
        self._refuse_writing = refuse_writing
        self._before = {} if preview or watched else None
        self._strict = preview
        self._written = False

    def __len__(self) -> int:
        """Return the number of particles in the views."""
        size = self._live().local_size(self._system) - self._begin
        return size if self._chosen is None else len(self._chosen)

    def __getattr__(self, name: str) -> NDArray[Any]:
        """Return the view of an attribute."""
        if name.startswith("_"):
            raise AttributeError(name)
        self._live()
        if name not in self._views:
            view = self._column(name)
            if self._chosen is not None:
                view = view[self._chosen]
            if name == "id":
                view.flags.writeable = False
            elif self._refuse_writing is not None:
                view = noticing(view, self._refuse_writing)
                view.flags.writeable = False
            elif self._before is not None:
                if not name.endswith("_b") or self._live().keeps_copies(self._system):
                    self._before[name] = view.tobytes()
                view = noticing(view, self._note_write)
            self._views[name] = view
        return self._views[name]

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse to replace a view: `p.velocity[:] = ...` writes into it."""
        if name.startswith("_"):
            object.__setattr__(self, name, value)
        elif value is not self._views.get(name):  # as after `p.velocity *= 2`, done in place
            _refuse(name, self._names())

    def __dir__(self) -> list[str]:
        """List the attributes."""
        return [*super().__dir__(), *self._names()]

    def _names(self) -> list[str]:
        return ["id", *self._attributes]

    def _column(self, name: str) -> NDArray[Any]:
        engine = self._live()
        if name == "id":
            return engine.local_ids(self._system, self._begin)
        if name in self._attributes:
            return engine.local_column(self._system, self._attributes[name][0], self._begin)
        raise _unknown(name, self._names())

    def _note_write(self) -> None:
        self._written = True

    def _live(self) -> _core.Engine:
        if self._engine is None:
            raise MotesError("views of particles are valid only inside `with system.local() as p:`")
        return self._engine


def write_back(particles: LocalParticles) -> None:
    """Copy the views of chosen particles, which are copies, back to the particles."""
    for name, copy in particles._views.items() if particles._chosen is not None else ():
        if name != "id":
            particles._column(name)[particles._chosen] = copy


def keep_preview(particles: LocalParticles) -> None:
    """End a preview: keep it if the script wrote into it."""
    if particles._written:
        particles._live().keep_preview(particles._system)
        return
    for name, before in (particles._before or {}).items():
        if particles._views[name].tobytes() == before:
            continue
        if particles._strict:
            raise MotesError(
                f"particles.{name} was changed without writing into its view; with sub-steps, write into "
                f"the view itself: particles.{name}[...] = ..."
            )
        return particles._live().keep_preview(particles._system)


def close_views(particles: LocalParticles) -> bool:
    """Close the views; return whether any of them showed the particles' own memory."""
    handed_out = bool(particles._views) and particles._chosen is None
    for view in particles._views.values():
        view.flags.writeable = False
    particles._views.clear()
    particles._engine = None
    return handed_out


class Particles:
    """Copies of all particles of a system, sorted by id; falsy on ranks that did not get them."""

    def __init__(self, columns: dict[str, NDArray[Any]] | None) -> None:
        """Store columns, sorted by id; scripts use `System.gather` and `motes.open_particles`.

        Args:
            columns: the columns by name, with particles in any order; None: they are on another rank.
        """
        self._here = columns is not None
        self._columns: dict[str, NDArray[Any]] = {}
        if columns is not None:
            order = by_id.order(columns["id"])
            self._columns = {
                name: np.require(column, requirements=("C", "W"))
                if order is None
                else column.take(order, axis=0)
                for name, column in columns.items()
            }

    def __bool__(self) -> bool:
        """Return whether this rank got the particles, even if there are none."""
        return self._here

    def __len__(self) -> int:
        """Return the number of particles; 0 if they are on another rank."""
        return len(self._columns["id"]) if self._here else 0

    def __getattr__(self, name: str) -> NDArray[Any]:
        """Return a column: (n,), (n, 3) or (n, 4)."""
        columns = self.__dict__.get("_columns", {})
        if name in columns:
            return columns[name]  # type: ignore[no-any-return]
        if not name.startswith("_") and not self.__dict__.get("_here", True):
            raise AttributeError(f"{name!r}: the particles were gathered on another rank")
        raise _unknown(name, columns)

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse to replace a column: `q.velocity[:] = ...` writes into the copy."""
        if name.startswith("_"):
            object.__setattr__(self, name, value)
        elif value is not self._columns.get(name):
            _refuse(name, self._columns)

    def __dir__(self) -> list[str]:
        """List the columns."""
        return [*super().__dir__(), *self._columns]

    def columns(self, *names: str) -> dict[str, NDArray[Any]]:
        """Return columns by name.

        Args:
            *names: names of columns; none: those that `s.emit(p)` emits, that is, all but the ids, and
                without the copies of birth values (`position_b` and so on) if the system kept none.

        Returns:
            Arrays of shape (n,), (n, 3) or (n, 4), not copied.

        Raises:
            NotHereError: if the particles are on another rank.
        """
        if not self._here:
            raise NotHereError("the particles were gathered on another rank")
        for name in names:
            if name not in self._columns:
                raise ArgumentError("columns", name, ", ".join(self._columns), known=self._columns)
        kept = "up_b" not in self._columns or bool(self._columns["up_b"].any())
        left_out = {"id"} if kept else {"id", "position_b", "velocity_b", "up_b"}
        wanted = names or [name for name in self._columns if name not in left_out]
        return {name: self._columns[name] for name in wanted}

    def to_frame(self) -> Any:
        """Convert to a pandas DataFrame. Needs the extra [analysis].

        Returns:
            One row per particle; vectors become columns name_x, name_y, name_z, quaternions also name_w.

        Raises:
            NotHereError: if the particles are on another rank.
        """
        columns = {name: self._columns[name] for name in ("id", *self.columns())}
        pandas = _extras.pandas("Particles.to_frame")
        flat = {
            f"{name}_{axis}" if axis else name: column[:, "xyzw".index(axis)] if axis else column
            for name, column in columns.items()
            for axis in ("xyzw"[: column.shape[1]] if column.ndim == 2 else ("",))
        }
        return pandas.DataFrame(flat)

    def __repr__(self) -> str:
        """Show the number of particles."""
        return f"<{len(self)} particles>" if self._here else "<particles gathered elsewhere>"

    def _repr_html_(self) -> str:
        """Return HTML for notebooks: the number of particles and the range of each column."""
        if not self._here:
            return "<i>particles gathered elsewhere</i>"
        rows = "".join(
            f"<tr><th>{name}</th>"
            + "".join(f"<td>{_range_of(part)}</td>" for part in _components(column))
            + "</tr>"
            for name, column in self._columns.items()
        )
        return f"<b>{len(self):,} particles</b><table>{rows}</table>"


def _components(column: NDArray[Any]) -> list[NDArray[Any]]:
    return [column] if column.ndim == 1 else list(column.T)


def _range_of(values: NDArray[Any]) -> str:
    if not len(values):
        return "-"
    low, high = np.fmin.reduce(values), np.fmax.reduce(values)
    ends = [str(end) if values.dtype.kind in "iu" else f"{end:.4g}" for end in (low, high)]
    return ends[0] if ends[0] == ends[1] else " .. ".join(ends)


def _unknown(name: str, known: Iterable[str]) -> AttributeError:
    text = f"no attribute {name!r}{near(name, known)}; there are {', '.join(known)}"
    return AttributeError(text, name=name, obj=None)


def _refuse(name: str, known: Iterable[str]) -> NoReturn:
    if name not in known:
        raise NotAssignableError(str(_unknown(name, known)))
    raise NotAssignableError(
        f"particles.{name} cannot be replaced; write into the array: particles.{name}[:] = ..."
    )
