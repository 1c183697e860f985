"""Mesh: a surface of triangles, made from arrays or read from a file."""

from __future__ import annotations

import math
import operator
import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._values import arguments
from .._values.materials import Material
from .._values.values import value
from ..errors import ArgumentError
from . import Shape

__all__ = ["Mesh"]

VERTICES = "finite numbers of shape (n, 3), metres, n >= 3"
PLACE = "3 finite numbers, or a matrix of shape (4, 4) that only rotates and translates"
MOST_FAR = 1e12  # m
RESOLUTION = 96
STILL = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0) * 2
TRIANGLES = "integers of shape (m, 3), m >= 1"


@value(init=False)
class Mesh(Shape):
    """A surface of triangles: a shape like the others, also drawn by `Solid`.

    `sample` draws points from its surface, uniformly or weighted by `density`, or with `solid` from its
    inside. It contains the points inside, particles bounce off it from both sides, and it can be part of a
    union. Everything except sampling the surface and `Solid` needs a closed surface: each edge belongs to two
    triangles of the same orientation, and no two parts overlap. In this check, vertices closer than a
    millionth of the mesh's size count as one, and triangles without area are ignored.

    Inside and outside are determined by a grid of signed distances, computed when first needed: about one
    second for 96 cells, and 4 bytes per node. Corners and edges are rounded, and features thinner than a cell
    may be missed.

    Two meshes are equal if their arrays, poses and options are equal.

    Attributes:
        vertices: positions in metres, float32 (n, 3), read-only.
        triangles: three vertex indices per triangle, uint32 (m, 3), read-only.
        solid: whether points are sampled from the inside instead of the surface.
        resolution: cells of the grid along the longest side of the mesh, 8 to 512.
        colors: linear RGB of the vertices, float32 (n, 3), read-only; None: no colours. `Solid` and `Sprite`
            show them, interpolated linearly between corners; particles born on the surface can take them with
            `motes.surface_color`.
        uv: texture coordinates of the vertices, float32 (n, 2), read-only, or None. `Solid(image=)` and
            `Sprite("mesh", image=)` show their picture there.
        normals: directions of the surface at the vertices, float32 (n, 3), read-only, or None. `Solid` and
            `Sprite` shade by them, interpolated linearly, so that the surface looks round. Where they are
            0, 0, 0 it is flat.
        smooth: whether the vertices' normals are means over their triangles.
        density: relative density of births on the surface at each vertex, float32 (n,), read-only; None:
            uniform.
        material: how the surface looks, from its file, or None: `Solid` and `Sprite` use it where the script
            says nothing else.
    """

    vertices: NDArray[np.float32]
    triangles: NDArray[np.uint32]
    solid: bool = False
    resolution: int = RESOLUTION
    colors: NDArray[np.float32] | None = None
    uv: NDArray[np.float32] | None = None
    density: NDArray[np.float32] | None = None
    normals: NDArray[np.float32] | None = None
    smooth: bool = False
    material: Material | None = None

    def __init__(
        self,
        vertices: ArrayLike,
        triangles: ArrayLike,
        *,
        solid: bool = False,
        resolution: int = RESOLUTION,
        colors: ArrayLike | str | os.PathLike[str] | None = None,
        uv: ArrayLike | None = None,
        density: ArrayLike | str | os.PathLike[str] | None = None,
        normals: ArrayLike | None = None,
        smooth: bool = False,
        material: Material | None = None,
    ) -> None:
        """Make a mesh from arrays, which are copied, and options.

        Args:
            vertices: positions in metres, (n, 3).
            triangles: three vertex indices per triangle, (m, 3).
            solid: whether points are sampled from the inside instead of the surface.
            resolution: cells of the distance grid along the mesh's longest side, 8 to 512.
            colors: colour of each vertex, linear RGB (n, 3) or n strings; one string for all vertices; or a
                picture, a path or uint8 (height, width, 3 or 4), from which each vertex takes the colour at
                its `uv`.
            uv: texture coordinates of each vertex, (n, 2): (0, 0) is the picture's lower left corner, (1, 1)
                its upper right corner; the picture repeats beyond.
            density: relative number of births per area at each vertex, 0 to 1e6, (n,), interpolated linearly;
                or a picture as for `colors`, where half the brightness gives half the density. Only sampling
                the surface uses it.
            normals: direction of the surface at each vertex, (n, 3), of any length, for shading.
            smooth: compute `normals` as the means, weighted by area, of the triangles at each position.
            material: how the surface looks, a `motes.shapes.Material`.

        Raises:
            ArgumentError: if an argument is not valid, such as a density that is 0 everywhere or given with
                `solid`, or normals with `smooth`.
        """
        points = _vertices(vertices)
        corners = _triangles(triangles, len(points))
        at, tints, births, directions = None, None, None, None
        if any(given is not None for given in (uv, colors, density, normals)):
            from ._surface_colors import densities, directions_of, of_vertices, places

            at = None if uv is None else places(uv, len(points))
            tints = None if colors is None else of_vertices(colors, at, len(points))
            births = None if density is None else densities(density, at, corners, len(points))
            directions = None if normals is None else directions_of(normals, len(points))
        options = _options(solid, resolution)
        if births is not None and options["solid"]:
            raise ArgumentError(
                "density", density, "left out with solid=True: only births on the surface use it"
            )
        if material is not None and not isinstance(material, Material):
            raise ArgumentError("material", material, "a motes.shapes.Material")
        if arguments.flag("smooth", smooth) and directions is not None:
            raise ArgumentError("normals", normals, "left out with smooth=True, which computes them")
        self.__dict__.update(
            vertices=points, triangles=corners, **options, colors=tints, uv=at, density=births
        )
        self.__dict__.update(normals=directions, smooth=smooth, material=material)
        shown = _smooth_normals(points, corners, _places(points)) if smooth else directions
        none = np.zeros(0)
        extras = (none if extra is None else extra for extra in (tints, births, at, shown))
        self.__dict__["_name"] = _core.keep_mesh(points, corners, *extras)
        self.__dict__["_made_from"] = self._content
        self._place(STILL)

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str],
        *,
        scale: float = 1,
        solid: bool = False,
        resolution: int = RESOLUTION,
        smooth: bool = False,
    ) -> Mesh:
        """Read a file: .obj, .ply, .stl or .glb.

        All parts of the file become one mesh, placed as in the file. Faces with more than three corners, even
        concave ones, are triangulated. Normals, texture coordinates and colours of vertices are kept, and the
        material of a .glb: base colour, roughness, metal, and their textures, as `material`. If a .glb has
        several, their base colours become colours of vertices, and roughness and metal are those of the
        material with most triangles. A vertex of an .obj is repeated where its corners have several normals
        or texture coordinates. A .glb with Draco compression needs the extra [mesh], with textures [image].

        Args:
            path: path of the file.
            scale: metres per unit of the file.
            solid: as in the constructor.
            resolution: as in the constructor.
            smooth: as in the constructor; the file's normals are ignored.

        Returns:
            The mesh.

        Raises:
            ArgumentError: if the file cannot be read completely; names the file and the reason.
        """
        file = arguments.file_path("path", path)
        from .. import _meshes

        if file.suffix.lower() not in _meshes.SUFFIXES:
            raise ArgumentError("path", os.fspath(path), f"a name ending in {', '.join(_meshes.SUFFIXES)}")
        scale = arguments.number("scale", scale, low=0)
        options = _options(solid, resolution)
        smooth = arguments.flag("smooth", smooth)
        arguments.existing_file("path", path)
        try:
            found = _meshes.read(file)
            looks = {name: getattr(found, name) for name in ("normals", "uv", "colors", "material")}
            if smooth:
                looks["normals"] = None
            return cls(found.vertices * scale, found.triangles, **options, **looks, smooth=smooth)
        except (_meshes.Unreadable, OSError, ArgumentError) as error:
            raise ArgumentError("path", os.fspath(path), f"a mesh that can be read ({error})") from None

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the mesh at its place to a file: .obj, .glb or .usd.

        Colours, texture coordinates and normals are written where the format has them: .obj has no colours.
        The file appears only when it is complete. On several ranks, let one of them write.

        Args:
            path: path of the file.

        Raises:
            ArgumentError: if the suffix is another one.
            OSError: if the file cannot be written.
        """
        from .._meshes import writing

        file = arguments.file_path("path", path)
        if file.suffix.lower() not in writing.SUFFIXES:
            raise ArgumentError("path", os.fspath(path), f"a name ending in {', '.join(writing.SUFFIXES)}")
        arrays = (self.vertices, self.triangles, shown_normals(self), self.uv, self.colors)
        writing.write(file, writing.placed(pose_of(self), *arrays))

    def at(
        self,
        place: ArrayLike = (0, 0, 0),
        *,
        axis: ArrayLike = (0, 1, 0),
        angle_deg: float = 0,
        moving_from: Mesh | None = None,
        vertices: ArrayLike | None = None,
    ) -> Mesh:
        """Return this mesh at another place, optionally deformed.

        Args:
            place: where to move the mesh's origin, m; or a rigid transform as a matrix of shape (4, 4),
                without scaling or mirroring.
            axis: axis of the rotation, which is applied before the move.
            angle_deg: angle of the rotation, degrees.
            moving_from: where the mesh was one frame ago, if it moves: the same mesh at another place, also
                with other vertices. During the frame it moves at constant velocity from there to here:
                `bounce`, which lets no particle through, and `contact`, with the mesh as a wall, give
                particles the velocity of its surface. Everything else uses its place at the end of the frame.
            vertices: deformed vertices, (n, 3), m; a deforming mesh passes new ones in each frame. `bounce`
                and `contact` move it from its last vertices to these: without `moving_from`, from those that
                the same call had in the last frame. Normals are computed anew: vertices at one position share
                one, except where given `normals` differ, as at sharp edges. Each deformed mesh is kept until
                the program ends, and as a wall it computes a new distance grid.

        Returns:
            The mesh at its new place. Without `vertices` it shares the arrays and the grid, so moving a mesh
            in each frame costs nothing.
        """
        if vertices is not None:
            deformed = self._formed(vertices)
            return deformed.at(place, axis=axis, angle_deg=angle_deg, moving_from=moving_from)
        here = _pose(place, axis, angle_deg)
        before: tuple[float, ...] = here
        start: NDArray[np.float32] | None = None
        if moving_from is not None:
            if not isinstance(moving_from, Mesh) or moving_from._origin != self._origin:
                raise ArgumentError("moving_from", moving_from, "this mesh at another place")
            before = moving_from._numbers[:7]
            start = None if moving_from._content == self._content else moving_from.vertices
            if sum(map(operator.mul, here[3:], before[3:])) < 0:  # interpolate the shorter way
                here = (*here[:3], *(-number for number in here[3:]))
        mesh = object.__new__(Mesh)
        mesh.__dict__.update(self.__dict__)
        mesh._place((*here, *before), start)
        return mesh

    def _formed(self, vertices: ArrayLike) -> Mesh:
        """Return a mesh with other vertices and the same triangles."""
        points = _vertices(vertices)
        if len(points) != len(self.vertices):
            allowed = f"finite numbers of shape ({len(self.vertices)}, 3), one row per vertex, metres"
            raise ArgumentError("vertices", f"{points.dtype} {points.shape}", allowed)
        mesh = Mesh(points, self.triangles, **(self._options | {"normals": self._normals_at(points)}))
        mesh.__dict__["_made_from"] = self._origin
        mesh._place(STILL)
        return mesh

    def _with_colors(self, colors: NDArray[np.float32]) -> Mesh:
        return Mesh(self.vertices, self.triangles, **(self._options | {"colors": colors}))

    def _normals_at(self, points: NDArray[np.float32]) -> NDArray[np.float32] | None:
        """Return the normals after a deformation, if the mesh has given ones."""
        if self.normals is None:
            return None
        flat = ~self.normals.any(axis=1)
        lengths = np.where(flat, 1, np.sqrt(np.square(self.normals, dtype=np.float64).sum(axis=1)))
        unit = np.rint(self.normals / lengths[:, None] * 1e4)  # so that rounding separates none
        normals = _smooth_normals(
            points, self.triangles, np.concatenate([_places(self.vertices), unit + 0.0], axis=1)
        )
        normals[flat] = 0
        return normals

    @property
    def _options(self) -> dict[str, Any]:
        names = ("solid", "resolution", "colors", "uv", "density", "normals", "smooth", "material")
        return {name: getattr(self, name) for name in names}

    @property
    def _content(self) -> int:
        """The engine's key for the mesh, a hash of its content; internal to the package."""
        name: int = self.__dict__["_name"]
        return name

    @property
    def _origin(self) -> int:
        """The content of the mesh from which this one was deformed, or its own."""
        origin: int = self.__dict__["_made_from"]
        return origin

    @property
    def _start(self) -> NDArray[np.float32] | None:
        """The vertices at the start of the frame, if the mesh deforms."""
        start: NDArray[np.float32] | None = self.__dict__["_began"]
        return start

    @property
    def _numbers(self) -> tuple[float, ...]:
        numbers: tuple[float, ...] = self.__dict__["_placed"]
        return numbers

    def _place(self, numbers: tuple[float, ...], start: NDArray[np.float32] | None = None) -> None:
        """Store the poses at the frame's end and start, and build the engine's shape.

        Args:
            numbers: position and rotation at the end, and at the start.
            start: the vertices at the start of the frame, (n, 3), m; None: the same.
        """
        self.__dict__.update(_placed=numbers, _began=start)
        before = 0 if start is None else Mesh(start, self.triangles, **self._options)._content
        numbers = (*numbers, self.solid, self.resolution)
        self.__dict__["_native"] = _core.Shape.mesh(self._content, numbers, self._origin, before)

    def _key(self) -> tuple[Any, ...]:
        places = None if self.uv is None else self.uv.tobytes()
        start = None if self._start is None else self._start.tobytes()
        look = (places, self.material)
        return (self._content, self.solid, self.resolution, self._numbers, start, *look)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by arrays, options and poses."""
        placed = (self._numbers, self._start, self._origin)
        return _again, (self.vertices, self.triangles, self._options, *placed)

    def __repr__(self) -> str:
        """Show the numbers of vertices and triangles."""
        solid = ", solid" if self.solid else ""
        return f"<Mesh of {len(self.vertices)} vertices, {len(self.triangles)} triangles{solid}>"


def _again(
    vertices: NDArray[np.float32],
    triangles: NDArray[np.uint32],
    options: dict[str, Any],
    numbers: tuple[float, ...],
    start: NDArray[np.float32] | None,
    origin: int,
) -> Mesh:
    mesh = Mesh(vertices, triangles, **options)
    mesh.__dict__["_made_from"] = origin
    mesh._place(numbers, start)
    return mesh


def _smooth_normals(
    points: NDArray[np.float32], corners: NDArray[np.uint32], groups: NDArray[Any]
) -> NDArray[np.float32]:
    """Return the mean normal at each vertex; vertices with equal rows of `groups` share it."""
    _, at = np.unique(groups, axis=0, return_inverse=True)
    first, second, third = (points[corners[:, k]].astype(np.float64) for k in range(3))
    twice_areas = np.cross(second - first, third - first)
    sums = np.zeros((at.max() + 1, 3))
    for k in range(3):
        np.add.at(sums, at.reshape(-1)[corners[:, k]], twice_areas)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.asarray(sums / np.where(lengths > 0, lengths, 1), np.float32)[at.reshape(-1)]


def _places(points: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return positions in cells of 1e-5 of the size: formulas and files repeat those of seams and poles."""
    cell = max(float(np.abs(points).max()), 1e-30) * 1e-5
    places: NDArray[np.float64] = np.rint(points / np.float64(cell)) + 0.0  # no -0
    return places


