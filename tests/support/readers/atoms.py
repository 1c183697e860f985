"""Reads files with OVITO, each with its frames. Arguments: the .npz to write, then the files."""

import sys
from pathlib import Path

import numpy as np
from ovito.io import import_file

found = {}
for file in sys.argv[2:]:
    pipeline = import_file(file)
    for frame in range(pipeline.source.num_frames):
        particles = pipeline.compute(frame).particles
        for name, values in particles.items():
            found[f"{Path(file).name}|{frame}|{name}"] = np.array(values)
np.savez(sys.argv[1], **found)
