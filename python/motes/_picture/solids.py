"""External objects of a picture and what lights them: Solid, Light. Colours are linear RGB in 0..1."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._values import arguments
from .._values.arguments import Triple
from .._values.curves import Curve
from .._values.values import Value, value
from ..errors import ArgumentError
from ..shapes import Blob, Line, Point, Shape, Union, native_of
from ..shapes._mesh import Mesh
from .skies import light_key, light_of

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
    """Linear RGB, the part of the light that it reflects; a mesh's own `colors` multiply it."""
    light: float = 0
    """How much of its colour it emits, too."""
    image: NDArray[np.float32] | None = None
    """A picture that multiplies its colour: a path, or an array (height, width, 3) of sRGB uint8 or linear
    floats. It lies along the two axes of the world that the surface is most parallel to, and repeats."""
    scale: float = 1
    """Metres that the picture is wide."""

    def __init__(
        self,
        shape: Shape | Mesh,
        color: ArrayLike = (0.8, 0.8, 0.8),
        light: float = 0,
        image: str | os.PathLike[str] | ArrayLike | None = None,
        scale: float = 1,
    ) -> None:
        """Take the shape, its colour, how much it emits, and a picture and its width."""
        if not isinstance(shape, (Shape, Mesh)):
            raise ArgumentError("shape", shape, "a shape of motes.shapes or a motes.Mesh")
        if any(isinstance(part, (Point, Line, Blob)) for part in parts(shape)):
            raise ArgumentError("shape", shape, "a shape with a surface: not a Point, Line or Blob")
        self.__dict__.update(
            shape=shape,
            color=arguments.color("color", color, low=0, high=arguments.FARTHEST),
            light=arguments.number("light", light, low=0, high=1e6),
            image=None if image is None else light_of("image", image),
            scale=arguments.number("scale", scale, low=1e-6, high=1e6),
        )
        self.__dict__["_image"] = 0 if self.image is None else light_key(self.image)

    def _key(self) -> tuple[Any, ...]:
        """Compare an image by the fingerprint of its content."""
        return tuple((self._items() | {"image": self.__dict__["_image"]}).values())

    def _add_to(self, view: _core.View) -> None:
        """Put it into the engine's view; for the package itself."""
        look = (self.color, self.light, self.__dict__["_image"], self.scale)
        for part in parts(self.shape):
            if isinstance(part, Mesh):
                view.add_mesh(native_of(part), *look)
            else:
                view.add_object(native_of(part), *look)


@value()
class Light(Value):
    """A point that lights the solids and lit particles, as a lamp or a fire does.

    `position`: m. `power`: the light on a surface that faces it from 1 m; it falls with the square of the
    distance. `radius`: m. A renderer's lights may change between frames: a fire's moves with its emitter.
    """

    position: ArrayLike | Curve
    """Where it is, m."""
    color: ArrayLike | Curve = (1, 1, 1)
    """Linear RGB."""
    power: float | Curve = 1
    """The light on a surface that faces it from 1 m."""
    radius: float | Curve = 0
    """m: shadows of solids get soft edges, and also fall on lit particles; 0: a point, as for `sun_size`."""
    _may_move = True

    def __post_init__(self) -> None:
        """Check the arguments."""
        state = self.__dict__
        state["position"] = arguments.place("position", self.position)
        state["color"] = arguments.color("color", self.color, low=0, high=arguments.FARTHEST)
        state["power"] = arguments.number("power", self.power, low=0, high=1e6)
        state["radius"] = arguments.number("radius", self.radius, low=0, high=1e6)


def add_to(solid: Solid, view: _core.View) -> None:
    """Put a solid into the engine's view, for the rest of the package."""
    solid._add_to(view)


def parts(shape: Shape | Mesh) -> Iterator[Shape | Mesh]:
    """Return the shapes of a union, or the one shape."""
    yield from shape.shapes if isinstance(shape, Union) else (shape,)
