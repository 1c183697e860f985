"""Spheres in LAMMPS (`pair_style gran/hooke`), in a separate process: another Python may run this file.

LAMMPS' package brings its own MPI, and two MPIs fit neither into one process nor into one environment. So
this file imports nothing of motes. The command line is `positions velocities diameter`: two files of float64,
x y z per sphere, and metres. The program prints `ready VERSION CONTACTS`. Then it reads lines `each STEPS` or
`kept STEPS`, takes that many steps, and prints their processor time in seconds.
"""

from __future__ import annotations

import math
import sys
import time
from array import array
from collections.abc import Callable
from typing import Any

LISTS = {"each": "every 1 delay 0 check no", "kept": "every 1000000 delay 1000000 check no"}
"""When neighbour lists are built: in each step, or once."""
SKIN = {"each": 0.0, "kept": 0.05}
"""Skin of the neighbour lists in metres; a list that is built in each step needs none."""


def before_atoms(positions: list[float]) -> list[str]:
    """Return the commands that make a box around the positions; spheres that left it would be lost."""
    low, high = math.floor(min(positions)) - 1, math.ceil(max(positions)) + 1
    return [
        "units si",
        "atom_style sphere",
        "boundary f f f",
        "newton off",
        "comm_modify vel yes",
        f"region box block {low} {high} {low} {high} {low} {high}",
        "create_box 1 box",
    ]


def after_atoms(diameter: float, lists: str) -> list[str]:
    """Return the commands that set the contact law of spheres of a diameter (m) and evaluate the forces.

    Springs and dampers along and across the contact, friction 0.5. Steps take 10 us, so spheres hardly move
    during a measurement. Contacts are counted once; afterwards only the step's number is output.
    """
    return [
        f"set group all diameter {diameter!r} density 1",
        f"neighbor {SKIN[lists]} bin",
        f"neigh_modify {LISTS[lists]}",
        "pair_style gran/hooke 10000 2857 50 25 0.5 1",
        "pair_coeff * *",
        "timestep 1e-5",
        "fix move all nve/sphere",
        "compute contacts all contact/atom",
        "compute mean all reduce ave c_contacts",
        "thermo_style custom step c_mean",
        "thermo 0",
        "run 0 post no",
    ]


class Run:
    """Spheres that LAMMPS moves. `lammps` is the class of LAMMPS' Python module."""

    def __init__(
        self,
        lammps: Callable[..., Any],
        positions: list[float],
        velocities: list[float],
        diameter: float,
        lists: str,
    ) -> None:
        """Create the spheres from positions (m) and velocities (m/s), x y z per sphere."""
        self._lammps = lammps(cmdargs=["-log", "none", "-screen", "none"])
        count = len(positions) // 3
        for command in before_atoms(positions):
            self._lammps.command(command)
        made = self._lammps.create_atoms(count, None, [1] * count, positions, velocities)
        if made != count:
            raise RuntimeError(f"LAMMPS made {made} of {count} spheres")
        for command in after_atoms(diameter, lists):
            self._lammps.command(command)
        self.contacts = float(self._lammps.extract_compute("mean", 0, 0))
        """The mean number of contacts per sphere."""
        self._lammps.command("thermo_style custom step")
        self._lammps.command("uncompute mean")
        self._lammps.command("uncompute contacts")
        self._lammps.command("run 0 post no")

    def seconds(self, steps: int) -> float:
        """Continue for some steps; return their processor time in seconds."""
        start = time.process_time()
        self._lammps.command(f"run {steps} pre no post no")
        return time.process_time() - start


def _numbers(path: str) -> list[float]:
    values = array("d")
    with open(path, "rb") as file:
        values.frombytes(file.read())
    return values.tolist()


def main() -> None:
    """Take the steps that each line of the input requests."""
    from lammps import __version__, lammps

    positions, velocities = _numbers(sys.argv[1]), _numbers(sys.argv[2])
    runs = {name: Run(lammps, positions, velocities, float(sys.argv[3]), name) for name in LISTS}
    print("ready", __version__, runs["each"].contacts, flush=True)
    for line in sys.stdin:
        name, steps = line.split()
        print(runs[name].seconds(int(steps)), flush=True)


if __name__ == "__main__":
    main()
