"""Skies: Gradient and equirectangular pictures, and pictures as linear light. Colours are linear RGB."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core, _extras
from .._values import arguments
from .._values.arguments import Triple
from .._values.images import MOST_SIDE, linear_light, read_picture
from .._values.values import Value, value
from ..errors import ArgumentError, MissingExtraError

__all__ = ["Gradient", "Panorama", "background", "light_key", "light_of", "set_background"]

PICTURE = (
    f"a path, or an array of shape (height, width, 3): uint8 sRGB, or floats, linear RGB in 0..1e6; "
    f"1..{MOST_SIDE} pixels each way"
)
BACKGROUND = f"a colour, a motes.Gradient or an equirectangular picture: {PICTURE}"


@value(init=False)
class Gradient(Value):
    """A sky that changes from horizon to zenith, interpolated by the sine of the elevation.

    For `Renderer(background=)`. It also lights solids, and sprites with `lit`, from all sides.
    """

    horizon: Triple
    """The colour at the horizon, linear RGB."""
    zenith: Triple
    """The colour straight above, linear RGB."""
    ground: Triple | None = None
    """The colour straight below, linear RGB; None: as at the horizon."""

    def __init__(
        self, horizon: ArrayLike | str, zenith: ArrayLike | str, ground: ArrayLike | str | None = None
    ) -> None:
        """Check the colours."""
        given = {"horizon": horizon, "zenith": zenith}
        checked: dict[str, Triple | None] = {name: _color(name, one) for name, one in given.items()}
        checked["ground"] = None if ground is None else _color("ground", ground)
        self.__dict__.update(checked)


class Panorama:
    """An equirectangular picture as linear light; compares and hashes by content."""

    def __init__(self, light: NDArray[np.float32]) -> None:
        """Store the light, float32 (height, width, 3)."""
        self.light = light
        self.key = light_key(light)

    def __eq__(self, other: object) -> bool:
        """Return whether the content is equal."""
        return isinstance(other, Panorama) and self.key == other.key

    def __hash__(self) -> int:
        """Hash the content."""
        return hash((Panorama, self.key))

    def __repr__(self) -> str:
        """Show the size."""
        height, width, _ = self.light.shape
        return f"<sky of {width}x{height} pixels>"


def background(name: str, given: Any) -> Triple | Gradient | Panorama:
    """Check a background; return a picture as a Panorama."""
    if isinstance(given, (Gradient, Panorama)):
        return given
    if isinstance(given, os.PathLike) or (isinstance(given, str) and arguments.is_path(given)):
        return Panorama(light_of(name, given))
    if getattr(given, "ndim", 1) > 1:
        return Panorama(light_of(name, given))
    return arguments.color(name, given, low=0, high=arguments.FARTHEST)


def set_background(view: _core.View, given: Any) -> None:
    """Set a checked background in the engine's view."""
    if isinstance(given, Gradient):
        view.set_gradient(
            given.horizon, given.zenith, given.horizon if given.ground is None else given.ground
        )
    elif isinstance(given, Panorama):
        view.set_sky(given.key)
    else:
        view.set_background(given)


def light_of(argument: str, given: Any) -> NDArray[np.float32]:
    """Return a picture as linear light, float32 (height, width, 3), read-only."""
    if isinstance(given, (str, os.PathLike)):
        path = arguments.existing_file(argument, given)
        if path.suffix.lower() in (".exr", ".hdr", ".pic"):
            given = _read_light(argument, path)
        else:
            given = read_picture(argument, path, most=MOST_SIDE)[:, :, :3]
    return linear_light(argument, given, PICTURE)


def light_key(light: NDArray[np.float32]) -> int:
    """Store a picture of linear light in the engine; return its key, a hash of the content."""
    return _core.keep_light(light)


def _color(name: str, given: Any) -> Triple:
    return arguments.color(name, given, low=0, high=arguments.FARTHEST)


def _read_light(argument: str, path: Any) -> NDArray[np.float32]:
    """Read a picture that holds linear light."""
    from .._io import exr, hdr

    suffix = path.suffix.lower()
    try:
        return exr.read(_extras.openexr(), path, MOST_SIDE) if suffix == ".exr" else hdr.read(path, MOST_SIDE)
    except MissingExtraError:
        raise
    except Exception as error:  # of any kind: OpenEXR raises others for each kind of damage
        allowed = f"a whole {suffix} picture with R, G and B ({error})"
        raise ArgumentError(argument, os.fspath(path), allowed) from None
