"""One action on given particles, case by case; the tests compare the results with reference numbers.

Arguments: the JSON file of cases; the output file, a pickle: one dict per case with `columns` (those of
the survivors, by id) or `error`.
"""

from __future__ import annotations

import json
import pickle
import sys
from pathlib import Path
from typing import Any

import numpy as np

import motes
from motes import shapes

COLUMNS = [
    *("position", "velocity", "up", "rotational_velocity", "position_b", "velocity_b", "up_b"),
    *("size", "color", "alpha", "mass", "age", "lifetime"),
]


def value_of(value: Any) -> Any:
    """Turn {"type": "sphere", ...} into the shape."""
    if not isinstance(value, dict):
        return value
    given = {name: part for name, part in value.items() if name != "type"}
    if value["type"] == "union":
        return shapes.Union(*(value_of(shape) for shape in given["shapes"]))
    return getattr(shapes, value["type"].capitalize())(**given)


def run(case: dict[str, Any]) -> dict[str, Any]:
    """Apply the case's action to its particles; return them as they are afterwards."""
    given = {name: value_of(value) for name, value in case["params"].items()}
    if case["action"] == "bounce":
        given["exact_hit"] = False
    if case["action"] == "sink" and case["params"]["shape"]["type"] == "plane":
        given["inside"] = not given["inside"]  # reference planes hold the half-space above, ours below
    world = motes.World(seed=1, dt=case["dt"], progress="off")
    system = world.system("all")
    before = {name: np.array(column, np.float32) for name, column in case["before"].items()}
    for name in COLUMNS:
        width = 1 if name in ("alpha", "mass", "age", "lifetime") else 2
        before.setdefault(name, np.full((len(before["position"]), 3)[:width], 0.75, np.float32))
    with world:
        system.emit(**before)
        system.apply(getattr(motes.actions, "".join(w.title() for w in case["action"].split("_")))(**given))
        world.step()
        after = system.gather()
        return {"id": np.array(after.id), **{name: np.array(getattr(after, name)) for name in COLUMNS}}


results = []
for case in json.loads(Path(sys.argv[1]).read_text())["cases"]:
    try:
        results.append({"columns": run(case)})
    except (AttributeError, TypeError, ValueError) as error:
        results.append({"error": f"{type(error).__name__}: {error}"})
Path(sys.argv[2]).write_bytes(pickle.dumps(results))
