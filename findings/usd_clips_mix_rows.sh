#!/usr/bin/env bash
# Particles in USD value clips, one clip per frame: frame 0 has the particles 0 and 1, frame 1 has 2
# and 3.
# Guessed: between the frames a reader sees one of the two, as it does when their numbers differ.
# Seen: with equal numbers USD interpolates row by row across the clips: at time 0.5 there are
# particles half way between 0 and 2 that never existed, with the ids of frame 0, since integers are
# held. A jump in `times`, (0, 0), (1, 0), (1, 1), holds each frame.
# Versions: usd-core==26.11.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/python -m pip install -q usd-core==26.11
venv/bin/python - <<'PYTHON'
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

for frame in range(2):
    stage = Usd.Stage.CreateNew(f"frame{frame}.usda")
    points = UsdGeom.Points.Define(stage, "/Drops")
    points.GetPointsAttr().Set(Vt.Vec3fArray([Gf.Vec3f(10 * frame + i, 0, 0) for i in range(2)]), frame)
    points.GetIdsAttr().Set(Vt.Int64Array([2 * frame, 2 * frame + 1]), frame)
    stage.GetRootLayer().Save()


def seen(name, times):
    stage = Usd.Stage.CreateNew(name)
    points = UsdGeom.Points.Define(stage, "/Drops")
    clips = Usd.ClipsAPI(points.GetPrim())
    clips.SetClipAssetPaths([Sdf.AssetPath(f"./frame{frame}.usda") for frame in range(2)])
    clips.SetClipPrimPath("/Drops")
    clips.SetClipActive([(0, 0), (1, 1)])
    clips.SetClipTimes(times)
    clips.SetClipManifestAssetPath("./frame0.usda")
    stage.GetRootLayer().Save()
    stage = Usd.Stage.Open(name)
    points = UsdGeom.Points(stage.GetPrimAtPath("/Drops"))
    return [point[0] for point in points.GetPointsAttr().Get(0.5)], list(points.GetIdsAttr().Get(0.5))


mixed, held = seen("mixed.usda", [(0, 0), (1, 1)]), seen("held.usda", [(0, 0), (1, 0), (1, 1)])
print(mixed, held)
assert mixed == ([5, 6], [0, 1]) and held == ([0, 1], [0, 1])
PYTHON
