"""What a picture shows and from where: Renderer, Camera, Sprite, Solid. Colours are linear RGB in 0..1."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import Any

from numpy.typing import ArrayLike

from . import _core, arguments
from .arguments import Triple
from .errors import ArgumentError
from .shapes import Blob, Line, Point, Shape, Union
from .values import Settings, Value, says_near_names, shown, value

__all__ = ["Camera", "Renderer", "Solid", "Sprite"]

OBJECTS = "a list of motes.Solid or shapes"


class Camera(Settings):
    """A pinhole camera.

    Its attributes may change between frames. Cameras are equal, and hash alike, while all attributes are.
    """

    position: Triple
    """Where it stands, m."""
    look_at: Triple
    """A point in the middle of the picture, m."""
    up: Triple
    """What points up in the picture."""
    fov_deg: float
    """Vertical angle of view, degrees."""
    near: float
    """Nothing nearer than this is drawn, m."""

    _checks = {
        "position": arguments.triple,
        "look_at": arguments.triple,
        "up": arguments.triple,
        "fov_deg": arguments.number,
        "near": partial(arguments.number, low=0),
    }

    @says_near_names
    def __init__(
        self,
        position: ArrayLike,
        look_at: ArrayLike,
        up: ArrayLike = (0, 1, 0),
        fov_deg: float = 40,
        near: float = 0.1,
    ) -> None:
        """Take its position and target (m), the vertical angle of view, and the nearest visible distance."""
        given = {"position": position, "look_at": look_at, "up": up, "fov_deg": fov_deg, "near": near}
        for name, one in given.items():
            setattr(self, name, one)

    def __eq__(self, other: object) -> bool:
        """Equal attributes, as they are now."""
        return isinstance(other, Camera) and self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        """Hash of the attributes as they are now."""
        return hash((Camera, *self.__dict__.values()))

    def __repr__(self) -> str:
        """Show the call that makes an equal camera."""
        arguments = ", ".join(f"{name}={shown(self.__dict__[name])}" for name in self._checks)
        return f"Camera({arguments})"


@value(init=False)
class Solid(Value):
    """An external object (paper 3.2.4): a shape with a surface, or a union of such shapes, and a colour.

    It is drawn, lit, casts a shadow, and hides the particles behind it. Point, Line and Blob have no surface.
    """

    shape: Shape
    color: Triple = (0.8, 0.8, 0.8)

    def __init__(self, shape: Shape, color: ArrayLike = (0.8, 0.8, 0.8)) -> None:
        """Take the shape and its colour."""
        if not isinstance(shape, Shape):
            raise ArgumentError("shape", shape, "a shape of motes.shapes")
        if any(isinstance(part, (Point, Line, Blob)) for part in _parts(shape)):
            raise ArgumentError("shape", shape, "a shape with a surface: not a Point, Line or Blob")
        self.__dict__.update(shape=shape, color=arguments.color("color", color, low=0))


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
        state["_core"] = _core.Sprite(self.kind, self.pixels)

    @property
    def core(self) -> _core.Sprite:
        """The engine's value; for the package itself."""
        made: _core.Sprite = self.__dict__["_core"]
        return made


class Renderer(Settings):
    """How frames are made: size in pixels, camera, background, exposure and external objects.

    All attributes but `linear` may change between frames.
    """

    width: int
    height: int
    camera: Camera
    background: Triple
    exposure: float
    objects: tuple[Solid | Shape, ...]
    path: str
    bloom: float
    linear: bool

    _checks = {
        "width": partial(arguments.integer, low=1, high=16384),
        "height": partial(arguments.integer, low=1, high=16384),
        "camera": lambda name, given: _camera(name, given),
        "background": partial(arguments.color, low=0),
        "exposure": partial(arguments.number, low=0, high=1e6),
        "objects": lambda name, given: _objects(name, given),
        "path": partial(arguments.choice, allowed=("auto", "gather", "tiles", "composite")),
        "bloom": partial(arguments.number, low=0, high=1),
    }

    @says_near_names
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
        bloom: float = 0,
        linear: bool = False,
    ) -> None:
        """Take the attributes.

        `objects`: solids, or shapes for solids of the default colour. `path`: how particles become one
        picture: "gather" is the paper's way, which sends records to the image generator; "auto" chooses.
        `bloom`: the part of the light that spreads around what is bright, 0..1. `linear`: keep each frame's
        light for `Frame.linear`.
        """
        given = {"width": width, "height": height, "camera": camera, "background": background}
        given |= {"exposure": exposure, "objects": objects, "path": path, "bloom": bloom}
        for name, one in given.items():
            setattr(self, name, one)
        self.__dict__["linear"] = arguments.flag("linear", linear)
        self.view()

    def view(self) -> _core.View:
        """Check how the attributes fit together, and return the engine's value."""
        view, camera = _core.View(self.width, self.height), self.camera
        view.set_camera(camera.position, camera.look_at, camera.up, camera.fov_deg, camera.near)
        view.set_background(self.background)
        view.set_exposure(self.exposure)
        for solid in self.solids:
            for part in _parts(solid.shape):
                view.add_object(part.core, solid.color)
        view.set_path(self.path)
        view.set_bloom(self.bloom)
        view.set_linear(self.linear)
        view.check()
        return view

    @property
    def solids(self) -> list[Solid]:
        """The objects as solids."""
        return [Solid(one) if isinstance(one, Shape) else one for one in self.objects]


def _parts(shape: Shape) -> tuple[Shape, ...]:
    return shape.shapes if isinstance(shape, Union) else (shape,)


def _camera(name: str, given: Any) -> Camera:
    if not isinstance(given, Camera):
        raise ArgumentError(name, given, "a motes.Camera")
    return given


def _objects(name: str, given: Any) -> tuple[Solid | Shape, ...]:
    objects = arguments.listed(name, given, OBJECTS)
    for one in objects:
        if isinstance(one, Shape):
            Solid(one)  # which checks that it has a surface
        elif not isinstance(one, Solid):
            raise ArgumentError(name, one, OBJECTS)
    return tuple(objects)
