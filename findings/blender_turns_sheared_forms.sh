#!/usr/bin/env bash
# A square of USD whose transform leans it into a parallelogram, imported into Blender. Needs Python 3.11.
# Guessed: the parallelogram, as USD's own bounds have it, or a message that such transforms are not read.
# Seen: without a word, another parallelogram: the matrix is taken apart into a turn and three scales, which
# cannot hold the lean, so corners move by half of the square's side.
# Versions: bpy==5.0.1, usd-core==26.11.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cat > leaning.usda << 'USD'
#usda 1.0
(
    defaultPrim = "Square"
    metersPerUnit = 1
    upAxis = "Z"
)
def Mesh "Square"
{
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    matrix4d xformOp:transform = ( (1, 0, 0, 0), (1, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1) )
    uniform token[] xformOpOrder = ["xformOp:transform"]
}
USD
python3.11 -m venv usd
usd/bin/python -m pip install -q usd-core==26.11
usd/bin/python - << 'PYTHON'
from pxr import Usd, UsdGeom

stage = Usd.Stage.Open("leaning.usda")
square = stage.GetPrimAtPath("/Square")
place = UsdGeom.Xformable(square).ComputeLocalToWorldTransform(0)
seen = [tuple(place.Transform(point)) for point in UsdGeom.Mesh(square).GetPointsAttr().Get()]
print("usd-core:", seen)
assert seen == [(0, 0, 0), (1, 0, 0), (2, 1, 0), (1, 1, 0)]
PYTHON
python3.11 -m venv blender
blender/bin/python -m pip install -q bpy==5.0.1
blender/bin/python - << 'PYTHON' 
import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
assert bpy.ops.wm.usd_import(filepath="leaning.usda") == {"FINISHED"}
square = next(each for each in bpy.data.objects if each.type == "MESH")
bpy.context.view_layer.update()
seen = [tuple(round(x, 3) for x in square.matrix_world @ vertex.co) for vertex in square.data.vertices]
print("bpy:", seen)
assert seen == [(0, 0, 0), (0.93, -0.368, 0), (1.45, 0.947, 0), (0.521, 1.315, 0)]
PYTHON
