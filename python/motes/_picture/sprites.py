"""How the particles of a system are drawn: Sprite."""

from __future__ import annotations

import os
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._values import arguments
from .._values.values import Value, shown, value
from ..errors import ArgumentError
from ..shapes._mesh import Mesh

__all__ = ["Sprite", "check_change", "native_of"]

KINDS = ("point", "disc", "sphere", "image", "mesh", "ribbon")
FACINGS = ("camera", "velocity", "orientation")
MOST_TRIANGLES = 10_000
BLENDS = ("add", "alpha", "opaque")
DEFAULT_PIXELS = 5
MOST_PIXELS = 512
MOST_IMAGE_PIXELS = 8192
"""The longest side of an image."""
SIDES = f"1..{MOST_IMAGE_PIXELS} pixels each way"
IMAGE = f"a path, or uint8 or floats 0..1 (height, width, 4) or (height, width, 3), {SIDES}"


@value(init=False)
class Sprite(Value):
    """How the particles of a system are drawn.

    All blends of all systems are in one picture, in the right depth.
    """

    kind: Literal["point", "disc", "sphere", "image", "mesh", "ribbon"] = "disc"
    """"point", as small as a pixel; "disc", soft at its edge; "sphere", lit by the sun and round in depth;
    "image", a picture; "mesh", an instance of a mesh, scaled by `size[0]`, lit by the sun and the sky;
    "ribbon", a smooth band along the particle's last positions, which fades and tapers towards its end."""
    pixels: int | None = 5
    """The diameter, 1..512; None: as wide as the particle's `size[0]` in metres, up to 512 pixels. Points
    have none. With `height` it says nothing."""
    blend: Literal["add", "alpha", "opaque"] = "add"
    """"add", light adds up; "alpha", each particle covers what is behind it, from far to near; "opaque", the
    nearest wins."""
    softness: float = 0
    """Metres over which a particle fades where it touches a solid or an opaque particle."""
    image: NDArray[np.uint8] | None = None
    """For the kind "image": a path (PNG, JPEG, WebP, TIFF, BMP, GIF, TGA, PPM; read by Pillow, the extra
    `[image]`), or an array, uint8 (height, width, 4): sRGB and straight alpha; without the fourth it is
    opaque. A particle's colour multiplies it. Files are turned upright as their EXIF says; one channel of 16
    bits is scaled by its range, one of floats from 0..1."""
    lit: bool = False
    """Whether the sun, lights and the sky light its particles, as small spheres: their colour is the part of
    the light that they reflect. Spheres, which the sun lights anyway, get lights and shadows."""
    shadow: float = 0
    """The part of the light of the sun and of lights that one particle keeps from what lies behind it, times
    its `alpha`, 0..1: on solids, and on lit particles, of its own system too. Shadows are as sharp as a grid
    of 80 cells across all particles that throw them."""
    height: float | None = None
    """The diameter as a part of the picture's height, above 0 and up to 1, in place of `pixels`: it looks the
    same at any resolution. Only one of the two gives the size: with `height`, leave `pixels` out (its default
    5 counts as left out; any other value, and None, is an error)."""
    facing: Literal["camera", "velocity", "orientation"] = "camera"
    """What an image faces. "camera": it is turned by the particle's `up`. Otherwise it is a card in space,
    seen from both sides, whose longer side is `size[0]` metres if `pixels` is left out: "velocity", its front
    looks along the velocity and its top towards `up`; "orientation", the particle's `orientation` turns it,
    which without a turn has its front along z and its top along y. Meshes are turned in the same way;
    "camera" says for them what "orientation" does."""
    mesh: Mesh | None = None
    """For the kind "mesh": up to 10,000 triangles, wherever `Mesh.at` has put it. With a closed surface only
    its outside is seen; blended ones show the triangles that face the camera."""

    width: float | None = None
    """For the kind "ribbon": metres across at the particle, above 0. Its flat side faces the camera."""
    length: float | None = None
    """For the kind "ribbon": the seconds that it reaches back, above 0; a younger particle's ribbon begins
    where it was born. The band passes through up to 16 earlier positions, which each particle keeps; a system
    made with a ribbon keeps to ribbons of this length."""

    def __init__(
        self,
        kind: Literal["point", "disc", "sphere", "image", "mesh", "ribbon"] = "disc",
        pixels: int | None = 5,
        blend: Literal["add", "alpha", "opaque"] = "add",
        softness: float = 0,
        image: str | os.PathLike[str] | ArrayLike | None = None,
        *,
        height: float | None = None,
        lit: bool = False,
        shadow: float = 0,
        facing: Literal["camera", "velocity", "orientation"] = "camera",
        mesh: Mesh | None = None,
        width: float | None = None,
        length: float | None = None,
    ) -> None:
        """Take the attributes."""
        state = self.__dict__
        state["kind"] = arguments.choice("kind", kind, KINDS)
        state["pixels"] = _pixels(pixels, height)
        state["blend"] = arguments.choice("blend", blend, BLENDS)
        state["softness"] = arguments.number("softness", softness, low=0, high=1e6)
        state["image"] = _image(kind, image)
        state["height"] = None if height is None else _height(height)
        state["lit"] = arguments.flag("lit", lit)
        state["shadow"] = arguments.number("shadow", shadow, low=0, high=1)
        state["facing"] = _facing(kind, facing)
        state["mesh"] = _mesh(self, mesh)
        state["width"] = _of_ribbon(self, "width", width)
        state["length"] = _of_ribbon(self, "length", length)
        _check_ribbon(self)
        posed = self.kind in ("mesh", "ribbon") or self.facing != "camera"
        state["_picture"] = 0 if self.image is None else _core.keep_picture(self.image)
        if self.mesh is not None:
            state["_picture"] = _core.keep_mesh(self.mesh.vertices, self.mesh.triangles, np.zeros((0, 3)))
        state["_core"] = _core.Sprite(
            kind="card" if posed and self.kind == "image" else self.kind,
            pixels=0 if posed and self.pixels == DEFAULT_PIXELS else self.pixels or 0,
            blend=self.blend,
            of_height=self.height or 0,
            softness=self.softness,
            picture=state["_picture"],
            lit=self.lit,
            shadow=self.shadow,
            facing="velocity" if self.facing == "velocity" else "orientation",
            width=self.width or 0,
            length=self.length or 0,
        )

    @property
    def _native(self) -> _core.Sprite:
        """The engine's value; for the package itself."""
        made: _core.Sprite = self.__dict__["_core"]
        return made

    def _key(self) -> tuple[Any, ...]:
        """Compare an image by the fingerprint of its content."""
        return tuple((self._items() | {"image": self.__dict__["_picture"]}).values())

    def __repr__(self) -> str:
        """Show the call that makes an equal sprite, but for the content of an image."""
        shown_by_name = {name: shown(one) for name, one in self._items().items()}
        if self.image is not None:
            height, width, _ = self.image.shape
            shown_by_name["image"] = f"<{width}x{height} pixels>"
        defaults = {"kind": "'disc'", "pixels": "5", "blend": "'add'", "softness": "0.0"}
        defaults |= {"lit": "False", "shadow": "0.0"}
        defaults["facing"] = "'camera'"
        given = [f"{n}={one}" for n, one in shown_by_name.items() if one != defaults.get(n, "None")]
        return f"Sprite({', '.join(given)})"


