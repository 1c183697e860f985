#!/usr/bin/env bash
# A closed mesh with one triangle that faces the other way, through Draco and back.
# Guessed: the same four corners and four triangles, in another order at most.
# Seen: seven corners: Draco copies those of edges at which neighbours do not agree on a side, so the
# mesh comes back with open edges. With all triangles facing outwards the four corners stay four.
# Versions: DracoPy==2.2.0, numpy==2.4.6.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/python -m pip install -q DracoPy==2.2.0 numpy==2.4.6
venv/bin/python - <<'PYTHON'
import DracoPy
import numpy as np

corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], np.float32)
outwards = np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], np.uint32)
turned = outwards.copy()
turned[3] = turned[3][::-1]
count = {}
for name, triangles in (("outwards", outwards), ("one turned", turned)):
    back = DracoPy.decode(DracoPy.encode(corners, triangles, quantization_bits=14))
    count[name] = len(back.points), len(back.faces)
print(count)
assert count == {"outwards": (4, 4), "one turned": (7, 4)}
PYTHON
