#!/usr/bin/env bash
# An .obj face that counts its corners from the end, as the format allows: f -3 -2 -1.
# Guessed: the three corners that stand above it.
# Seen: meshio returns the indices -4, -3, -2 without an error: in NumPy the first is out of range for
# three corners, and with more corners it names a wrong one. trimesh reads 0, 1, 2.
# Versions: meshio==5.3.5, trimesh==5.2.0, numpy==2.4.6.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/python -m pip install -q meshio==5.3.5 trimesh==5.2.0 numpy==2.4.6
venv/bin/python - <<'PYTHON'
import meshio
import trimesh

with open("three.obj", "w") as file:
    file.write("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n")
read = {
    "meshio": meshio.read("three.obj").cells_dict["triangle"].tolist(),
    "trimesh": trimesh.load("three.obj", process=False).faces.tolist(),
}
print(read)
assert read == {"meshio": [[-4, -3, -2]], "trimesh": [[0, 1, 2]]}
PYTHON
