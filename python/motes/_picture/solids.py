"""Solid and Light: external objects of a picture, and their lights. Colours are linear RGB in 0..1."""

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
from .._values.materials import Material
from .._values.values import Value, value
from ..errors import ArgumentError
from ..shapes import Blob, Line, Point, Shape, Union, native_of
from ..shapes._mesh import Mesh
from .skies import light_key, light_of

SPOT = "a direction that is not 0, and degrees above 0 and up to 360, or None"
_PLAIN = Material((0.8, 0.8, 0.8))

__all__ = ["Light", "Solid", "add_to", "parts"]


@value(init=False)
class Solid(Value):
    """An external object (paper 3.2.4): a colour, and a shape with a surface, a union of such or a mesh.

    It is drawn, lit by the sun and by lights, casts a shadow, and hides the particles behind it. Point, Line
    and Blob have no surface. A solid with `light` above 0 glows, but does not light other solids; for that,
    place a `Light`, which may be inside, since a glowing solid casts no shadow.
    """

    shape: Shape | Mesh
    """A shape with a surface, a union of such shapes, or a mesh."""
    color: Triple = (0.8, 0.8, 0.8)
    """Reflectance, linear RGB; a mesh's own `colors` multiply it. Left out: that of the mesh's `material` if
    it has one, whose roughness, metal and pictures then also apply where they are left out; white with
    `glass`."""
    light: float = 0
    """Emission as a multiple of `color`; 0: none, 1: as bright as `color` in full sunlight."""
    image: NDArray[np.float32] | None = None
    """A texture that multiplies the colour: a path, or an array (height, width, 3) of sRGB uint8 or linear
    floats. A mesh with `uv` shows it there. Otherwise it repeats, projected along the axis closest to the
    surface's normal: an axis of the world, or of the mesh, so that it moves with the mesh."""
    scale: float = 1
    """The width of the texture, m; not used with `uv`."""
    roughness: float = 1
    """How evenly the surface scatters light, 0..1: 1 like paper or chalk, 0.3 like wet stone or brushed
    metal, 0 like a mirror. Below 1 it has highlights of the sun and lights, and reflects the sky, blurred by
    its roughness; it does not reflect other objects."""
    metal: float = 0
    """How much of a metal the surface is, 0..1: a metal reflects in its `color` and scatters nothing."""
    glass: float | None = None
    """The index of refraction, 1..4, such as 1.5 of glass or 1.33 of water; None: opaque. `color` tints what
    is seen through it. It refracts the solids and the sky behind it and reflects the sky, sun and lights, one
    vessel deep: rays follow up to 6 of its surfaces, so a bottle with an inner wall is right and what is seen
    through two of them is not. It casts no shadow, glass within glass is not seen, and particles in and
    behind it are seen as if it was not there. A closed shape is of glass throughout; a surface without a
    back, such as a rectangle or an open mesh, is a thin pane, and a plane is the surface of what lies below
    it."""

    def __init__(
        self,
        shape: Shape | Mesh,
        color: ArrayLike | None = None,
        light: float = 0,
        image: str | os.PathLike[str] | ArrayLike | None = None,
        scale: float = 1,
        roughness: float | None = None,
        metal: float | None = None,
        glass: float | None = None,
    ) -> None:
        """Check the fields."""
        if not isinstance(shape, (Shape, Mesh)):
            raise ArgumentError("shape", shape, "a shape of motes.shapes or a motes.Mesh")
        if any(isinstance(part, (Point, Line, Blob)) for part in parts(shape)):
            raise ArgumentError("shape", shape, "a shape with a surface: not a Point, Line or Blob")
        given = {"light": light or None, "image": image, "roughness": roughness, "metal": metal}
        if glass is not None:
            for name, one in given.items():
                if one is not None:
                    raise ArgumentError(
                        name, one, "left out with `glass`, which is smooth and has no picture"
                    )
            color = (1, 1, 1) if color is None else color
        own = getattr(shape, "material", None) if color is None else None
        look = _PLAIN if own is None else own
        shown = None if image is None else light_of("image", image)
        self.__dict__.update(
            shape=shape,
            color=arguments.color(
                "color", look.color if color is None else color, low=0, high=arguments.FARTHEST
            ),
            light=arguments.number("light", light, low=0, high=1e6),
            image=look.image if shown is None else shown,
            scale=arguments.number("scale", scale, low=1e-6, high=1e6),
            roughness=look.roughness
            if roughness is None
            else arguments.number("roughness", roughness, low=0, high=1),
            metal=look.metal if metal is None else arguments.number("metal", metal, low=0, high=1),
            glass=None if glass is None else arguments.number("glass", glass, low=1, high=4),
        )
        self.__dict__["_image"] = look.__dict__["_image"] if shown is None else light_key(shown)
        own_finish = roughness is None and metal is None and look.finish_image is not None
        self.__dict__["_finish_image"] = look.__dict__["_finish_image"] if own_finish else 0

    def _key(self) -> tuple[Any, ...]:
        """Compare an image by its content's hash."""
        state = self.__dict__
        return (*(self._items() | {"image": state["_image"]}).values(), state["_finish_image"])

    def _add_to(self, view: _core.View) -> None:
        """Add the solid to the engine's view; for the package itself."""
        state = self.__dict__
        look = (self.color, self.light, state["_image"], self.scale)
        finish = (self.roughness, self.metal, state["_finish_image"], self.glass or 0)
        for part in parts(self.shape):
            if isinstance(part, Mesh):
                view.add_mesh(native_of(part), *look, *finish)
            else:
                view.add_object(native_of(part), *look, *finish)


