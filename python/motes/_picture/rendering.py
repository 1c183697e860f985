"""Renderer and Camera: what a picture shows, and from where. Colours are linear RGB in 0..1."""

from __future__ import annotations

import os
from collections.abc import Iterable
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._values import arguments, environment
from .._values.arguments import Triple
from .._values.curves import Curve
from .._values.values import Settings, at, says_near_names, shown, times_of
from ..errors import ArgumentError
from ..shapes import Shape
from ..shapes._mesh import Mesh
from . import skies
from .skies import Gradient, Panorama
from .solids import Light, Solid, add_to

__all__ = [
    "LAYERS",
    "PARTICLES",
    "Camera",
    "Renderer",
    "camera_of",
    "frame_arguments",
    "looking",
    "preview_of",
    "solids_of",
    "view_of",
]

LAYERS = ("depth", "alpha", "velocity")
"""Layers that the engine keeps with a picture."""
PARTICLES = "particles"
"""The layer that is drawn by itself."""
LIGHTS = "a list of motes.Light"
FOG = "a colour and metres, or None"
OBJECTS = "a list of motes.Solid, shapes or meshes"


class Camera(Settings):
    """A pinhole camera.

    Its attributes may change between frames, or be curves (`motes.Curve`). Cameras compare and hash by their
    current attributes.
    """

    position: Triple
    """The camera's position, m."""
    look_at: Triple
    """The point at the centre of the picture, m."""
    up: Triple
    """The direction that points up in the picture."""
    fov_deg: float
    """Vertical angle of view, degrees."""
    near: float
    """The near plane's distance, m: nothing nearer is drawn."""
    focus: float | None
    """The distance of sharp focus, m; None: everything is sharp."""
    aperture: float
    """Diameter of the lens, m: what is out of focus spreads over its circle of confusion, with the same total
    light. 0: a pinhole, everything is sharp. The sky always stays sharp."""

    _checks = {
        "position": arguments.place,
        "look_at": arguments.place,
        "up": arguments.place,
        "fov_deg": lambda name, given: _above_0(name, given, below=180),
        "near": lambda name, given: _above_0(name, given, below=arguments.FARTHEST),
        "focus": lambda name, given: _focus(name, given),
        "aperture": partial(arguments.number, low=0, high=1e6),
    }
    _may_move = frozenset(_checks)

    @says_near_names
    def __init__(
        self,
        position: ArrayLike | Curve,
        look_at: ArrayLike | Curve,
        up: ArrayLike | Curve = (0, 1, 0),
        fov_deg: float | Curve = 40,
        near: float | Curve = 0.1,
        focus: float | Curve | None = None,
        aperture: float | Curve = 0,
    ) -> None:
        """Set the attributes, which are described at their declarations."""
        given: dict[str, Any] = {"position": position, "look_at": look_at, "up": up, "fov_deg": fov_deg}
        given |= {"near": near, "focus": focus, "aperture": aperture}
        for name, one in given.items():
            setattr(self, name, one)
        for time in (0.0, *times_of(given.values())):
            self._set_in(view := _core.View(1, 1), time)
            view.check()

    def _set_in(self, view: _core.View, time: float, pose: tuple[Any, ...] | None = None) -> None:
        """Set the engine's camera to the attributes at a time (s); `pose` replaces the first of them."""
        now = {name: at(self.__dict__[name], time) for name in self._checks}
        if now["aperture"] > 0 and now["focus"] is None:
            raise ArgumentError(
                "focus", None, "given with an aperture: the distance in metres at which objects are sharp"
            )
        now["focus"] = now["focus"] or 0
        given = list(now.values())
        view.set_camera(*(given if pose is None else (*pose, *given[len(pose) :])))

    def __eq__(self, other: object) -> bool:
        """Return whether all current attributes are equal."""
        return isinstance(other, Camera) and self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        """Hash the current attributes."""
        return hash((Camera, *self.__dict__.values()))

    def __repr__(self) -> str:
        """Return a call that creates an equal camera."""
        defaults = {"focus": None, "aperture": 0}
        given = {name: self.__dict__[name] for name in self._checks}
        fields = [f"{name}={shown(one)}" for name, one in given.items() if one != defaults.get(name, self)]
        return f"Camera({', '.join(fields)})"


