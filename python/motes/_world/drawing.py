"""draw: pictures of particles that another program keeps in arrays on the ranks of a communicator."""

from __future__ import annotations

import atexit
import os
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._mpi import rank_process
from .._picture.frame import Frame
from .._picture.rendering import Renderer
from .._picture.sprites import Sprite
from .._run import collectives, open_worlds, stopping
from .._run.process import process
from .._system.system import state_of
from .._values import arguments
from ..errors import ArgumentError
from . import arguments as checks
from . import handshake
from .world import World, running_of, session_of

if TYPE_CHECKING:
    from mpi4py import MPI

__all__ = ["draw"]

NEEDS_MORE = {"ribbon": "past positions", "surface": "neighbours"}
"""Kinds of sprites that need more of a particle than its place and its looks."""


def draw(
    positions: ArrayLike,
    *,
    renderer: Renderer,
    comm: MPI.Intracomm | None = None,
    color: ArrayLike | str = 1,
    alpha: ArrayLike = 1,
    size: ArrayLike | None = None,
    sprite: Sprite | None = None,
) -> Frame:
    """Draw a picture of particles that any MPI program keeps in arrays. Collective over `comm`.

    Every rank passes the particles that it has, also none; all ranks draw together. The picture depends only
    on the particles, not on which rank has them, nor on their order. The first call on a communicator
    prepares its ranks; later calls reuse that, until the communicator is freed. Pictures of a communicator
    are numbered from 0, and curves of the renderer are taken at number / 24 seconds.

    Args:
        positions: this rank's particles, m, shape (n, 3), or (n, 2) for z = 0; of any type of numbers.
        renderer: how the picture is drawn; the same on all ranks.
        comm: an mpi4py communicator; None: all ranks of the program.
        color: linear RGB, shape (n, 3), or one colour for all of this rank's particles: 3 numbers, one for
            grey, or a text such as "orange".
        alpha: opacity, 0..1, shape (n,), or one number.
        size: metres, shape (n,), or one number; None: 1. For sprites that are sized by their particles.
        sprite: how particles are drawn, of any kind but "ribbon" and "surface"; the same on all ranks. None:
            Sprite(). Pictures of a sheet that are picked at random follow a particle's place.

    Returns:
        The picture on rank 0 of `comm`. On other ranks it is falsy, and saving it does nothing.

    Raises:
        ArgumentError: on all ranks, if an argument is wrong on one.
        RankError: if a rank failed; all ranks raise it.
        ScriptMismatchError: if ranks passed different renderers or sprites; all ranks raise it.
    """
    drawing = _drawing_of(comm)
    failure: Exception | None = None
    try:
        shown = _check_looks(renderer, sprite)
        drawing.take(_points_of(positions, color, alpha, size), shown)
    except Exception as error:  # of any kind, from users' classes: the other ranks wait for this one
        failure = error
    with drawing.together(failure):
        return drawing.draw(renderer)


class _Points(NamedTuple):
    """Columns of particles, float32 or float64; a single row, but of positions, holds for all."""

    position: NDArray[Any]
    color: NDArray[Any]
    alpha: NDArray[Any]
    size: NDArray[Any]


class _Drawing:
    """What ranks keep between the pictures that they draw together."""

    def __init__(self, comm: MPI.Intracomm) -> None:
        """Prepare the ranks of a communicator. Collective."""
        # Any owner will do: particles are drawn wherever they are.
        self._world = world = World(seed=0, axis=None, roles="shared", progress="off", comm=comm)
        self._session = session = session_of(world)
        session.settings = session.settings._replace(live=None, steering=None)
        self._system = world.system("points")
        world.open()
        assert session.run is not None
        self._run = session.run
        self._pause()
        _open.add(self)

    @contextmanager
    def together(self, failure: Exception | None) -> Iterator[None]:
        """Hold a conversation of all ranks in the block, or raise an error on all if one has a failure."""
        may_have_failed = handshake.begin_again(self._session.comm, self._run, failed=failure is not None)
        try:
            if may_have_failed:
                self._agree(failure)
            yield
        finally:
            self._pause()

    def _pause(self) -> None:
        """Let the program go on, or end, as if no run were open."""
        process.close(self._run)
        open_worlds.leave(self._run.noted)
        stopping.disarm()

    def _agree(self, failure: Exception | None) -> None:
        comm, stall_s = self._run.comm, self._session.settings.stall_s
        assert comm is not None
        text = "" if failure is None else f"rank {comm.rank}: {failure}"
        rank, text = collectives.first_text(comm, text, stall_s, "other ranks to draw")
        if failure is not None:
            raise failure
        if rank >= 0:
            error = ArgumentError("arguments", None, "correct on all ranks")
            error.args = (text,)
            raise error

    def take(self, points: _Points, sprite: Sprite) -> None:
        """Replace this rank's particles."""
        if self._system.sprite is not sprite:
            self._system.sprite = sprite
        count, state = len(points.position), state_of(self._system)
        assert state is not None
        columns = [(state.attributes[name][0], rows) for name, rows in points._asdict().items()]
        engine = self._session.begin("draw()")
        try:
            bad = engine.replace(0, count, columns, numbered=sprite.kind == "image")
        finally:
            self._session.end()
        if bad >= 0:
            _raise_for(
                *next(pair for pair in points._asdict().items() if state.attributes[pair[0]][0] == bad)
            )

    def draw(self, renderer: Renderer) -> Frame:
        """Draw all ranks' particles. Collective."""
        self._world.renderer = renderer
        return running_of(self._world).render()

    @property
    def over(self) -> bool:
        """Whether the ranks have given up on each other."""
        return self._session.engine is None or self._session.engine.gave_up

    def forget(self) -> None:
        """Free the engine, before MPI ends."""
        self._session.engine = None


