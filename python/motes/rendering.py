"""What a picture shows and from where: Renderer, Camera, Sprite, Solid. Colours are linear RGB in 0..1."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from numpy.typing import ArrayLike

from . import _core, arguments
from .errors import ArgumentError
from .shapes import Blob, Line, Point, Shape, Union

__all__ = ["Camera", "Renderer", "Solid", "Sprite"]

OBJECTS = "a list of motes.Solid or shapes"


class Camera:
    """A pinhole camera. Its attributes may change between frames; rendering checks them."""

    def __init__(
        self,
        position: ArrayLike,
        look_at: ArrayLike,
        up: ArrayLike = (0, 1, 0),
        fov_deg: float = 40,
        near: float = 0.1,
    ) -> None:
        """Take where it stands and looks (m), the vertical angle of view, and the nearest seen distance."""
        self.position = position
        self.look_at = look_at
        self.up = up
        self.fov_deg = fov_deg
        self.near = near
        self._vectors()

    def _vectors(self) -> list[arguments.Triple]:
        return [
            arguments.triple("position", self.position),
            arguments.triple("look_at", self.look_at),
            arguments.triple("up", self.up),
        ]

    def __repr__(self) -> str:
        """Show where it stands and looks."""
        return f"Camera({self.position!r}, {self.look_at!r}, fov_deg={self.fov_deg!r})"


@dataclass(frozen=True)
class Solid:
    """An external object (paper 3.2.4): a shape that has a surface, or a union of such, with a colour.

    It is drawn, lit, throws a shadow, and hides the particles behind it. Point, Line and Blob have none.
    """

    shape: Shape
    color: ArrayLike = (0.8, 0.8, 0.8)

    def __post_init__(self) -> None:
        """Check the arguments."""
        if not isinstance(self.shape, Shape):
            raise ArgumentError("shape", self.shape, "a shape of motes.shapes")
        if any(isinstance(part, (Point, Line, Blob)) for part in _parts(self.shape)):
            raise ArgumentError("shape", self.shape, "a shape with a surface: not a Point, Line or Blob")
        arguments.triple("color", self.color, low=0)


class Sprite:
    """How particles of a system are drawn: `point` or soft `disc`, `pixels` wide, their light added up."""

    def __init__(self, kind: str = "disc", pixels: int = 5, blend: str = "add") -> None:
        """Take the kind, the diameter of a disc in pixels (1..15), and the blending, which is "add"."""
        self.kind = arguments.choice("kind", kind, ("point", "disc"))
        self.pixels = arguments.integer("pixels", pixels, low=1, high=15)
        self.blend = arguments.choice("blend", blend, ("add",))
        self.core = _core.Sprite(self.kind, self.pixels)

    def __repr__(self) -> str:
        """Show the call."""
        return f"Sprite({self.kind!r}, pixels={self.pixels})"


class Renderer:
    """How frames are made: size in pixels, camera, background, exposure and external objects."""

    def __init__(
        self,
        width: int,
        height: int,
        *,
        camera: Camera,
        background: ArrayLike = (0, 0, 0),
        exposure: float = 1,
        objects: Iterable[Solid | Shape] = (),
        path: str = "auto",
        linear: bool = False,
    ) -> None:
        """Take the picture's facts; attributes may change between frames, but for `linear`.

        `path`: how particles become one picture: "gather" is the paper's, records to the image generator;
        "auto" chooses. `linear`: keep each frame's light, so that `Frame.linear` can be asked for.
        """
        self.width, self.height, self.camera = width, height, camera
        self.background, self.exposure = background, exposure
        self.objects: Iterable[Solid | Shape] = arguments.listed("objects", objects, OBJECTS)
        self.path = arguments.choice("path", path, ("auto", "gather"))
        self.linear = arguments.flag("linear", linear)
        self.view()

    def view(self) -> _core.View:
        """Check everything and return the engine's value."""
        camera = self.camera
        if not isinstance(camera, Camera):
            raise ArgumentError("camera", camera, "a motes.Camera")
        given = arguments.listed("objects", self.objects, OBJECTS)
        return _core.View(
            width=arguments.integer("width", self.width, low=1, high=16384),
            height=arguments.integer("height", self.height, low=1, high=16384),
            camera=camera._vectors(),
            fov_deg=arguments.number("fov_deg", camera.fov_deg),
            near=arguments.number("near", camera.near, low=0),
            background=arguments.triple("background", self.background, low=0),
            exposure=arguments.number("exposure", self.exposure, low=0, high=1e6),
            objects=[part for value in given for part in _solid(value)],
        )


def _parts(shape: Shape) -> tuple[Shape, ...]:
    return shape.shapes if isinstance(shape, Union) else (shape,)


def _solid(value: Any) -> list[tuple[_core.Shape, arguments.Triple]]:
    solid = Solid(value) if isinstance(value, Shape) else value
    if not isinstance(solid, Solid):
        raise ArgumentError("objects", value, OBJECTS)
    color = arguments.triple("color", solid.color, low=0)
    return [(part.core, color) for part in _parts(solid.shape)]