class Renderer(Settings):
    """How frames are drawn: camera, size, objects and lights.

    All attributes but `linear` may change between frames; numbers and vectors may be curves (`motes.Curve`).
    """

    width: int
    """The picture's width, pixels."""
    height: int
    """The picture's height, pixels."""
    camera: Camera
    """The camera; its attributes may change between frames, too."""
    background: Triple | Gradient | Panorama
    """The sky: a colour, a `motes.Gradient`, or an equirectangular picture centred on -z: a path to an .exr
    or .hdr file or one that Pillow reads, or an array (height, width, 3), sRGB uint8 or linear floats. Of an
    .exr the display window counts; values of an .hdr are divided by its `EXPOSURE`. A gradient or picture
    also lights solids and lit sprites, at half its brightness: each point by the half of the sky that its
    surface faces."""
    fog: tuple[Triple, float] | None
    """A colour, and the distance in metres over which light falls to 1/e while the fog's colour fills in. Fog
    covers solids and particles, but not the sky. None: solids fade into the background far away."""
    exposure: float
    """The factor by which light is multiplied before display."""
    objects: tuple[Solid | Shape | Mesh, ...]
    """Solids; a shape or mesh becomes a solid of the default colour."""
    sun: Triple
    """The direction to the sun, which lights solids, spheres, meshes and lit sprites; (0, 0, 0): no sun."""
    sun_color: Triple
    """The colour of the sun's light, linear RGB."""
    sun_power: float
    """The sun's strength: a surface that faces it gets `sun_power` times 0.7 of `sun_color`."""
    sun_size: float
    """The sun's angular diameter, degrees, 0..90 (0.53 from the earth): solids' shadows get soft edges and
    also fall on lit particles. 0: a point, whose shadows are sharp and fall only on solids."""
    lights: tuple[Light, ...]
    """Lights besides the sun."""
    path: Literal["auto", "gather", "tiles", "composite"]
    """Who draws the particles; the pixels are the same. "gather": only the image generator (the paper).
    "tiles": each rank draws a part of the picture. "composite": each calculator draws its own particles
    tile by tile, and the tiles' owners merge them, if the blends allow it. "auto" chooses for each frame."""
    shutter: float
    """How long the shutter is open, in frames, 0..4: moving particles become streaks."""
    bloom: float
    """The fraction of light that spreads around bright areas, 0..1."""
    occlusion: float
    """The part of the sky's light, 0..1, that is lost where opaque things are near on all sides: solids and
    opaque particles darken what they touch, up to 0.15 times the picture's height at `look_at` away."""
    smooth: bool
    """Whether edges of solids are anti-aliased."""
    linear: bool
    """Whether frames keep linear light for `Frame.linear`, `.exr` and PNG with 16 bits."""
    layers: tuple[Literal["depth", "alpha", "velocity", "particles"], ...]
    """The layers that frames keep for `Frame.layer` and `.exr`: any of "depth", "alpha", "velocity" and
    "particles", for which each picture is drawn twice."""

    _checks = {
        "width": partial(arguments.integer, low=1, high=16384),
        "height": partial(arguments.integer, low=1, high=16384),
        "camera": lambda name, given: _camera(name, given),
        "background": skies.background,
        "fog": lambda name, given: _fog(name, given),
        "exposure": partial(arguments.number, low=0, high=1e6),
        "objects": lambda name, given: _objects(name, given),
        "sun": arguments.place,
        "sun_color": partial(arguments.color, low=0, high=arguments.FARTHEST),
        "sun_power": partial(arguments.number, low=0, high=1e6),
        "sun_size": partial(arguments.number, low=0, high=90),
        "lights": lambda name, given: _lights(name, given),
        "path": partial(arguments.choice, allowed=("auto", "gather", "tiles", "composite")),
        "shutter": partial(arguments.number, low=0, high=4),
        "bloom": partial(arguments.number, low=0, high=1),
        "occlusion": partial(arguments.number, low=0, high=1),
        "smooth": arguments.flag,
        "layers": lambda name, given: _layers(name, given),
    }
    _may_move = frozenset(
        (
            "background",
            "exposure",
            "sun",
            "sun_color",
            "sun_power",
            "sun_size",
            "shutter",
            "bloom",
            "occlusion",
        )
    )

    @says_near_names
    def __init__(
        self,
        width: int,
        height: int,
        *,
        camera: Camera,
        background: ArrayLike | Curve | Gradient | str | os.PathLike[str] = (0, 0, 0),
        exposure: float | Curve = 1,
        objects: Iterable[Solid | Shape | Mesh] = (),
        sun: ArrayLike | Curve = (-0.5, 0.8, 0.4),
        lights: Iterable[Light] = (),
        path: Literal["auto", "gather", "tiles", "composite"] = "auto",
        shutter: float | Curve = 0,
        bloom: float | Curve = 0,
        smooth: bool = True,
        linear: bool = False,
        layers: Iterable[Literal["depth", "alpha", "velocity", "particles"]] = (),
        fog: tuple[ArrayLike | str, float] | None = None,
        sun_size: float | Curve = 0,
        sun_color: ArrayLike | Curve = "white",
        sun_power: float | Curve = 1,
        occlusion: float | Curve = 0,
    ) -> None:
        """Set the attributes, which are described at their declarations."""
        given = {"width": width, "height": height, "camera": camera, "background": background}
        given |= {"exposure": exposure, "objects": objects, "sun": sun, "lights": lights, "path": path}
        given |= {"shutter": shutter, "bloom": bloom, "smooth": smooth, "layers": layers, "fog": fog}
        given |= {"sun_size": sun_size, "sun_color": sun_color, "sun_power": sun_power}
        given |= {"occlusion": occlusion}
        for name, one in given.items():
            setattr(self, name, one)
        self.__dict__["linear"] = arguments.flag("linear", linear)
        what_moves = (self.camera, self, *self.lights)
        for time in (0.0, *times_of(value for one in what_moves for value in vars(one).values())):
            self._view(time)

    def _view(self, time: float, pose: tuple[Any, ...] | None = None) -> _core.View:
        """Return the engine's view at a time (s), after checking that the attributes fit together.

        `pose`: position, look_at, up and fov_deg that replace the camera's.
        """
        view = _core.View(*preview_of(self.width, self.height))
        if view.height != self.height:
            view.set_full_height(self.height)
        self.camera._set_in(view, time, pose)
        skies.set_background(view, at(self.background, time))
        if self.fog is not None:
            view.set_fog(*self.fog)
        view.set_exposure(at(self.exposure, time))
        for solid in self._solids:
            add_to(solid, view)
        view.set_sun(
            at(self.sun, time), at(self.sun_size, time), at(self.sun_color, time), at(self.sun_power, time)
        )
        for light in self.lights:
            now: Any = at(light, time)
            view.add_light(now.position, now.color, now.power, now.radius, *(now.spot or ((0, -1, 0), 0)))
        view.set_path(self.path)
        view.set_shutter(at(self.shutter, time))
        view.set_bloom(at(self.bloom, time))
        view.set_occlusion(at(self.occlusion, time))
        view.set_smooth(self.smooth)
        view.set_linear(self.linear)
        view.set_layers(sum(1 << LAYERS.index(name) for name in self.layers if name in LAYERS))
        view.check()
        return view

    @property
    def _solids(self) -> list[Solid]:
        """The objects as solids."""
        return [one if isinstance(one, Solid) else Solid(one) for one in self.objects]


