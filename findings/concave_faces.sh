#!/usr/bin/env bash
# A face with four corners, one of which points inwards, in an .obj file.
# Guessed: readers that make triangles of it cover the face: 1.5 square metres.
# Seen: trimesh cuts a fan from the first corner, which covers 2.5 and overlaps itself; VTK (through
# pyvista) covers 1.5.
# Versions: trimesh==5.2.0, pyvista==0.49.1, numpy==2.4.6.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/python -m pip install -q trimesh==5.2.0 pyvista==0.49.1 numpy==2.4.6
venv/bin/python - <<'PYTHON'
import pyvista
import trimesh

with open("dart.obj", "w") as file:
    file.write("v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 0\nf 1 2 3 4\n")
area = {"trimesh": trimesh.load("dart.obj").area, "vtk": pyvista.read("dart.obj").triangulate().area}
print({name: round(float(one), 6) for name, one in area.items()})
assert abs(area["trimesh"] - 2.5) < 1e-6 and abs(area["vtk"] - 1.5) < 1e-6
PYTHON