@value()
class Light(Value):
    """A point light for solids and lit particles, such as a lamp or a fire.

    Its intensity falls off with the square of the distance. A renderer's lights may change between frames: a
    fire's light can follow its emitter.
    """

    position: ArrayLike | Curve
    """The light's position, m."""
    color: ArrayLike | Curve = (1, 1, 1)
    """The light's colour, linear RGB."""
    power: float | Curve = 1
    """The light that reaches a surface facing it from 1 m."""
    radius: float | Curve = 0
    """The light's radius, m: solids' shadows get soft edges and also fall on lit particles. 0: a point, whose
    shadows are sharp and fall only on solids."""
    spot: tuple[ArrayLike, float] | None = None
    """A direction, and the angle between opposite sides of a cone around it, degrees, above 0 to 360: the
    light shines only within the cone, whose edge is soft over its outermost tenth. None: it shines
    everywhere."""
    _may_move = True

    def __post_init__(self) -> None:
        """Check the arguments."""
        state = self.__dict__
        state["position"] = arguments.place("position", self.position)
        state["color"] = arguments.color("color", self.color, low=0, high=arguments.FARTHEST)
        state["power"] = arguments.number("power", self.power, low=0, high=1e6)
        state["radius"] = arguments.number("radius", self.radius, low=0, high=1e6)
        state["spot"] = _spot("spot", self.spot)


def _spot(name: str, given: Any) -> tuple[Triple, float] | None:
    if given is None:
        return None
    parts = arguments.listed(name, given, SPOT)
    if len(parts) != 2 or isinstance(given, str):
        raise ArgumentError(name, given, SPOT)
    direction = arguments.place(name, parts[0])
    degrees = arguments.number(name, parts[1], low=0, high=360)
    if not any(direction) or not degrees:
        raise ArgumentError(name, given, SPOT)
    return direction, degrees


def add_to(solid: Solid, view: _core.View) -> None:
    """Add a solid to the engine's view, for the rest of the package."""
    solid._add_to(view)


def parts(shape: Shape | Mesh) -> Iterator[Shape | Mesh]:
    """Yield the shapes of a union, or the shape itself."""
    yield from shape.shapes if isinstance(shape, Union) else (shape,)
