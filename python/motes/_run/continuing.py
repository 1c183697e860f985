"""The state of a run that continues an earlier one, and the movies that checkpoints must record.

The world calls `continued.begin` when it has read a checkpoint, before the script's first frame, and
`continued.end` when it ends. A checkpoint stores the result of `frames_of_movies()`.
"""

from __future__ import annotations

import os
import weakref
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from .._core import Engine
    from .._picture.frame import Frame

__all__ = [
    "Continued",
    "continued",
    "forget_movie",
    "frames_of_movies",
    "hold_movie",
    "keep_closed_movies",
    "movies_to_take_over",
    "note_movie",
    "open_movies",
    "outlasting_movies",
    "place_of",
    "secure_movies",
]


class Film(Protocol):
    """A film: the rank that draws writes it, the other ranks count its frames."""

    @property
    def place(self) -> str:
        """The film's path, the same for every run and rank: see `place_of`."""

    @property
    def written(self) -> int:
        """The number of frames so far, equal on all ranks."""

    def secure(self) -> int:
        """Flush all frames so far to disk; return their number."""

    def note_secured(self) -> None:
        """Note that all ranks know that the last `secure` succeeded."""

    def first_unsaved(self) -> int | None:
        """Return the first frame of the world that may not be in the file yet."""

    def take_over(self) -> list[int]:
        """Write the film from here on, in place of a lost rank; return the frames that may be missing."""

    def write_again(self, index: int, frame: Frame) -> None:
        """Write one of the frames that `take_over` returned."""

    def close_for_lost(self) -> None:
        """Give the film its name, in place of a lost rank."""


@dataclass(eq=False, repr=False)
class Continued:
    """The earlier run that the run in this process continues."""

    frame: int = 0
    """The first frame that is still to do; 0: nothing is continued."""
    movies: dict[str, int] = field(default_factory=dict)
    """Frames of each movie at the checkpoint, by its `place`; other movies start empty."""
    draws: bool = False
    """Whether this rank is the image generator, which closes movies that get no more frames."""

    def begin(self, frame: int, movies: Mapping[str, int], *, draws: bool) -> None:
        """Continue with `frame`; `movies`: the frames that each movie already has."""
        self.frame, self.movies, self.draws = frame, dict(movies), draws

    def end(self) -> None:
        """Reset: a later world of this process continues nothing."""
        self.begin(0, {}, draws=False)


continued = Continued()

_movies: dict[int, weakref.ref[Film]] = {}
_held: dict[int, Film] = {}
_closed: dict[str, Film] | None = None  # the last closed film of each place; None: no run survives losses
_outlasting: list[Film] = []


def place_of(path: str | os.PathLike[str]) -> str:
    """Return a film's absolute path, its directory without symbolic links: the same for every run."""
    given = Path(path).absolute()
    try:
        return str(given.parent.resolve() / given.name)
    except (OSError, RuntimeError):  # RuntimeError: a loop of symbolic links
        return str(given)


def note_movie(movie: Film) -> None:
    """Register a new movie by a weak reference; `hold_movie` keeps it alive."""
    key = id(movie)
    _movies[key] = weakref.ref(movie, lambda _: _movies.pop(key, None))


def hold_movie(movie: Film) -> None:
    """Keep a movie, as all ranks do, until it is closed, even if the script drops its last reference."""
    _held[id(movie)] = movie


def forget_movie(movie: Film) -> None:
    """Unregister a movie that is closed."""
    _movies.pop(id(movie), None)
    _held.pop(id(movie), None)
    if _closed is not None:
        _closed[movie.place] = movie


def keep_closed_movies(keep: bool) -> None:
    """Keep movies that are closed on this rank: the rank that writes them may be lost before it closes them.

    When keeping ends with the run, movies that are still open are kept until the script ends.
    """
    global _closed
    if not keep and _closed is not None:
        _outlasting.extend(open_movies())
    _closed = {} if keep else None


def outlasting_movies() -> list[Film]:
    """List the movies that were open at the end of a run that survives losses."""
    return list(_outlasting)


def movies_to_take_over() -> list[Film]:
    """List the movies that are open, and closed ones that another rank may not have closed yet."""
    still_open = open_movies()
    places = {movie.place for movie in still_open}
    return [*still_open, *(movie for place, movie in (_closed or {}).items() if place not in places)]


def open_movies() -> list[Film]:
    """List the movies that are not closed, in order of creation, including those without a frame."""
    return [movie for movie in (reference() for reference in list(_movies.values())) if movie is not None]


def secure_movies(engine: Engine, beside: Callable[[], object] = lambda: None) -> None:
    """Flush all open movies to disk and call `beside`, on every rank. Collective."""

    def secure() -> None:
        for movie in open_movies():
            movie.secure()
        beside()

    engine.secure(secure)
    for movie in open_movies():
        movie.note_secured()


def frames_of_movies() -> dict[str, int]:
    """Return the number of frames of each open movie by its `place`, equal on every rank."""
    return {movie.place: movie.written for movie in open_movies()}
