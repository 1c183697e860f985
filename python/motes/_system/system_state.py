"""SystemState: the internal state of a system, and what the script has recorded for it in this frame."""

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

__all__ = ["HITS", "SystemState", "engine_attributes", "engine_sets"]


HITS = frozenset(("hit", "hit_normal", "landing"))
"""The attributes in which `bounce(hits=True)` notes hits, anew in each frame."""


def engine_attributes(periods: Sequence[Period], sprite: Sprite) -> list[tuple[str, int]]:
    """Return name and width of the attributes that the engine adds for periods and ribbons."""
    attributes = [(CROSSINGS, 3)] if periods else []
    return attributes + (_core.trace_attributes(bool(periods)) if sprite.kind == "ribbon" else [])


def engine_sets(call: str, name: str) -> ArgumentError:
    """Return the error for a script that sets an attribute of `engine_attributes`."""
    return ArgumentError(call, name, "an attribute that scripts may set; only the engine sets this one")


class SystemState:
    """A system's index in its world, its attributes, and this frame's list; shared by the system's parts."""

    def __init__(
        self, session: Session, index: int, name: str, axes: str, definition: dict[str, Any]
    ) -> None:
        """Begin with an empty list; `definition`: the engine's arguments for the system."""
        names = [*_core.builtin_attributes(), *((a[0], a[1]) for a in definition["attributes"])]
        followed: int = definition["domains_of"]
        self.session = session
        self.index = index
        self.name = name
        self.axes = axes
        self.definition = definition
        self.leads = index if followed < 0 else followed
        """Index of the system whose domains it uses: its own, or another's."""
        self.sprite: Sprite = definition["sprite"]
        self.attributes = {attribute: (i, width) for i, (attribute, width) in enumerate(names)}
        self.columns = columns_of(names)
        native_of(self.sprite, self.columns)  # raises now if the sprite's pick names an unknown column
        self.engine_attributes = HITS.union(
            name for name, _ in engine_attributes(definition["periods"], self.sprite)
        )
        """Attributes that scripts can only read."""
        self.newborn = Newborn(name, self.attributes, self.engine_attributes)
        self.entries: list[Any] = []
        """This frame's list so far."""
        self.lines: list[script_lines.Line] = []
        """The line of the script that recorded each entry."""
        self.functions: list[Callable[[Any], object]] = []
        """This frame's callbacks; the engine refers to them by index."""
        self.called: Callable[..., NDArray[np.float32] | None]
        """Calls a callback, given its index and its arguments."""
        self.views: list[int] = []
        """For each open `local()`: the length of the list when it opened."""
        self.first: FirstFrame | None = FirstFrame()
        """Notes on the first frames; None once the first list with births has run."""
        self.has_births = False
        """Whether any list so far had births, or rules that spawn particles of this system."""

    def define(self, engine: _core.Engine) -> None:
        """Add the system to the engine."""
        engine.add_system(
            name=self.name, **dict(self.definition, sprite=native_of(self.sprite, self.columns))
        )
        self.tell_clump(engine)

    def show_as(self, sprite: Sprite, engine: _core.Engine | None) -> None:
        """Draw the particles with another sprite from here on."""
        native = native_of(sprite, self.columns)
        self.sprite = sprite
        if engine is not None:
            engine.set_sprite(self.index, native)

    def tell_clump(self, engine: _core.Engine) -> None:
        """Pass the template of clumps, if any, to the engine."""
        clump = self.newborn.clump
        template = 0
        if clump is not None:
            from .._values.clump import law_of

            _, template = law_of(clump)
        engine.set_clumps(self.index, template)

    def add(self, entry: Any, line: script_lines.Line) -> None:
        """Append an entry and the line that recorded it."""
        self.entries.append(entry)
        self.lines.append(line)

    def forget(self) -> None:
        """Clear the list, because the frame has run or an earlier run has computed it."""
        self.entries.clear()
        self.lines.clear()
        self.functions.clear()

    def line(self, number: int) -> script_lines.Line | None:
        """Return the line that recorded an entry of this frame."""
        return self.lines[number] if 0 <= number < len(self.lines) else None

    def state_now(self) -> list[tuple[int, _core.Distribution]]:
        """Return the distributions for particles born in this frame."""
        return self.newborn.state_at(self.session.time)
