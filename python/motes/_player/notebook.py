"""Runs in a notebook that are seen and steered while they go on: `show` and `launch`."""

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
    """Run `loop` in a thread, and show what it does: in a notebook as a widget, elsewhere in a browser.

    `loop` is a function without arguments, or of the world. It runs the loop of frames of `world`, which is
    open (`world.open()`) or which it opens (`with world:`); the world must be one of a single process. Until
    the loop has ended, no other thread can use the world. The widget's stop button, `Player.stop` and an
    interrupt of `Player.wait` end the loop of `world.frames` at a border between two frames; the world stays
    as it is, and further loops go on. `paused`: it starts paused. Needs the extra `notebook`.
    """
    from .._world.world import World
    from .loops import LoopPlay

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
    """Run a script on `n` ranks beside the notebook, and show what it does as `motes.show` does.

    The script is run unchanged, as by `python -m motes run -n N script.py`, with `arguments` behind its name.
    What its ranks print is below the picture and in `Player.output`. `paused`: it starts paused. The stop
    button, `Player.stop` and an interrupt of `Player.wait` end the run at a border between two frames; the
    second time they terminate it. Needs the extra `notebook`.
    """
    from . import jobs

    job = jobs.checked(script, n, arguments, paused)
    make = _player()
    play = jobs.JobPlay(job)
    player = make(play)
    play.start()
    return player


def _player() -> Callable[[Any], Player]:
    """Return what makes the player: a widget in a notebook. Raises MissingExtra for what is not there."""
    _extras.require_live("motes.show and motes.launch")
    if not kernel.running():
        return Player
    _extras.require_anywidget()
    from .widget import WidgetPlayer

    return WidgetPlayer
