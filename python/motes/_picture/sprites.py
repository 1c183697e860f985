"""Sprite: how the particles of a system are drawn."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._values import arguments
from .._values.values import Value, shown, value
from ..errors import ArgumentError
from ..shapes._mesh import Mesh, content_of, with_colors
from . import sheets
from .skies import light_key, light_of

if TYPE_CHECKING:
    from ..expressions import Expression
    from ..expressions._conditions import Columns

__all__ = ["Sprite", "check_change", "native_of", "tinted"]

KINDS = ("point", "disc", "sphere", "image", "mesh", "ribbon", "surface")
FACINGS = ("camera", "velocity", "orientation")
MOST_TRIANGLES = 10_000
BLENDS = ("add", "alpha", "opaque")
DEFAULT_PIXELS = 5
DEFAULT_GLASS = 1.33
MOST_PIXELS = 512


@value(init=False)
class Sprite(Value):
    """How the particles of a system are drawn.

    Systems with different blends are combined in one picture with correct depth.
    """

    kind: Literal["point", "disc", "sphere", "image", "mesh", "ribbon", "surface"] = "disc"
    """"point": as small as a pixel; "disc": soft at its edge; "sphere": lit by the sun, with the depth of a
    sphere; "image": a picture; "mesh": an instance of a mesh, scaled by `size[0]`, lit by the sun and the
    sky, in the particle's colour times the mesh's own `colors`, clipped at white; "ribbon": a smooth band
    along the particle's last positions, which fades and tapers towards its end; "surface": all particles of
    the system together, as the smooth skin of a liquid."""
    pixels: int | None = 5
    """The diameter, 1..512; None: the particle's `size[0]` in metres, up to 8192 pixels. Ignored for points
    and with `height`."""
    blend: Literal["add", "alpha", "opaque"] = "add"
    """"add": light adds up; "alpha": each particle covers what is behind it; "opaque": the nearest particle
    hides the others."""
    softness: float = 0
    """The distance over which a particle fades where it touches a solid or an opaque particle, m."""
    image: NDArray[Any] | None = None
    """For the kind "mesh": a picture at the mesh's `uv` that multiplies the colour, given as for
    `Solid(image=)` and stored as linear light, float32 (height, width, 3). For the kind "image": a path
    (PNG, JPEG, WebP, TIFF, BMP, GIF, TGA, PPM; read by Pillow, the extra `[image]`), or an array, uint8
    (height, width, 4): sRGB and straight alpha; three channels are opaque. A particle's colour multiplies
    it. Files are rotated as their EXIF data says; a single channel of 16 bits is scaled from 0..65535,
    one of floats from 0..1. A list of pictures of the same size: `pick` selects one for each particle;
    stored as an array (number, height, width, 4)."""
    lit: bool = False
    """Whether the sun, lights and the sky light the particles, shaded as small spheres with their colour as
    reflectance. Cards are shaded by the side that they show. Spheres and meshes are always lit by the sun and
    the sky; `lit` adds lights and shadows."""
    shadow: float = 0
    """The fraction of the sun's and lights' light that one particle blocks, 0..1, times its `alpha`. Its
    shadow falls on solids and on lit particles, including those of its own system. With "opaque" and 1 it has
    edges; other shadows have the resolution of a grid of 64 cells per height of the picture."""
    height: float | None = None
    """The diameter as a fraction of the picture's height, above 0 and up to 1, in place of `pixels`: it looks
    the same at any resolution. With `height`, leave `pixels` out (its default 5 counts as left out; any other
    value, including None, is an error)."""
    facing: Literal["camera", "velocity", "orientation"] = "camera"
    """What an image faces. "camera": it faces the camera and is rotated by the particle's `up`. Otherwise it
    is a card in space, seen from both sides, whose longer side is `size[0]` metres if `pixels` is left out.
    "velocity": its front faces along the velocity, and its top towards `up`. "orientation": it is rotated by
    the particle's `orientation`; unrotated, its front faces along z and its top along y. Meshes are oriented
    in the same way; for them "camera" means "orientation"."""
    mesh: Mesh | None = None
    """For the kind "mesh": up to 10,000 triangles, positioned by `Mesh.at`. Of a closed surface only the
    outside is seen; if blended, only triangles that face the camera are drawn."""
    tiles: tuple[int, int] | None = None
    """Columns and rows, 1..256 each, into which the image, or each image of a list, is cut. Pictures are
    numbered from 0, row by row from the top. Mipmaps are made per tile, so tiles do not bleed into each
    other."""
    pick: Literal["random", "age"] | Expression | None = None
    """Which of several pictures a particle shows. "random", or None: chosen by its id for its whole life;
    "age": from the first to the last over its lifetime; or the picture's number, as an expression or a
    constant. Fractions blend two neighbouring pictures; numbers beyond the last wrap around to the first."""

    width: float | None = None
    """For the kind "ribbon": its width at the particle, m, above 0. Its flat side faces the camera."""
    length: float | None = None
    """For the kind "ribbon": how far it reaches back in time, s, above 0; a younger particle's ribbon begins
    where it was born. The band passes through up to 16 earlier positions, which are stored per particle; the
    length of a system's ribbons cannot change."""
    roughness: float = 1
    """How even the surface scatters light, 0..1, as for `Solid`: 1 like paper, 0.3 like wet stone, 0 like a
    mirror. For spheres, meshes, and images with `lit` that do not face the camera."""
    metal: float = 0
    """How much of a metal the surface is, 0..1, as for `Solid`: it reflects the sun, lights and the sky in
    its colour. For the same kinds as `roughness`. Left out, both are those of the mesh's `material`, if it
    has one, whose colour and picture then also apply."""
    radius: float | None = None
    """For the kind "surface": of a particle, m, above 0: half the distance between neighbours, or somewhat
    more. The liquid mirrors the sky, the sun and lights, bends and tints the picture behind it by the
    particles' `color`, and shows that colour itself the deeper it is, by `alpha`: about 12 radii at 1."""
    foam: float = 0
    """For the kind "surface": the speed at which the liquid is white, m/s; 0: never."""
    glass: float = 1.33
    """For the kind "surface": the index of refraction, 1 to 4; 1.33 is water."""

    def __init__(
        self,
        kind: Literal["point", "disc", "sphere", "image", "mesh", "ribbon", "surface"] = "disc",
        pixels: int | None = 5,
        blend: Literal["add", "alpha", "opaque"] = "add",
        softness: float = 0,
        image: str
        | os.PathLike[str]
        | ArrayLike
        | Sequence[str | os.PathLike[str] | ArrayLike]
        | None = None,
        *,
        height: float | None = None,
        lit: bool = False,
        shadow: float = 0,
        facing: Literal["camera", "velocity", "orientation"] = "camera",
        mesh: Mesh | None = None,
        tiles: tuple[int, int] | None = None,
        pick: Literal["random", "age"] | Expression | float | None = None,
        width: float | None = None,
        length: float | None = None,
        roughness: float | None = None,
        metal: float | None = None,
        radius: float | None = None,
        foam: float = 0,
        glass: float = DEFAULT_GLASS,
    ) -> None:
        """Check the fields."""
        state = self.__dict__
        state["kind"] = arguments.choice("kind", kind, KINDS)
        state["pixels"] = _pixels(pixels, height)
        state["blend"] = arguments.choice("blend", blend, BLENDS)
        state["softness"] = arguments.number("softness", softness, low=0, high=1e6)
        state["image"] = _picture_on_mesh(mesh, image) if kind == "mesh" else sheets.pictures_of(kind, image)
        state["height"] = None if height is None else _height(height)
        state["lit"] = arguments.flag("lit", lit)
        state["shadow"] = arguments.number("shadow", shadow, low=0, high=1)
        state["facing"] = _facing(kind, facing)
        state["mesh"] = _mesh(self, mesh)
        state["width"] = _of_ribbon(self, "width", width)
        state["length"] = _of_ribbon(self, "length", length)
        _check_ribbon(self)
        _set_liquid(self, radius, foam, glass)
        cut = None if self.kind == "mesh" else self.image
        state["tiles"] = sheets.tiles_of(cut, tiles)
        state["pick"] = sheets.pick_of(cut, tiles, pick)
        look = None if self.mesh is None else self.mesh.material
        state["roughness"] = _finish(
            self, "roughness", roughness, plain=1.0 if look is None else look.roughness
        )
        state["metal"] = _finish(self, "metal", metal, plain=0.0 if look is None else look.metal)
        posed = self.kind in ("mesh", "ribbon", "surface") or self.facing != "camera"
        sheet = None if cut is None else sheets.sheet_of(cut, self.tiles)
        state["_tiles"] = (1, 1, 1) if sheet is None else sheet[1:]
        state["_picture"] = 0 if sheet is None else _core.keep_picture(sheet.pixels)
        if self.kind == "mesh" and self.image is not None:
            own = None if self.mesh is None else self.mesh.material
            kept = image is None and own is not None
            state["_picture"] = own.__dict__["_image"] if kept else light_key(self.image)
        state["_core"] = _core.Sprite(
            kind="card" if posed and self.kind == "image" else self.kind,
            pixels=0 if posed and self.pixels == DEFAULT_PIXELS else self.pixels or 0,
            blend="opaque" if self.kind == "surface" else self.blend,
            of_height=self.height or 0,
            softness=self.softness,
            lit=self.lit,
            shadow=self.shadow,
            roughness=self.roughness,
            metal=self.metal,
            **_of_kind(self),
        )

    def _key(self) -> tuple[Any, ...]:
        """Compare an image by its content's hash."""
        return tuple((self._items() | {"image": self.__dict__["_picture"]}).values())

    def __repr__(self) -> str:
        """Return a call that creates an equal sprite, except for an image's content."""
        shown_by_name = {name: shown(one) for name, one in self._items().items()}
        if self.image is not None:
            shown_by_name["image"] = sheets.text_of_pictures(self.image)
        defaults = {"kind": "'disc'", "pixels": "5", "blend": "'add'", "softness": "0.0"}
        defaults |= {"lit": "False", "shadow": "0.0", "roughness": "1.0", "metal": "0.0"}
        defaults |= {"foam": "0.0", "glass": repr(DEFAULT_GLASS)}
        defaults["facing"] = "'camera'"
        given = [f"{n}={one}" for n, one in shown_by_name.items() if one != defaults.get(n, "None")]
        return f"Sprite({', '.join(given)})"


