"""Warnings about probable mistakes in a system's first frame."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from .. import actions
from .._picture.rendering import Renderer, solids_of
from .._picture.solids import parts
from .._values import colors as texts
from .._values.values import at
from ..shapes import Shape
from ..shapes._mesh import Mesh
from .distributions import AlongNormal, Normal, SurfaceColor, Uniform

__all__ = ["FirstFrame", "camera_inside", "remarks_on"]

RAMPS = (actions.ColorOverLife, actions.AlphaOverLife, actions.SizeOverLife)
PUSHES = (
    actions.Gravity,
    actions.RandomAcceleration,
    actions.Jet,
    actions.Explosion,
    actions.OrbitPoint,
    actions.OrbitLine,
    actions.Vortex,
    actions.Wind,
    actions.CurlNoise,
    actions.TargetVelocity,
    actions.RandomVelocity,
)
LEAST_BYTE = (
    16  # colours of whole numbers with a maximum of 16..255 look like bytes; light somewhat above 1 is usual
)


class Seen(Protocol):
    """The part of a system that the checks use."""

    name: str
    first: FirstFrame | None
    has_births: bool
    entries: list[Any]


def remarks_on(systems: Iterable[Seen], renderer: Renderer | None) -> Iterator[str]:
    """Yield remarks on systems whose first list with births has run, and on the first picture."""
    for system in systems:
        if system.first is not None and system.has_births and system.entries:
            first, system.first = system.first, None
            if remarks := first.remarks(system.entries):
                yield f"system {system.name!r}: {'; '.join(remarks)}"
    if renderer is not None:
        yield from camera_inside(renderer)


class FirstFrame:
    """Notes what the script sets for a system until its first list has run."""

    def __init__(self) -> None:
        """Start without notes."""
        self.free = False
        """Whether the script opened `local()`, where it may write anything: then nothing is checked."""
        self._bounds: dict[str, tuple[NDArray[Any], NDArray[Any]]] = {}

    def configured(self, state: Mapping[str, Any]) -> None:
        """Note the attributes of newborn particles."""
        for name, value in state.items():
            self._bounds[name] = _bounds(value)

    def emitted(self, columns: Iterable[tuple[str, NDArray[Any]]]) -> None:
        """Note the columns of particles given as arrays."""
        for name, column in columns:
            if len(column):
                self._bounds[name] = column.min(axis=0), column.max(axis=0)

    def remarks(self, recorded: Sequence[Any]) -> list[str]:
        """Return remarks on probable mistakes in the first frame's list."""
        if self.free or any(callable(item) for item in recorded):
            return []
        remarks = [*self._motion(recorded), *self._lifetime(recorded)]
        colors = [("color", bounds) for name, bounds in self._bounds.items() if name == "color"]
        sizes = [(name, low) for name, (low, _) in self._bounds.items() if name in ("size", "lifetime")]
        for item in recorded:
            if isinstance(item, actions.TargetColor):
                colors.append(("target_color", _bounds(item.color)))
            elif isinstance(item, actions.ColorOverLife):
                colors.append(("color_over_life", _bounds([color for _, color in item.ramp])))
            elif isinstance(item, actions.TargetSize):
                sizes.append(("target_size", np.asarray(item.size)))
            elif isinstance(item, actions.SizeOverLife):
                sizes.append(("size_over_life", np.asarray([size for _, size in item.ramp])))
        remarks += [
            f"{name}: colours are linear RGB in 0..1, {_shown(bounds[1])} looks like 0..255: divide it by 255"
            for name, bounds in colors
            if _looks_like_bytes(*bounds)
        ]
        remarks += [f"{name} may be negative ({_shown(low)})" for name, low in sizes if np.min(low) < 0]
        return remarks

    def _motion(self, recorded: Sequence[Any]) -> list[str]:
        moves = [i for i, item in enumerate(recorded) if isinstance(item, actions.Move)]
        bounces = [i for i, item in enumerate(recorded) if isinstance(item, actions.Bounce)]
        if moves and bounces and bounces[-1] > moves[-1]:
            return ["bounce after move: record bounce before move, so that move follows the rebound"]
        if moves:
            return []
        if any(isinstance(item, PUSHES) for item in recorded) or self._given("velocity"):
            return ["particles have velocities, but none moves: record move() after the actions"]
        if any(isinstance(item, (*RAMPS, actions.KillExpired)) for item in recorded):
            return ["particles do not age without move(): record it after the actions"]
        return []

    def _lifetime(self, recorded: Sequence[Any]) -> list[str]:
        if "lifetime" in self._bounds:
            return []
        if any(isinstance(item, actions.Set) and item.attribute == "lifetime" for item in recorded):
            return []
        needs = (*RAMPS, actions.KillExpired)
        names = ", ".join(dict.fromkeys(type(one).__name__ for one in recorded if isinstance(one, needs)))
        return [f"{names} without a lifetime: configure(lifetime=...) gives one"] if names else []

    def _given(self, name: str) -> bool:
        low, high = self._bounds.get(name, (np.zeros(1), np.zeros(1)))
        return bool(np.any(low) or np.any(high))


def camera_inside(renderer: Renderer) -> list[str]:
    """Return a remark if the camera is inside a solid."""
    position = at(renderer.camera.position, 0)
    for solid in solids_of(renderer):
        # Meshes are skipped: a mesh that is only drawn may be open, and has no distance field.
        if any(bool(part.contains(position)) for part in parts(solid.shape) if not isinstance(part, Mesh)):
            return [f"the camera at {position} is inside the solid {solid.shape!r}"]
    return []


def _bounds(value: Any) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the smallest and largest value of each component; zeros for text such as "random"."""
    if isinstance(value, Uniform):
        low, high = value.lo, value.hi
    elif isinstance(value, Normal):
        low = high = value.mean
    elif isinstance(value, str):  # such as "random"
        return np.zeros(1), np.zeros(1)
    elif isinstance(value, Shape):
        points = value.sample(64).astype(np.float64)
        return points.min(axis=0), points.max(axis=0)
    elif isinstance(value, AlongNormal):
        low = high = value.length
    elif isinstance(value, SurfaceColor):
        low = high = 1.0
    else:
        low = high = value
    return np.atleast_1d(_numbers(low)), np.atleast_1d(_numbers(high))


def _numbers(value: Any) -> NDArray[Any]:
    """Return a value or a list of values as an array; convert colours given as text to numbers."""
    if isinstance(value, str):
        value = texts.named("color", value)
    elif isinstance(value, list):
        value = [texts.named("color", one) if isinstance(one, str) else one for one in value]
    return np.asarray(value, np.float64)


def _looks_like_bytes(low: NDArray[Any], high: NDArray[Any]) -> bool:
    both = np.concatenate([low.ravel(), high.ravel()])
    return bool((both == np.floor(both)).all() and both.min() >= 0 and LEAST_BYTE <= both.max() <= 255)


def _shown(values: NDArray[Any]) -> str:
    numbers = [f"{value:g}" for value in np.ravel(values)]
    return numbers[0] if len(numbers) == 1 else f"({', '.join(numbers)})"