def native_of(sprite: Sprite) -> _core.Sprite:
    """Return what the engine takes for a sprite, for the rest of the package."""
    return sprite._native


def check_change(before: Sprite, after: Any) -> None:
    """Raise ArgumentError where a system's particles cannot be drawn like `after` from now on."""
    if not isinstance(after, Sprite):
        raise ArgumentError("sprite", after, "a motes.Sprite")
    if after.length != before.length:
        kept = "no ribbon" if before.length is None else f"a ribbon of {before.length} s"
        raise ArgumentError(
            "sprite", after, f"{kept}, as where the system was made: it keeps positions for that"
        )


def _pixels(pixels: Any, height: Any) -> int | None:
    if pixels is None:
        if height is not None:
            raise ArgumentError("height", height, "given with `pixels` left out: it says the same")
        return None
    checked = arguments.integer("pixels", pixels, low=1, high=MOST_PIXELS)
    if height is not None and checked != DEFAULT_PIXELS:
        raise ArgumentError("height", height, "given with `pixels` left out: it says the same")
    return checked


def _facing(kind: str, facing: Any) -> str:
    checked: str = arguments.choice("facing", facing, FACINGS)
    if checked != "camera" and kind not in ("image", "mesh"):
        raise ArgumentError("facing", facing, "'camera' for all kinds but image and mesh")
    return checked


