"""Reads all points of a USD stage with usd-core, as programs do that are built on it."""

from __future__ import annotations

from typing import Any

import numpy as np

NAMES = {"points": "position", "velocities": "velocity", "ids": "id", "widths": "widths", "extent": "extent"}


def read(path: str, times: list[float]) -> dict[str, Any]:
    """Return each attribute of each prim at each time as `system|prim|time|attribute`."""
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(path)
    found = {}
    for prim in stage.Traverse():
        points = UsdGeom.Points(prim)
        if not points:
            continue
        for time in times:
            key = f"{prim.GetParent().GetName()}|{prim.GetName()}|{time}|"
            for name, ours in NAMES.items():
                values = prim.GetAttribute(name).Get(time) if prim.HasAttribute(name) else None
                if values is not None:
                    found[key + ours] = np.array(values)
            moved = points.ComputePointsAtTime(time, int(time))
            found[key + "moved"] = np.array(moved).reshape(-1, 3)
            for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvars():
                values = primvar.ComputeFlattened(time)
                if values is not None and primvar.GetInterpolation() == "vertex":
                    name = str(primvar.GetPrimvarName())
                    found[key + {"id": "id32"}.get(name, name)] = np.array(values)
    return found
