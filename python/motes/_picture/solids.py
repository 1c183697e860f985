"""External objects of a picture and what lights them: Solid, Light. Colours are linear RGB in 0..1."""

from __future__ import annotations

from collections.abc import Iterator

from numpy.typing import ArrayLike

from .. import _core
from .._values import arguments
from .._values.arguments import Triple
from .._values.curves import Curve
from .._values.values import Value, value
from ..errors import ArgumentError
from ..shapes import Blob, Line, Point, Shape, Union, native_of
from ..shapes._mesh import Mesh

__all__ = ["Light", "Solid", "add_to", "parts"]


@value(init=False)
class Solid(Value):
    """An external object (paper 3.2.4): a colour and a shape with a surface, a union of such or a mesh.

    It is drawn, lit by the sun and by lights, casts a shadow, and hides the particles behind it. Point, Line
    and Blob have no surface. `light`: how much of its colour it emits, too; 0: none, 1: as much as it would
    show in full sunlight. What it emits does not light other solids: place a `Light` for that. So that one
    may stand inside, a solid that emits any light casts no shadow.
    """

    shape: Shape | Mesh
    """What it looks like."""
    color: Triple = (0.8, 0.8, 0.8)
    """Linear RGB, the part of the light that it reflects."""
    light: float = 0
    """How much of its colour it emits, too."""

    def __init__(self, shape: Shape | Mesh, color: ArrayLike = (0.8, 0.8, 0.8), light: float = 0) -> None:
        """Take the shape, its colour, and how much it emits."""
        if not isinstance(shape, (Shape, Mesh)):
            raise ArgumentError("shape", shape, "a shape of motes.shapes or a motes.Mesh")
        if any(isinstance(part, (Point, Line, Blob)) for part in parts(shape)):
            raise ArgumentError("shape", shape, "a shape with a surface: not a Point, Line or Blob")
        self.__dict__.update(
            shape=shape,
            color=arguments.color("color", color, low=0, high=arguments.FARTHEST),
            light=arguments.number("light", light, low=0, high=1e6),
        )

    def _add_to(self, view: _core.View) -> None:
        """Put it into the engine's view; for the package itself."""
        for part in parts(self.shape):
            if isinstance(part, Mesh):
                view.add_mesh(native_of(part), self.color, self.light)
            else:
                view.add_object(native_of(part), self.color, self.light)


@value()
class Light(Value):
    """A point that lights the solids, as a lamp or a fire does. Particles have their own colours.

    `position`: m. `power`: the light on a surface that faces it from 1 m; it falls with the square of the
    distance. A renderer's lights may change between frames: a fire's moves with its emitter.
    """

    position: ArrayLike | Curve
    """Where it is, m."""
    color: ArrayLike | Curve = (1, 1, 1)
    """Linear RGB."""
    power: float | Curve = 1
    """The light on a surface that faces it from 1 m."""
    _may_move = True

    def __post_init__(self) -> None:
        """Check the arguments."""
        state = self.__dict__
        state["position"] = arguments.place("position", self.position)
        state["color"] = arguments.color("color", self.color, low=0, high=arguments.FARTHEST)
        state["power"] = arguments.number("power", self.power, low=0, high=1e6)


def add_to(solid: Solid, view: _core.View) -> None:
    """Put a solid into the engine's view, for the rest of the package."""
    solid._add_to(view)


def parts(shape: Shape | Mesh) -> Iterator[Shape | Mesh]:
    """Return the shapes of a union, or the one shape."""
    yield from shape.shapes if isinstance(shape, Union) else (shape,)