def view_of(renderer: Renderer, time: float, pose: tuple[Any, ...] | None = None) -> _core.View:
    """Return the engine's view at a time (s), from the camera or another pose; for the package itself."""
    return renderer._view(time, pose)


def camera_of(renderer: Renderer, time: float, pose: tuple[Any, ...] | None = None) -> _core.View:
    """Return a view of which only the camera is set, at a time (s); for the package itself."""
    view = _core.View(1, 1)
    renderer.camera._set_in(view, time, pose)
    return view


def looking(camera: Camera, time: float) -> tuple[NDArray[np.float64], ...]:
    """Return where a camera is at a time (s), m, and its axes: right, up, and back, against the view."""
    eye = np.array(at(camera.position, time), np.float64)
    back = eye - at(camera.look_at, time)
    back /= np.linalg.norm(back)
    right = np.cross(at(camera.up, time), back)
    right /= np.linalg.norm(right)
    return eye, right, np.cross(back, right), back


def preview_of(width: int, height: int) -> tuple[int, int]:
    """Return the size of a picture, px: half of it if the environment asks for previews."""
    if not environment.read("MOTES_PREVIEW"):
        return width, height
    return -(-width // 2), -(-height // 2)


def solids_of(renderer: Renderer) -> list[Solid]:
    """Return the objects of a renderer as solids, for the rest of the package."""
    return renderer._solids


def frame_arguments(view: _core.View, engine: _core.Engine) -> dict[str, Any]:
    """Return a `Frame`'s arguments besides its pixels; they fetch data while the engine has the picture.

    `view`: the view that was drawn; the renderer may have changed since.
    """
    size = (view.height, view.width)
    named = [name for bit, name in enumerate(LAYERS) if view.layers & 1 << bit]
    shapes = {name: (*size, 3) if name == "velocity" else size for name in named}
    return {
        "linear": (lambda: engine.linear().reshape(*size, 3)) if view.linear else None,
        "exposure": view.exposure,
        "layers": {name: partial(_layer, engine, name, shape) for name, shape in shapes.items()},
    }


def _above_0(name: str, given: Any, *, below: float) -> float:
    number = arguments.number(name, given)
    if not 0 < number < below:
        raise ArgumentError(name, given, f"a number above 0 and below {below:g}")
    return number


def _focus(name: str, given: Any) -> float | None:
    if given is None:
        return None
    number = arguments.number(name, given)
    if not 0 < number < arguments.FARTHEST:
        raise ArgumentError(name, given, "metres in front of the camera, above 0")
    return number


def _fog(name: str, given: Any) -> tuple[Triple, float] | None:
    if given is None:
        return None
    parts = arguments.listed(name, given, FOG)
    if len(parts) != 2 or isinstance(given, str):
        raise ArgumentError(name, given, FOG)
    color = arguments.color(name, parts[0], low=0, high=arguments.FARTHEST)
    metres = arguments.number(name, parts[1], low=1e-6, high=arguments.FARTHEST)
    return color, metres


def _camera(name: str, given: Any) -> Camera:
    if not isinstance(given, Camera):
        raise ArgumentError(name, given, "a motes.Camera")
    return given


def _objects(name: str, given: Any) -> tuple[Solid | Shape | Mesh, ...]:
    objects = arguments.listed(name, given, OBJECTS)
    for one in objects:
        if isinstance(one, (Shape, Mesh)):
            Solid(one)  # which checks that it has a surface
        elif not isinstance(one, Solid):
            raise ArgumentError(name, one, OBJECTS)
    return tuple(objects)


def _lights(name: str, given: Any) -> tuple[Light, ...]:
    lights = arguments.listed(name, given, LIGHTS)
    for one in lights:
        if not isinstance(one, Light):
            raise ArgumentError(name, one, LIGHTS)
    return tuple(lights)


def _layers(name: str, given: Any) -> tuple[str, ...]:
    known = (*LAYERS, PARTICLES)
    allowed = "a list of " + ", ".join(map(repr, known))
    if isinstance(given, str):
        raise ArgumentError(name, given, allowed)
    named = arguments.listed(name, given, allowed)
    for one in named:
        if not isinstance(one, str) or one not in known:
            raise ArgumentError(name, one, allowed, known=known)
    return tuple(layer for layer in known if layer in named)


def _layer(engine: _core.Engine, name: str, shape: tuple[int, ...]) -> NDArray[np.float32]:
    return engine.layer(1 << LAYERS.index(name)).reshape(shape)