_open: weakref.WeakSet[_Drawing] = weakref.WeakSet()
_of_forks: dict[int, _Drawing] = {}  # by process: a fork has no MPI communicator that keeps it


def _drawing_of(comm: Any) -> _Drawing:
    """Return what is kept for a communicator, or prepare it. Collective on the first call."""
    joined, _, _ = checks.ranks_of(comm)
    forked = rank_process.is_fork()
    drawing: Any = _of_forks.get(os.getpid()) if forked else joined.Get_attr(_key())
    if drawing is None or drawing.over:
        drawing = _Drawing(joined)
        if forked:
            _of_forks[os.getpid()] = drawing
        else:
            joined.Set_attr(_key(), drawing)
    kept: _Drawing = drawing
    return kept


@cache
def _key() -> int:
    """Return the key of the attribute that a communicator keeps."""
    from mpi4py import MPI

    atexit.register(_forget_all)
    return MPI.Comm.Create_keyval()


def _forget_all() -> None:
    for drawing in list(_open):
        drawing.forget()


# --- checks


def _check_looks(renderer: Any, sprite: Any) -> Sprite:
    if renderer is None:
        raise ArgumentError("renderer", None, "a motes.Renderer")
    checks.renderer("renderer", renderer)
    shown = checks.sprite(sprite)
    if shown.kind in NEEDS_MORE:
        raise ArgumentError("sprite", shown.kind, f"of a kind without {NEEDS_MORE[shown.kind]}")
    return shown


def _points_of(positions: Any, color: Any, alpha: Any, size: Any) -> _Points:
    position = _rows("positions", positions, 3, None)
    count = len(position)
    return _Points(
        position,
        _colors(color, count),
        _numbers("alpha", alpha, count),
        _numbers("size", 1 if size is None else size, count),
    )


def _numbers(name: str, given: Any, count: int) -> NDArray[Any]:
    """Return one number per particle, or the one of all."""
    if _shape(given) == ():
        return np.full(1, arguments.number(name, given))
    return _rows(name, given, 1, count)


def _colors(given: Any, count: int) -> NDArray[Any]:
    """Return a colour per particle, or the one of all."""
    if isinstance(given, str):
        return np.asarray([arguments.color("color", given)])
    if _shape(given) == ():
        return np.full((1, 3), arguments.number("color", given))
    if _shape(given) == (3,) and not isinstance(given[0], str):
        return np.asarray([arguments.color("color", given)])
    return _rows("color", arguments.colors_of_rows("color", given), 3, count)


def _rows(name: str, given: Any, width: int, count: int | None) -> NDArray[Any]:
    """Return rows in C order, without a copy where they are floats in C order."""
    allowed = f"numbers of shape (n, {width})" if width > 1 else "one number, or numbers of shape (n,)"
    plain = type(given) is np.ndarray and given.dtype in (np.float32, np.float64) and given.dtype.isnative
    rows = given if plain else arguments.floats(name, given, np.float64, allowed)
    if name == "positions" and rows.ndim == 2 and rows.shape[1] == 2:
        rows = arguments.with_z(rows)
    if rows.ndim != 2 - (width == 1) or rows.shape[1:] != (width,)[: rows.ndim - 1]:
        raise ArgumentError(name, given, allowed)
    if count is not None and len(rows) != count:
        raise ArgumentError(name, f"{len(rows)} rows", f"one for all, or of {count} rows, like positions")
    return np.ascontiguousarray(rows)


def _shape(given: Any) -> tuple[int, ...] | None:
    """Return the shape of an array; None if it has none, like a list of lists of different lengths."""
    try:
        shape: tuple[int, ...] = np.shape(given)
    except ValueError:
        return None
    return shape


def _raise_for(name: str, rows: NDArray[Any]) -> NoReturn:
    """Raise ArgumentError for rows of which one is not finite as float32."""
    with np.errstate(over="ignore"):
        bad = ~np.isfinite(rows.astype(np.float32)).reshape(len(rows), -1).all(axis=1)
    row = int(np.flatnonzero(bad)[0])
    what = "positions" if name == "position" else name
    raise ArgumentError(what, f"{rows[row].tolist()} in row {row}", "finite numbers within float32's range")