def _of_kind(sprite: Sprite) -> dict[str, Any]:
    """Return the members that only sprites of this kind have, as in cpp/image/sprites."""
    content = sprite.__dict__["_picture"]
    facing = {"facing": "velocity" if sprite.facing == "velocity" else "orientation"}
    if sprite.kind == "image":
        shown = {"picture": content, "tiles": sprite.__dict__["_tiles"]}
        return shown if sprite.facing == "camera" else shown | facing
    if sprite.kind == "mesh":
        assert sprite.mesh is not None
        return {"mesh": content_of(tinted(sprite.mesh)), "picture": content, **facing}
    if sprite.kind == "surface":
        return {"radius": sprite.radius, "foam": sprite.foam, "glass": sprite.glass}
    return {"width": sprite.width, "length": sprite.length} if sprite.kind == "ribbon" else {}


def tinted(mesh: Mesh) -> Mesh:
    """Return a mesh whose colours include that of its material, which a particle's colour multiplies."""
    if mesh.material is None or mesh.material.color == (1, 1, 1):
        return mesh
    own = np.ones_like(mesh.vertices) if mesh.colors is None else mesh.colors
    return with_colors(mesh, own * np.array(mesh.material.color, np.float32))


def native_of(sprite: Sprite, columns: Columns) -> _core.Sprite:
    """Return the engine's sprite for particles with the given columns.

    Raises ArgumentError if the sprite's `pick` uses other columns.
    """
    native: _core.Sprite = sprite.__dict__["_core"]
    pick, count = sprite.pick, sprite.__dict__["_tiles"][2]
    if pick is None or (isinstance(pick, str) and pick == "random"):
        return native
    program, shapes = sheets.program_of_pick(pick, count, columns)
    return native if count == 1 else native.picked(program, shapes)


