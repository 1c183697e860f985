#!/usr/bin/env bash
# A DistantLight of USD with an angle of 6 degrees and an intensity of 1, imported into Blender; and a
# sun of Blender, written and imported again. Needs Python 3.11.
# Guessed: a sun of 6 degrees, as UsdLux and Blender both call the diameter of the disc its angle, and
# of strength 1, whatever `normalize` says.
# Seen: a sun of 12 degrees and of strength 4, with `normalize` or without. Blender writes half of its
# angle and a quarter of its strength, so its own files come back as they were, and only other programs'
# lights differ.
# Versions: bpy==5.0.1.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.11 -m venv venv
venv/bin/python -m pip install -q bpy==5.0.1
venv/bin/python - <<'PYTHON' | tee seen.txt
import math
from pathlib import Path

import bpy


def imported(name):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=name)
    sun = next(each.data for each in bpy.data.objects if each.type == "LIGHT")
    return round(math.degrees(sun.angle), 2), round(sun.energy, 2)


def foreign(normalize):
    Path("foreign.usda").write_text(
        f"""#usda 1.0
def DistantLight "Sun"
{{
    float inputs:angle = 6
    float inputs:intensity = 1
    bool inputs:normalize = {normalize}
}}
"""
    )
    return imported("foreign.usda")


seen = [foreign(0), foreign(1)]

bpy.ops.wm.read_factory_settings(use_empty=True)
light = bpy.data.lights.new("sun", "SUN")
light.angle, light.energy = math.radians(6), 1
bpy.context.collection.objects.link(bpy.data.objects.new("sun", light))
bpy.ops.wm.usd_export(filepath="own.usda")
written = {
    line.split()[1]: float(line.split()[-1])
    for line in Path("own.usda").read_text().splitlines()
    if "inputs:angle" in line or "inputs:intensity" in line
}
own = imported("own.usda")
print("from another program:", seen, "written:", written, "its own again:", own)
assert seen == [(12.0, 4.0)] * 2
assert round(written["inputs:angle"], 3) == 3 and written["inputs:intensity"] == 0.25
assert own == (6.0, 1.0)
PYTHON
