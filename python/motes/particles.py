"""Particles as NumPy arrays: views of this rank's, copies of everybody's."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from .errors import MotesError
from .written_views import noticing

__all__ = ["LocalParticles", "Particles"]


class LocalParticles:
    """Views of this rank's particles of one system: `p.position` (n, 3), `p.age` (n,), `p.id` (n,), ...

    Writing to a view changes the particles; ids are read-only. An attribute that had one value for all
    particles gets memory when it is asked for. The order of particles means nothing.
    """

    def __init__(
        self,
        engine: _core.Engine,
        system: int,
        attributes: dict[str, tuple[int, int]],
        begin: int = 0,
        chosen: NDArray[np.uint32] | None = None,
        *,
        read_only: bool = False,
        preview: bool = False,
    ) -> None:
        """Belong to `System.local`: see particles `begin`.. or those at the indices `chosen`.

        `read_only` forbids writing. `preview`: what is read is a copy that counts where it is written.
        """
        self._begin = 0 if chosen is not None else begin
        self._chosen = chosen
        self._read_only = read_only
        self._engine: _core.Engine | None = engine
        self._system = system
        self._attributes = attributes
        self._views: dict[str, NDArray[Any]] = {}
        self._before: dict[str, bytes] | None = {} if preview else None
        self._written = False

    def __len__(self) -> int:
        """Particles on this rank."""
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
                view.flags.writeable = name != "id"
            if self._read_only:
                view.flags.writeable = False
            elif self._before is not None and name != "id":
                self._before[name] = view.tobytes()
                view = noticing(view, self._note_write)
            self._views[name] = view
        return self._views[name]

    def _column(self, name: str) -> NDArray[Any]:
        engine = self._live()
        if name == "id":
            return engine.local_ids(self._system, self._begin)
        if name in self._attributes:
            return engine.local_column(self._system, self._attributes[name][0], self._begin)
        known = ", ".join(["id", *self._attributes])
        raise AttributeError(f"no attribute {name!r}; there are {known}")

    def _write_back(self) -> None:
        """Give the particles what was written to the copies of those chosen."""
        for name, copy in self._views.items() if self._chosen is not None else ():
            if name != "id":
                self._column(name)[self._chosen] = copy

    def _note_write(self) -> None:
        self._written = True

    def _keep_preview(self) -> None:
        """End a preview: it counts where the script wrote into it."""
        if self._written:
            self._live().keep_preview(self._system)
            return
        for name, before in (self._before or {}).items():
            if self._views[name].tobytes() != before:
                raise MotesError(
                    f"particles.{name} was written behind its back; with sub-steps, write into the view "
                    f"itself: particles.{name}[...] = ..."
                )

    def _live(self) -> _core.Engine:
        if self._engine is None:
            raise MotesError("views of particles are valid inside `with system.local() as p:` only")
        return self._engine

    def _close(self) -> None:
        for view in self._views.values():
            view.flags.writeable = False  # a view that was kept must not change particles any more
        self._views.clear()
        self._engine = None


class Particles:
    """Copies of all particles of a system, sorted by id; falsy on ranks that did not get them."""

    def __init__(self, columns: dict[str, NDArray[Any]] | None) -> None:
        """Take the engine's columns in any order of particles."""
        self._here = columns is not None
        self._columns: dict[str, NDArray[Any]] = {}
        if columns is not None:
            order = np.argsort(columns["id"], kind="stable")
            self._columns = {name: column[order] for name, column in columns.items()}

    def __bool__(self) -> bool:
        """Whether this rank got the particles, be there any or none."""
        return self._here

    def __len__(self) -> int:
        """How many particles."""
        return len(self._columns["id"]) if self._here else 0

    def __getattr__(self, name: str) -> NDArray[Any]:
        """Return a column: (n, 3) or (n,)."""
        columns = self.__dict__.get("_columns", {})
        if name in columns:
            return columns[name]  # type: ignore[no-any-return]
        if not name.startswith("_") and not self.__dict__.get("_here", True):
            raise AttributeError(f"{name!r}: the particles were gathered on another rank")
        raise AttributeError(f"no attribute {name!r}; there are {', '.join(columns)}")

    def __dir__(self) -> list[str]:
        """List the columns."""
        return [*super().__dir__(), *self._columns]

    def __repr__(self) -> str:
        """Show how many there are."""
        return f"<{len(self)} particles>" if self._here else "<particles gathered elsewhere>"
