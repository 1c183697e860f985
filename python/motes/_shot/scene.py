"""What a picture shows besides particles, as prims of USD: camera, sun, lamps, sky and solids."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .._picture.rendering import Renderer, looking, solids_of
from .._picture.skies import Gradient, Panorama
from .._picture.solids import Light
from .._values.values import at
from . import words
from .facts import CAMERA, Prim, Scene
from .files import Files
from .forms import frame_along
from .solids import solids

__all__ = ["scene_of"]

HEIGHT = 0.24
"""The film's height, tenths of a metre: 24 mm."""
FARTHEST = 1e6
SUN = 0.7 * math.pi
"""The irradiance of a sun of power 1, of which a white surface reflects 0.7."""
LAMP = 4 * math.pi
"""The intensity of a lamp of power 1, which USD spreads over a sphere's surface."""


def scene_of(renderer: Renderer, time: float, files: Files, before: Scene | None) -> Scene:
    """Return what a frame shows besides sprites, and note the files that it needs.

    `time`: of the renderer's curves, s; `before`: the frame before, whose solids keep their names.
    """
    world: dict[str, Prim] = {CAMERA: _camera(renderer, time)}
    sun = np.array(at(renderer.sun, time), float)
    if sun.any() and at(renderer.sun_power, time) > 0:
        world["Sun"] = _sun(renderer, sun, time)
    for number, light in enumerate(renderer.lights, 1):
        world[f"Lamp_{number}"] = _lamp(at(light, time))
    world["Sky"] = _sky(at(renderer.background, time), files)
    shapes = solids(solids_of(renderer), files, {} if before is None else before["solids"])
    return {"world": world, "solids": shapes, "looks": {}}


def _camera(renderer: Renderer, time: float) -> Prim:
    camera = renderer.camera
    focal = HEIGHT / 2 / math.tan(math.radians(at(camera.fov_deg, time)) / 2)
    aperture, shutter = at(camera.aperture, time), at(renderer.shutter, time)
    eye, *axes = looking(camera, time)
    place = np.eye(4)
    place[:3] = np.stack([*axes, eye], axis=1)
    values = {
        "matrix4d xformOp:transform": words.matrix(place),
        "float focalLength": words.number(focal),
        "float horizontalAperture": words.number(HEIGHT * renderer.width / renderer.height),
        "float verticalAperture": words.number(HEIGHT),
        "float2 clippingRange": words.vector((at(camera.near, time), FARTHEST)),
        "float focusDistance": words.number(at(camera.focus, time) or 0),
        "float fStop": words.number(focal / 10 / aperture if aperture > 0 else 0),
        "double shutter:open": words.number(-shutter),
        "double shutter:close": "0",
    }
    size = [renderer.width, renderer.height]
    return {"type": "Camera", "values": values, "size": size}


def _shining(toward: Any, position: Any = (0, 0, 0)) -> str:
    """Return the transform of a light that shines along its -z; `toward`: where from."""
    turn = frame_along(toward)
    place = np.eye(4)
    place[:3, :4] = np.stack([turn[:, 2], turn[:, 0], turn[:, 1], np.array(position, float)], axis=1)
    return words.matrix(place)


def _sun(renderer: Renderer, toward: Any, time: float) -> Prim:
    values = {
        "matrix4d xformOp:transform": _shining(toward),
        "color3f inputs:color": words.vector(at(renderer.sun_color, time)),
        "float inputs:intensity": words.number(SUN * at(renderer.sun_power, time)),
        "float inputs:angle": words.number(at(renderer.sun_size, time)),
        "bool inputs:normalize": "1",
    }
    return {"type": "DistantLight", "values": values}


def _lamp(light: Light) -> Prim:
    radius: Any = light.radius
    color: Any = light.color
    power: Any = light.power
    direction, degrees = light.spot or ((0, -1, 0), 0)
    values = {
        "matrix4d xformOp:transform": _shining(-np.array(direction, float), light.position),
        "color3f inputs:color": words.vector(color),
        "float inputs:intensity": words.number(LAMP * power),
        "float inputs:radius": words.number(max(radius, 1e-3)),
        "bool inputs:normalize": "1",
        "bool treatAsPoint": str(int(radius == 0)),
    }
    if light.spot is None:
        return {"type": "SphereLight", "values": values}
    values["float inputs:shaping:cone:angle"] = words.number(degrees / 2)
    values["float inputs:shaping:cone:softness"] = "0.1"
    return {"type": "SphereLight", "values": values, "apis": ["ShapingAPI"]}


def _sky(background: Any, files: Files) -> Prim:
    values = {"float inputs:intensity": "1"}
    if not isinstance(background, (Gradient, Panorama)):
        return {"type": "DomeLight", "values": values | {"color3f inputs:color": words.vector(background)}}
    # The middle of a picture is at -z here, and at z in USD.
    values["matrix4d xformOp:transform"] = words.matrix(np.diag([-1.0, 1, -1, 1]))
    values["token inputs:texture:format"] = '"latlong"'
    if isinstance(background, Panorama):
        picture = files.light(background.light, background.key)
    else:
        picture = files.light(_painted(background), hash_of(background))
    return {"type": "DomeLight", "values": values, "picture": picture}


def hash_of(sky: Gradient) -> Any:
    """Return what decides the picture of a gradient."""
    return ("Gradient", sky.horizon, sky.zenith, sky.ground)


def _painted(sky: Gradient) -> Any:
    """Return a gradient as an equirectangular picture."""
    sine = np.sin(np.linspace(math.pi / 2, -math.pi / 2, 513))
    sine = ((sine[1:] + sine[:-1]) / 2)[:, None]
    horizon = np.array(sky.horizon)
    ground = horizon if sky.ground is None else np.array(sky.ground)
    rows = horizon + np.where(sine > 0, (sky.zenith - horizon) * sine, (horizon - ground) * sine)
    return np.repeat(rows[:, None], 16, axis=1).astype(np.float32)
