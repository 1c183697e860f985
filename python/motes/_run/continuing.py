"""What a run that goes on after another one knows of it, and the movies that its checkpoints must name.

The world calls `continued.begin` when it has read a checkpoint, before the script's first frame, and
`continued.end` when it ends. A checkpoint holds what `frames_of_movies()` says.
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
    """A film that is written, on the rank that draws, or counted, on the others."""

    @property
    def place(self) -> str:
        """Its name, the same for every run and rank."""

    @property
    def written(self) -> int:
        """Its frames so far, on whatever rank they are."""

    def secure(self) -> int:
        """Bring all frames so far to the disk; return how many."""

    def note_secured(self) -> None:
        """Note that they are there, as all ranks know by now."""

    def first_unsaved(self) -> int | None:
        """Return the first frame of the world that may not be in the file yet."""

    def take_over(self) -> list[int]:
        """Write it from here on, in place of a lost rank; return the frames that it may not have written."""

    def write_again(self, index: int, frame: Frame) -> None:
        """Write one of these."""

    def close_for_lost(self) -> None:
        """Give it its name, in place of a lost rank."""


@dataclass(eq=False, repr=False)
class Continued:
    """What the run in this process continues."""

    frame: int = 0
    """The first frame that is still to do; 0: nothing is continued."""
    movies: dict[str, int] = field(default_factory=dict)
    """How many frames each movie had at the checkpoint, by its place; others begin anew."""
    draws: bool = False
    """Whether this rank is the image generator: it closes a movie to which nothing is added any more."""

    def begin(self, frame: int, movies: Mapping[str, int], *, draws: bool) -> None:
        """Note that the run goes on with `frame`, and movies behind so many frames."""
        self.frame, self.movies, self.draws = frame, dict(movies), draws

    def end(self) -> None:
        """Forget it: a later world of this process continues nothing."""
        self.begin(0, {}, draws=False)


continued = Continued()

_movies: dict[int, weakref.ref[Film]] = {}
_held: dict[int, Film] = {}
_closed: dict[str, Film] | None = None  # the last one at each place; None: no run survives losses
_outlasting: list[Film] = []


def place_of(path: str | os.PathLike[str]) -> str:
    """Return the name of a film that is the same for every run: absolute, its directory without links."""
    given = Path(path).absolute()
    try:
        return str(given.parent.resolve() / given.name)
    except (OSError, RuntimeError):  # RuntimeError: symbolic links in a circle
        return str(given)


def note_movie(movie: Film) -> None:
    """Note a new movie. It is forgotten with its last reference, as long as nothing was written."""
    key = id(movie)
    _movies[key] = weakref.ref(movie, lambda _: _movies.pop(key, None))


def hold_movie(movie: Film) -> None:
    """Keep a movie until it is closed, on all ranks alike, whether the script still refers to it or not."""
    _held[id(movie)] = movie


def forget_movie(movie: Film) -> None:
    """Note that a movie is closed."""
    _movies.pop(id(movie), None)
    _held.pop(id(movie), None)
    if _closed is not None:
        _closed[movie.place] = movie


def keep_closed_movies(keep: bool) -> None:
    """Keep movies that are closed here: the rank that writes them may be lost before it has closed them.

    At the end of a run that keeps them, those that are still open are kept until the script ends.
    """
    global _closed
    if not keep and _closed is not None:
        _outlasting.extend(open_movies())
    _closed = {} if keep else None


def outlasting_movies() -> list[Film]:
    """List the movies that were open when a run ended that survives losses."""
    return list(_outlasting)


def movies_to_take_over() -> list[Film]:
    """List the movies that are open, and those that another rank may not have closed."""
    still_open = open_movies()
    places = {movie.place for movie in still_open}
    return [*still_open, *(movie for place, movie in (_closed or {}).items() if place not in places)]


def open_movies() -> list[Film]:
    """List the movies that are not closed, in the order of their creation; also those without a frame yet."""
    return [movie for movie in (reference() for reference in list(_movies.values())) if movie is not None]


def secure_movies(engine: Engine, beside: Callable[[], object] = lambda: None) -> None:
    """Bring all open movies to the disk up to here, and what `beside` does. Collective."""

    def secure() -> None:
        for movie in open_movies():
            movie.secure()
        beside()

    engine.secure(secure)
    for movie in open_movies():
        movie.note_secured()


def frames_of_movies() -> dict[str, int]:
    """Return how many frames each open movie has, by its place: the same on every rank."""
    return {movie.place: movie.written for movie in open_movies()}