def check_change(before: Sprite, after: Any) -> None:
    """Raise ArgumentError if a system's sprite cannot change from `before` to `after`."""
    if not isinstance(after, Sprite):
        raise ArgumentError("sprite", after, "a motes.Sprite")
    if after.length != before.length:
        kept = "not a ribbon" if before.length is None else f"a ribbon of {before.length} s"
        raise ArgumentError(
            "sprite", after, f"{kept}, as when the system was created: it stores positions for that"
        )


def _pixels(pixels: Any, height: Any) -> int | None:
    if pixels is None:
        if height is not None:
            raise ArgumentError("height", height, "given without `pixels`: both set the size")
        return None
    if isinstance(pixels, (str, os.PathLike)):  # by position, as in Sprite("image", "flake.png")
        allowed = f"an integer in 1..{MOST_PIXELS}; pictures and meshes are given by name: image=, mesh="
        raise ArgumentError("pixels", pixels, allowed)
    checked = arguments.integer("pixels", pixels, low=1, high=MOST_PIXELS)
    if height is not None and checked != DEFAULT_PIXELS:
        raise ArgumentError("height", height, "given without `pixels`: both set the size")
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
    _check_left_out(sprite, "a mesh: `size` scales it", pixels=DEFAULT_PIXELS, height=None)
    return mesh


