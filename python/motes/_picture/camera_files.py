"""Reads cameras, moving or not, from .glb and .usd files."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._values import arguments
from .._values.curves import Curve
from ..errors import ArgumentError, MissingExtraError

__all__ = ["read_camera"]

MOST_KEYS = 100_000
STEP_S = 1 / 60
"""Time between two key frames of what a file says between its own."""

Facts = dict[str, Any]


def read_camera(path: str | os.PathLike[str]) -> Facts:
    """Return the arguments of the first camera of a file. Raises ArgumentError, MissingExtraError."""
    from .._meshes import MOVING, Unreadable

    file = arguments.file_path("path", path)
    if file.suffix.lower() not in MOVING:
        raise ArgumentError("path", os.fspath(path), f"a name ending in {', '.join(MOVING)}")
    arguments.existing_file("path", path)
    try:
        times, at = (_of_glb if file.suffix.lower() == ".glb" else _of_usd)(file)
        if len(times) > MOST_KEYS:
            raise Unreadable(f"it moves for {times[-1]:g} s, more than {MOST_KEYS} key frames")
        frames = [at(time) for time in times]
        return {name: _over_time(times, [frame[name] for frame in frames]) for name in frames[0]}
    except MissingExtraError:
        raise
    except Exception as error:  # of any kind: a damaged file can fail anywhere
        reason = str(error).strip() or type(error).__name__
        raise ArgumentError("path", os.fspath(path), f"a camera that can be read ({reason})") from None


def _over_time(times: list[float], values: list[Any]) -> Any:
    if all(value == values[0] for value in values):
        return values[0]
    return Curve(list(zip(times, values, strict=True)))


def _steps(times: list[float], step: float) -> list[float]:
    """Return times with others between them, so that what turns between two is followed."""
    if len(times) < 2:
        return times or [0.0]
    count = min(math.ceil((times[-1] - times[0]) / step - 1e-6), MOST_KEYS)
    between = np.linspace(times[0], times[-1], max(count, 1) + 1)
    return sorted({round(time, 9) for time in (*times, *between.tolist())})


def _pose(place: NDArray[np.float64], far: float) -> Facts:
    """Return where a camera is and looks; `place`: its transform, whose view is along -z; `far`: m."""
    axes = place[:3, :3] / np.linalg.norm(place[:3, :3], axis=0)
    position = place[:3, 3]
    look_at = position - axes[:, 2] * far
    facts = {"position": position, "look_at": look_at, "up": axes[:, 1]}
    return {name: tuple(round(one, 9) + 0.0 for one in row.tolist()) for name, row in facts.items()}


# --- formats: times of key frames, s, and a function that returns the arguments at a time


def _of_glb(file: Path) -> tuple[list[float], Callable[[float], Facts]]:
    from .._meshes.accessors import Accessors
    from .._meshes.glb import Scene, chunks
    from .._meshes.gltf_materials import Materials
    from .._meshes.gltf_motion import Motion
    from .._meshes.polygons import Unreadable

    document, binary = chunks(file.read_bytes())
    accessors = Accessors(file, document, binary)
    motion, materials = Motion(document, accessors), Materials(document, accessors)

    def seen(time: float) -> tuple[int, NDArray[np.float64]]:
        cameras = Scene(motion.posed(time), accessors, materials).places("camera")
        if not cameras:
            raise Unreadable("it has no camera")
        return cameras[0]

    number = seen(0.0)[0]
    facts = document["cameras"][number]
    if facts["type"] != "perspective":
        raise Unreadable(f"its camera is {facts['type']}, not perspective")
    lens = facts["perspective"]

    def at(time: float) -> Facts:
        more = {"fov_deg": math.degrees(lens["yfov"]), "near": lens["znear"]}
        return _pose(seen(time)[1], 1.0) | more

    return _steps(motion.times(), STEP_S), at


def _of_usd(file: Path) -> tuple[list[float], Callable[[float], Facts]]:
    from .._meshes.polygons import Unreadable
    from .._meshes.usd import Stage

    stage = Stage(file, None)
    geom = stage.pxr.UsdGeom
    prim = next(stage.prims(geom.Camera), None)
    if prim is None:
        raise Unreadable("it has no camera")
    camera = geom.Camera(prim)
    if camera.GetProjectionAttr().Get(stage.code) == geom.Tokens.orthographic:
        raise Unreadable("its camera is orthographic, not perspective")
    codes = {code for attribute in prim.GetAttributes() for code in attribute.GetTimeSamples()}
    above = prim
    while above and not above.IsPseudoRoot():
        if above.IsA(geom.Xformable):
            codes |= set(geom.Xformable(above).GetTimeSamples())
        above = above.GetParent()
    times = [(code - stage.start) / stage.per_second for code in sorted(codes)]

    def at(time: float) -> Facts:
        code = stage.code_of(time)
        lens = camera.GetCamera(code)
        focus = lens.focusDistance * stage.metres
        wide = lens.focalLength / 10 * stage.metres / lens.fStop if lens.fStop > 0 and focus > 0 else 0
        fov = 2 * math.degrees(math.atan(lens.verticalAperture / 2 / lens.focalLength))
        facts = {"fov_deg": fov, "near": lens.clippingRange.min * stage.metres}
        facts |= {"focus": focus if focus > 0 else None, "aperture": wide}
        return _pose(stage.in_world(prim, code), focus if focus > 0 else 1.0) | facts

    moving = any(at(time) != at(times[0]) for time in times)
    return _steps(times if moving else times[:1], 1 / stage.per_second), at
