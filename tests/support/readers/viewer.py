"""Reads the blocks of a .pvd with PyVista. Arguments: the .pvd, the .npz to write."""

import sys
from pathlib import Path

import numpy as np
import pyvista

found = {}
reader = pyvista.get_reader(sys.argv[1])
for number, time in enumerate(reader.time_values):
    reader.set_active_time_value(time)
    for block, dataset in zip(reader.read(), reader.active_datasets, strict=True):
        system = Path(dataset.path).name.split(".")[0]
        key = f"{system}|{dataset.part}|{number}|"
        found[key + "time"] = np.array([time, block.field_data["TimeValue"][0]])
        found[key + "position"] = np.array(block.points).reshape(-1, 3)
        found[key + "cells"] = np.array([block.n_verts])
        for name in block.point_data:
            found[key + name] = np.array(block.point_data[name])
np.savez(sys.argv[2], **found)
