#!/usr/bin/env bash
# Two pictures of different sizes written by OpenEXR with one dict as their header.
# Guessed: the dict says how to write; the second picture is written like the first.
# Seen: OpenEXR.File adds the first picture's data window to the caller's dict, and the second call
# fails: the window does not match the pixels.
# Versions: OpenEXR==3.5.3, numpy==2.4.6.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/python -m pip install -q OpenEXR==3.5.3 numpy==2.4.6
venv/bin/python - <<'PYTHON'
import numpy as np
import OpenEXR

header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
with OpenEXR.File(header, {"RGB": np.ones((4, 4, 3), np.float32)}) as file:
    file.write("large.exr")
print(sorted(header))
assert "dataWindow" in header
try:
    with OpenEXR.File(header, {"RGB": np.ones((2, 2, 3), np.float32)}) as file:
        file.write("small.exr")
except ValueError as error:
    print(error)
else:
    raise AssertionError("the second picture has a header of its own")
PYTHON