def _picture_on_mesh(mesh: Any, image: Any) -> NDArray[np.float32] | None:
    if image is None:
        look = getattr(mesh, "material", None)
        return None if look is None else look.image
    if getattr(mesh, "uv", None) is None:
        raise ArgumentError("image", image, "given with a mesh that has `uv`, where it is shown")
    return light_of("image", image)


_PLAIN = {"roughness": 1, "metal": 0}


def _finish(sprite: Sprite, name: str, value: Any, *, plain: float) -> float:
    if value is None:
        return plain
    number = arguments.number(name, value, low=0, high=1)
    card = sprite.kind == "image" and sprite.facing != "camera" and sprite.lit
    if number != _PLAIN[name] and sprite.kind not in ("sphere", "mesh") and not card:
        allowed = "left out for all but spheres, meshes, and images with lit=True and facing='orientation' or"
        raise ArgumentError(name, value, f"{allowed} 'velocity'")
    return number


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
    _check_left_out(sprite, "a ribbon: `width` is its size", pixels=DEFAULT_PIXELS, height=None)
    if sprite.shadow > 0:
        raise ArgumentError("shadow", sprite.shadow, "0 for a ribbon: it casts no shadow")


def _set_liquid(sprite: Sprite, radius: Any, foam: Any, glass: Any) -> None:
    state = sprite.__dict__
    if (sprite.kind == "surface") != (radius is not None):
        raise ArgumentError("radius", radius, "given for kind='surface', and for no other kind")
    state["radius"] = None if radius is None else arguments.number("radius", radius, low=1e-9, high=1e6)
    state["foam"] = arguments.number("foam", foam, low=0, high=1e9)
    state["glass"] = arguments.number("glass", glass, low=1, high=4)
    if sprite.kind != "surface":
        return _check_left_out(sprite, "all kinds but 'surface'", foam=0, glass=DEFAULT_GLASS)
    described = "a surface, which `radius`, `foam` and `glass` describe"
    size = {"pixels": DEFAULT_PIXELS, "height": None}
    _check_left_out(sprite, described, **size, blend="add", softness=0, lit=False)


def _check_left_out(sprite: Sprite, what: str, **plain: Any) -> None:
    """Refuse what the script has given although `what` has no use for it; `plain`: the defaults by name."""
    for name, default in plain.items():
        given = sprite.__dict__[name]
        if given is not None and given != default:
            raise ArgumentError(name, given, f"left out for {what}")


def _height(height: Any) -> float:
    number = arguments.number("height", height, low=0, high=1)
    if number < 1e-9:  # far below a pixel, and refused by the core
        raise ArgumentError("height", height, "a fraction of the picture's height, 1e-9 or more")
    return number
