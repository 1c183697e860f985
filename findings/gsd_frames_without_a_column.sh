#!/usr/bin/env bash
# A GSD file whose frames 0 and 1 give diameters, and whose frame 2 does not.
# Guessed: frame 2 has those of frame 1, the last that were given.
# Seen: frame 2 has those of frame 0, in gsd and in OVITO alike (half of them, as radii); where frame
# 0 gives none, it is the schema's default of 1. So what is left out because it did not change must be
# what frame 0 has.
# Versions: gsd==5.0.1, ovito==3.17.2, numpy==2.4.6.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/python -m pip install -q gsd==5.0.1 ovito==3.17.2 numpy==2.4.6
venv/bin/python - <<'PYTHON'
import gsd.hoomd
import numpy as np
from ovito.io import import_file

given = [(2, 3), (7, 8), None]
with gsd.hoomd.open("grains.gsd", "w") as file:
    for step, diameter in enumerate(given):
        frame = gsd.hoomd.Frame()
        frame.configuration.step = step
        frame.particles.N = 2
        frame.particles.position = np.full((2, 3), step, np.float32)
        frame.particles.diameter = diameter and np.array(diameter, np.float32)
        file.append(frame)
with gsd.hoomd.open("grains.gsd", "r") as file:
    read = [file[step].particles.diameter.tolist() for step in range(3)]
pipeline = import_file("grains.gsd")
radii = [pipeline.compute(step).particles["Radius"][...].tolist() for step in range(3)]
print(read, radii)
assert read == [[2, 3], [7, 8], [2, 3]] and radii == [[1, 1.5], [3.5, 4], [1, 1.5]]
PYTHON
