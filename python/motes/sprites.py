"""How the particles of a system are drawn: Sprite."""

from __future__ import annotations

from . import _core, arguments
from .values import Value, value

__all__ = ["Sprite"]


@value()
class Sprite(Value):
    """How particles of a system are drawn: `point` or soft `disc`, `pixels` wide, their light added up.

    `kind`: "point" or "disc". `pixels`: the diameter of a disc, 1..15. `blend`: "add".
    """

    kind: str = "disc"
    pixels: int = 5
    blend: str = "add"

    def __post_init__(self) -> None:
        """Check the arguments, and make the engine's value."""
        state = self.__dict__
        state["kind"] = arguments.choice("kind", self.kind, ("point", "disc"))
        state["pixels"] = arguments.integer("pixels", self.pixels, low=1, high=15)
        state["blend"] = arguments.choice("blend", self.blend, ("add",))
        state["_core"] = _core.Sprite(self.kind, self.pixels, self.blend, of_height=0, softness=0, picture=0)

    @property
    def core(self) -> _core.Sprite:
        """The engine's value; for the package itself."""
        made: _core.Sprite = self.__dict__["_core"]
        return made