def _pose(place: Any, axis: Any, angle_deg: Any) -> tuple[float, ...]:
    """Return the position and the rotation as a quaternion (w, x, y, z)."""
    try:
        shape = np.shape(place)
    except ValueError:  # rows of different lengths
        raise ArgumentError("place", place, PLACE) from None
    if shape == (4, 4):
        matrix = arguments.floats("place", place, np.float64, PLACE)
        turned = matrix[:3, :3]
        rigid = (
            np.isfinite(matrix).all()
            and np.allclose(turned @ turned.T, np.eye(3), atol=1e-5)
            and np.linalg.det(turned) > 0
            and np.allclose(matrix[3], (0, 0, 0, 1), atol=1e-9)
        )
        if not rigid:
            raise ArgumentError("place", matrix.tolist(), PLACE)
        return (*_position(matrix[:3, 3]), *_quaternion(turned))
    position = _position(place)
    around = np.array(arguments.triple("axis", axis))
    longest = np.abs(around).max()
    if not longest > 0:
        raise ArgumentError("axis", axis, "a vector that is not zero")
    around /= longest  # its square could overflow or vanish
    half = math.radians(arguments.number("angle_deg", angle_deg)) / 2
    return (*position, math.cos(half), *(math.sin(half) / math.sqrt(around @ around) * around).tolist())