def _mesh(sprite: Sprite, mesh: Any) -> Mesh | None:
    if (sprite.kind == "mesh") != (mesh is not None):
        raise ArgumentError("mesh", mesh, "given for kind='mesh', and for no other kind")
    if mesh is None:
        return None
    if not isinstance(mesh, Mesh):
        raise ArgumentError("mesh", mesh, "a motes.shapes.Mesh")
    if len(mesh.triangles) > MOST_TRIANGLES:
        raise ArgumentError(
            "mesh", f"{len(mesh.triangles)} triangles", f"of at most {MOST_TRIANGLES} triangles"
        )
    if sprite.pixels not in (None, DEFAULT_PIXELS):
        raise ArgumentError("pixels", sprite.pixels, "left out for a mesh: `size` scales it")
    if sprite.height is not None:
        raise ArgumentError("height", sprite.height, "left out for a mesh: `size` scales it")
    return mesh


def _of_ribbon(sprite: Sprite, name: str, value: Any) -> float | None:
    if (sprite.kind == "ribbon") != (value is not None):
        raise ArgumentError(name, value, "given for kind='ribbon', and for no other kind")
    if value is None:
        return None
    number = arguments.number(name, value, low=0, high=1e6)
    if number < 1e-9:
        raise ArgumentError(name, value, "above 0, 1e-9 or more")
    return number


def _check_ribbon(sprite: Sprite) -> None:
    if sprite.kind != "ribbon":
        return
    if sprite.pixels not in (None, DEFAULT_PIXELS):
        raise ArgumentError("pixels", sprite.pixels, "left out for a ribbon: `width` is its size")
    if sprite.height is not None:
        raise ArgumentError("height", sprite.height, "left out for a ribbon: `width` is its size")
    if sprite.shadow > 0:
        raise ArgumentError("shadow", sprite.shadow, "0 for a ribbon: it throws no shadow")


def _height(height: Any) -> float:
    number = arguments.number("height", height, low=0, high=1)
    if number < 1e-9:  # far below any pixel, and no number of the core's
        raise ArgumentError("height", height, "a part of the picture's height, 1e-9 or more")
    return number


def _image(kind: str, given: Any) -> NDArray[np.uint8] | None:
    if (kind == "image") != (given is not None):
        raise ArgumentError("image", given, "given for kind='image', and for no other kind")
    if given is None:
        return None
    if isinstance(given, (str, os.PathLike)):
        from .._values.images import read_picture

        given = read_picture("image", given, most=MOST_IMAGE_PIXELS)
    try:
        array: NDArray[Any] = np.asarray(given)
    except Exception:  # any: this runs methods of users' classes
        raise ArgumentError("image", given, IMAGE) from None
    if array.dtype.kind == "f" and array.size and (array >= 0).all() and (array <= 1).all():
        array = np.rint(array * 255).astype(np.uint8)
    if array.dtype != np.uint8 or array.ndim != 3 or array.shape[2] not in (3, 4):
        raise ArgumentError("image", f"{array.dtype} {array.shape}", IMAGE)
    if not 0 < min(array.shape) <= max(array.shape) <= MOST_IMAGE_PIXELS:
        raise ArgumentError("image", f"{array.dtype} {array.shape}", IMAGE)
    whole = np.full((*array.shape[:2], 4), 255, np.uint8)
    whole[:, :, : array.shape[2]] = array
    whole.flags.writeable = False
    return whole
