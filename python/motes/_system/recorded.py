"""Recorded: a system as the package knows it, and what the script has said of it in this frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._picture.sprites import Sprite, native_of
from .._run import script_lines
from .._values.space import CROSSINGS, Period
from ..errors import ArgumentError
from ..expressions._conditions import columns_of
from .first_frame import FirstFrame
from .newborn import Newborn
from .session import Session

__all__ = ["Recorded", "kept_attributes", "kept_error"]


def kept_attributes(periods: Sequence[Period], sprite: Sprite) -> list[tuple[str, int]]:
    """Return name and width of the attributes that the engine adds for periods and ribbons."""
    found = [(CROSSINGS, 3)] if periods else []
    return found + (_core.trace_attributes(bool(periods)) if sprite.kind == "ribbon" else [])


def kept_error(call: str, name: str) -> ArgumentError:
    """Return the error of a script that sets one of them."""
    return ArgumentError(call, name, "an attribute that scripts may set; the engine keeps this one itself")


class Recorded:
    """A system's place in its world, its attributes, and this frame's list. Its parts share this."""

    def __init__(
        self, session: Session, index: int, name: str, axes: str, definition: dict[str, Any]
    ) -> None:
        """Begin with an empty list; `definition` is what the engine takes."""
        names = [*_core.builtin_attributes(), *((a[0], a[1]) for a in definition["attributes"])]
        followed: int = definition["domains_of"]
        self.session = session
        self.index = index
        self.name = name
        self.axes = axes
        self.definition = definition
        self.leads = index if followed < 0 else followed
        """Whose domains it has: its own, or another's."""
        self.sprite: Sprite = definition["sprite"]
        self.attributes = {attribute: (i, width) for i, (attribute, width) in enumerate(names)}
        self.columns = columns_of(names)
        native_of(self.sprite, self.columns)  # says at the call what its pick cannot name
        self.kept = frozenset(name for name, _ in kept_attributes(definition["periods"], self.sprite))
        """Attributes that scripts only read."""
        self.newborn = Newborn(name, self.attributes, self.kept)
        self.entries: list[Any] = []
        """This frame's list so far."""
        self.lines: list[script_lines.Line] = []
        """Where each of these was recorded."""
        self.functions: list[Callable[[Any], object]] = []
        """Callbacks of this frame, which entries name by number."""
        self.called: Callable[..., NDArray[np.float32] | None]
        """Calls one of these: its number, and what it gets."""
        self.views: list[int] = []
        """For each open `local()`: how long the list was when it opened."""
        self.first: FirstFrame | None = FirstFrame()
        """What is noted until the first list with births has run; then None."""
        self.has_births = False
        """Whether a list so far had births, or rules by which others make children of this system."""

    def define(self, engine: _core.Engine) -> None:
        """Tell the engine of the system."""
        engine.add_system(
            name=self.name, **dict(self.definition, sprite=native_of(self.sprite, self.columns))
        )
        self.tell_clump(engine)

    def tell_clump(self, engine: _core.Engine) -> None:
        """Tell the engine the template of particles that are clumps."""
        clump = self.newborn.clump
        template = 0
        if clump is not None:
            from .._values.clump import law_of

            _, template = law_of(clump)
        engine.set_clumps(self.index, template)

    def add(self, entry: Any, line: script_lines.Line) -> None:
        """Note what was recorded, and where."""
        self.entries.append(entry)
        self.lines.append(line)

    def forget(self) -> None:
        """Start an empty list: the frame has run, or an earlier run has done it."""
        self.entries.clear()
        self.lines.clear()
        self.functions.clear()

    def line(self, number: int) -> script_lines.Line | None:
        """Return where an entry of this frame was recorded."""
        return self.lines[number] if 0 <= number < len(self.lines) else None

    def state_now(self) -> list[tuple[int, _core.Distribution]]:
        """Return what particles get that are born in this frame."""
        return self.newborn.state_at(self.session.time)