def _position(place: Any) -> tuple[float, float, float]:
    position = arguments.triple("place", place)
    if max(map(abs, position)) > MOST_FAR:
        raise ArgumentError("place", place, f"within {MOST_FAR:g} m of the origin")
    return position


def _quaternion(turned: NDArray[np.float64]) -> tuple[float, ...]:
    """Return the rotation matrix as a quaternion, computed from its largest component."""
    xx, yy, zz = turned.diagonal().tolist()
    (_, xy, xz), (yx, _, yz), (zx, zy, _) = turned.tolist()
    squares = (1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz)
    rows = (
        (squares[0], zy - yz, xz - zx, yx - xy),
        (zy - yz, squares[1], yx + xy, xz + zx),
        (xz - zx, yx + xy, squares[2], zy + yz),
        (yx - xy, xz + zx, zy + yz, squares[3]),
    )
    row = rows[squares.index(max(squares))]
    length = math.sqrt(sum(number * number for number in row))
    return tuple(number / length for number in row)


def _options(solid: Any, resolution: Any) -> dict[str, Any]:
    return {
        "solid": arguments.flag("solid", solid),
        "resolution": arguments.integer("resolution", resolution, low=8, high=512),
    }


def _vertices(given: Any) -> NDArray[np.float32]:
    array = arguments.floats("vertices", given, np.float32, VERTICES)
    if array.ndim != 2 or array.shape[1] != 3 or len(array) < 3:
        raise ArgumentError("vertices", f"{array.dtype} {array.shape}", VERTICES)
    wrong = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if len(wrong):
        raise ArgumentError(f"vertices[{wrong[0]}]", array[wrong[0]].tolist(), VERTICES)
    return _kept(array)


