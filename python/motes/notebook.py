"""Runs in a notebook that are seen and steered while they go on: `show` and `launch`."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from . import _extras, arguments
from ._notebook import kernel
from .errors import ArgumentError

if TYPE_CHECKING:
    from ._notebook.plays import Play
    from .world import World

__all__ = ["Player", "launch", "show"]


class Player:
    """A run that goes on beside the notebook's cells. `motes.show` and `motes.launch` return one.

    In a notebook it is a widget: the picture, which the mouse turns; pause, single steps, stop; and the
    world's controls. Elsewhere it is seen in a browser, at `url`.
    """

    _play: Play

    def __init__(self, play: Play) -> None:
        """Take what is played; `motes.show` and `motes.launch` make players.

        Args:
            play: a loop in a thread, or a job.
        """
        self._play = play

    @property
    def running(self) -> bool:
        """Whether it has not come to its end."""
        return not self._play.wait(0)

    @property
    def url(self) -> str | None:
        """Where a browser on this machine sees the run; None before it has begun and after its end."""
        return self._play.url if self.running else None

    @property
    def output(self) -> list[str]:
        """The last lines that the ranks of `motes.launch` have printed, oldest first."""
        return self._play.output()

    def stop(self) -> None:
        """Ask the run to end at the next border between two frames; returns at once.

        A launched run that is asked once more is terminated.
        """
        self._play.stop()

    def wait(self, timeout: float | None = None) -> bool:
        """Wait for the run's end. An interrupt asks the run to stop, and is raised when it has.

        Args:
            timeout: seconds; None: as long as it takes.

        Returns:
            Whether the run has ended.
        """
        seconds = None if timeout is None else arguments.number("timeout", timeout, low=0)
        try:
            return self._play.wait(seconds)
        except KeyboardInterrupt:
            self._play.stop()
            self._play.wait(None)
            raise

    def result(self) -> Any:
        """Wait for the run's end, and return what its loop has returned; raise what it has raised.

        Returns:
            The loop's result; None for a launched run.

        Raises:
            MotesError: if a launched run has failed, with the last lines of its output.
        """
        self.wait()
        return self._play.result()

    def __repr__(self) -> str:
        """Name the run and how it is."""
        return f"<Player of {self._play.title!r}, {'running' if self.running else self._play.ending}>"


def show(world: World, loop: Callable[..., Any], *, paused: bool = False) -> Player:
    """Run `loop` in a thread, and show what it does: in a notebook as a widget, elsewhere in a browser.

    Until the loop has ended, no other thread can use the world. The widget's stop button, `Player.stop` and
    an interrupt of `Player.wait` end the loop of `world.frames` at a border between two frames; the world
    stays as it is, and further loops go on. Needs the extra [notebook].

    Args:
        world: a world of one process, which is open (`world.open()`) or which the loop opens.
        loop: a function without arguments, or of the world, that runs the loop of `world.frames`.
        paused: whether it starts paused.

    Returns:
        What shows and steers the run.

    Raises:
        MissingExtraError: if the extra is not installed.
    """
    from ._notebook.loops import LoopPlay
    from .world import World

    if not isinstance(world, World):
        raise ArgumentError("world", world, "a motes.World")
    if world.size > 1:
        raise ArgumentError("world", world, "a world of one process; motes.launch runs a script on many")
    if not callable(loop):
        raise ArgumentError("loop", loop, "a function without arguments, or of the world")
    arguments.flag("paused", paused)
    make = _player()
    play = LoopPlay(world, loop, paused=paused)
    player = make(play)
    play.start()
    return player


def launch(
    script: str | os.PathLike[str], *, n: int, arguments: Sequence[object] = (), paused: bool = False
) -> Player:
    """Run a script on several ranks beside the notebook, and show it as `motes.show` does.

    What its ranks print is below the picture and in `Player.output`. The stop button, `Player.stop` and an
    interrupt of `Player.wait` end the run at a border between two frames; the second time they terminate it.
    Needs the extra [notebook].

    Args:
        script: a path; the script runs unchanged, as by `python -m motes run -n N script.py`.
        n: how many ranks.
        arguments: what follows the script's name.
        paused: whether the run starts paused.

    Returns:
        What shows and steers the run.

    Raises:
        MissingExtraError: if the extra is not installed.
    """
    from ._notebook import jobs

    job = jobs.checked(script, n, arguments, paused)
    make = _player()
    play = jobs.JobPlay(job)
    player = make(play)
    play.start()
    return player


def _player() -> Callable[[Any], Player]:
    """Return what makes the player, a widget in a notebook. Raises MissingExtraError where it is missing."""
    _extras.require_live("motes.show and motes.launch")
    if not kernel.running():
        return Player
    _extras.require_anywidget()
    from ._notebook.widget import WidgetPlayer

    return WidgetPlayer
