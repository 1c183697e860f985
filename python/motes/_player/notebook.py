"""`show` and `launch`: runs that are viewed and steered in a notebook."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from .. import _extras
from .._notebook import kernel
from .._values import arguments
from ..errors import ArgumentError
from .player import Player

if TYPE_CHECKING:
    from .._world.world import World

__all__ = ["launch", "show"]


def show(world: World, loop: Callable[..., Any], *, paused: bool = False) -> Player:
    """Run `loop` in a thread, and show its frames: in a notebook as a widget, elsewhere in a browser.

    Until the loop has ended, no other thread can use the world. The widget's stop button, `Player.stop` and
    an interrupt of `Player.wait` end the loop of `world.frames` at a border between two frames; the world
    keeps its state, and another loop can continue it. Needs the extra [notebook].

    Args:
        world: a world of one process, which is open (`world.open()`) or which the loop opens.
        loop: a function that runs the loop of `world.frames`; it takes no argument or the world.
        paused: whether the loop starts paused.

    Returns:
        The player, which shows and steers the run.

    Raises:
        MissingExtraError: if the extra is not installed.
    """
    from .._world.world import World
    from .loops import LoopPlay

    if not isinstance(world, World):
        raise ArgumentError("world", world, "a motes.World")
    if world.size > 1:
        raise ArgumentError(
            "world", world, "a world of one process; use motes.launch to run a script on several"
        )
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

    The ranks' output appears below the picture and in `Player.output`. The stop button, `Player.stop` and an
    interrupt of `Player.wait` end the run at a border between two frames; the second time they terminate it.
    Needs the extra [notebook].

    Args:
        script: a path; the script runs unchanged, as with `python -m motes run -n N script.py`.
        n: the number of ranks.
        arguments: the script's command line arguments.
        paused: whether the run starts paused.

    Returns:
        The player, which shows and steers the run.

    Raises:
        MissingExtraError: if the extra is not installed.
    """
    from . import jobs

    job = jobs.checked(script, n, arguments, paused)
    make = _player()
    play = jobs.JobPlay(job)
    player = make(play)
    play.start()
    return player


def _player() -> Callable[[Any], Player]:
    """Return the player's class, a widget in a notebook. Raises MissingExtraError."""
    _extras.require_live("motes.show and motes.launch")
    if not kernel.running():
        return Player
    _extras.require_anywidget()
    from .widget import WidgetPlayer

    return WidgetPlayer