def _triangles(given: Any, vertices: int) -> NDArray[np.uint32]:
    try:
        array: NDArray[Any] = np.asarray(given)
    except Exception:  # any exception: this runs methods of users' classes
        raise ArgumentError("triangles", given, TRIANGLES) from None
    if array.dtype.kind not in "iu" or array.ndim != 2 or array.shape[1] != 3 or len(array) < 1:
        raise ArgumentError("triangles", f"{array.dtype} {array.shape}", TRIANGLES)
    wrong = np.flatnonzero(((array < 0) | (array >= vertices)).any(axis=1))
    if len(wrong):
        allowed = f"indices of the {vertices} vertices, 0..{vertices - 1}"
        raise ArgumentError(f"triangles[{wrong[0]}]", array[wrong[0]].tolist(), allowed)
    return _kept(array.astype(np.uint32))


def _kept(array: NDArray[Any]) -> NDArray[Any]:
    copy = np.array(array, order="C")
    copy.flags.writeable = False
    return copy


def with_colors(mesh: Mesh, colors: NDArray[np.float32]) -> Mesh:
    """Return a mesh with other colours, for the rest of the package."""
    return mesh._with_colors(colors)


def content_of(mesh: Mesh) -> int:
    """Return the engine's key for a mesh's vertices, triangles, colours and density."""
    return mesh._content


def origin_of(mesh: Mesh) -> int:
    """Return the engine's key for the mesh from which this one was deformed, or its own."""
    return mesh._origin


def pose_of(mesh: Mesh) -> tuple[float, ...]:
    """Return where a mesh is: position, m, and rotation as a quaternion (w, x, y, z)."""
    return mesh._numbers[:7]


def shown_normals(mesh: Mesh) -> NDArray[np.float32] | None:
    """Return the directions by which the vertices of a mesh are shaded, in its own axes; None: it is flat."""
    if not mesh.smooth:
        return mesh.normals
    return _smooth_normals(mesh.vertices, mesh.triangles, _places(mesh.vertices))
