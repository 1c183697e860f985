"""Material: how the surface of a mesh looks, as its file says."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..errors import ArgumentError
from . import arguments
from .arguments import Triple
from .images import MOST_SIDE, linear_light
from .values import Value, value

__all__ = ["Material"]

PICTURE = f"uint8 sRGB or linear floats, (height, width, 3), up to {MOST_SIDE} pixels each way"


@value(init=False)
class Material(Value):
    """How the surface of a mesh looks: `Mesh.load` keeps what a .glb says as `mesh.material`.

    `Solid` and `Sprite` use it where the script gives nothing of its own.
    """

    color: Triple = (1, 1, 1)
    """Reflectance, linear RGB."""
    roughness: float = 1
    """As for `Solid`, 0..1."""
    metal: float = 0
    """As for `Solid`, 0..1."""
    image: NDArray[np.float32] | None = None
    """A picture at the mesh's `uv` that multiplies the colour: linear RGB, float32 (height, width, 3)."""
    finish_image: NDArray[np.float32] | None = None
    """A picture at the mesh's `uv` whose green multiplies the roughness and whose blue multiplies the metal:
    float32 (height, width, 3) of numbers in 0..1."""

    def __init__(
        self,
        color: Any = (1, 1, 1),
        roughness: float = 1,
        metal: float = 0,
        image: Any = None,
        finish_image: Any = None,
    ) -> None:
        """Check the fields."""
        self.__dict__.update(
            color=arguments.color("color", color, low=0, high=arguments.FARTHEST),
            roughness=arguments.number("roughness", roughness, low=0, high=1),
            metal=arguments.number("metal", metal, low=0, high=1),
            image=None if image is None else linear_light("image", image, PICTURE),
            finish_image=None if finish_image is None else _parts_of("finish_image", finish_image),
        )
        for name in ("image", "finish_image"):
            picture = self.__dict__[name]
            self.__dict__[f"_{name}"] = 0 if picture is None else _core.keep_light(picture)

    def _key(self) -> tuple[Any, ...]:
        """Compare pictures by their contents' hashes."""
        keys = {name: self.__dict__[f"_{name}"] for name in ("image", "finish_image")}
        return tuple((self._items() | keys).values())


def _parts_of(name: str, given: Any) -> NDArray[np.float32]:
    given = np.asarray(given)
    if given.dtype == np.uint8:  # numbers, not colours
        given = given.astype(np.float32) / 255
    parts = linear_light(name, given, PICTURE)
    if not (parts <= 1).all():
        raise ArgumentError(name, f"{given.dtype} {given.shape}", "numbers in 0..1, (height, width, 3)")
    return parts
