"""Reads a shot with usd-core and projects it as a program does that draws from its camera."""

from __future__ import annotations

from typing import Any

import numpy as np


class Shot:
    """A stage at a time code."""

    def __init__(self, path: Any, frame: float) -> None:
        from pxr import Usd, UsdGeom

        self.stage, self.frame = Usd.Stage.Open(str(path)), frame
        self.places = UsdGeom.XformCache(frame)
        self.cameras = [prim for prim in self.stage.Traverse() if prim.IsA(UsdGeom.Camera)]
        self.resolution = tuple(self.stage.GetPrimAtPath("/Render/Settings").GetAttribute("resolution").Get())

    def pixels(self, points: Any) -> Any:
        """Return where points in the world, (n, 3), are in the picture, px from the top left."""
        from pxr import Gf, UsdGeom

        (prim,) = self.cameras
        camera = UsdGeom.Camera(prim).GetCamera(self.frame)
        matrix = np.array(camera.frustum.ComputeViewMatrix() * camera.frustum.ComputeProjectionMatrix())
        assert isinstance(camera, Gf.Camera)
        at = np.column_stack([points, np.ones(len(points))]) @ matrix
        at = at[:, :2] / at[:, 3:]
        width, height = self.resolution
        return np.column_stack([(at[:, 0] + 1) / 2 * width, (1 - at[:, 1]) / 2 * height])

    def get(self, prim: Any, name: str) -> Any:
        return np.array(prim.GetAttribute(name).Get(self.frame))

    def placed(self, prim: Any, points: Any) -> Any:
        """Return points of a prim in the world."""
        place = np.array(self.places.GetLocalToWorldTransform(prim))
        return points @ place[:3, :3] + place[3, :3]

    def solids(self) -> dict[str, tuple[Any, Any]]:
        """Return the visible solids by name: points in the world, and triangles."""
        from pxr import UsdGeom

        found = {}
        for prim in self.stage.GetPrimAtPath("/World/_scene/Solids").GetChildren():
            if UsdGeom.Imageable(prim).ComputeVisibility(self.frame) == "invisible":
                continue
            counts = self.get(prim, "faceVertexCounts")
            assert (counts == 3).all()
            corners = self.get(prim, "faceVertexIndices").reshape(-1, 3)
            assert len(corners) == len(counts)
            found[prim.GetName()] = self.placed(prim, self.get(prim, "points")), corners
        return found

    def parts(self, system: str, kind: str) -> list[Any]:
        """Return the prims of a system's particles."""
        children = self.stage.GetPrimAtPath(f"/World/{system}").GetChildren()
        assert {prim.GetTypeName() for prim in children} == {kind}
        return children

    def instances(self, system: str) -> dict[int, Any]:
        """Return the corners of each instance in the world, by id, as USD itself places them."""
        from pxr import Usd, UsdGeom

        found = {}
        for prim in self.parts(system, "PointInstancer"):
            instancer = UsdGeom.PointInstancer(prim)
            time = Usd.TimeCode(self.frame)
            places = instancer.ComputeInstanceTransformsAtTime(time, time)
            meshes = [self.stage.GetPrimAtPath(path) for path in instancer.GetPrototypesRel().GetTargets()]
            rows = zip(self.get(prim, "ids"), self.get(prim, "protoIndices"), places, strict=True)
            for number, shown, place in rows:
                matrix = np.array(place)
                points = self.get(meshes[shown], "points")
                found[int(number)] = points @ matrix[:3, :3] + matrix[3, :3]
        return found
