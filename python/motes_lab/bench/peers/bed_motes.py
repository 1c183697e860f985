"""Grains at rest or on a chute in the engine, as a separate job: the command line is `FILE STEPS`."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import motes.expressions as ex
from motes import System, World
from motes.shapes import Plane


class Bed:
    """Grains in a box without a lid, or on fixed grains, in frames of `steps` sub-steps."""

    def __init__(self, bed: dict[str, Any], places: NDArray[np.float64], steps: int) -> None:
        """Make the world; `places` are positions and velocities, shape (2, grains, 3)."""
        self._bed = bed
        low, high = bed["low"], bed["high"]
        self._walls = [] if bed["fixed"] else [Plane((0, low[1], 0), (0, 1, 0))]
        periodic = {axis: (low["xyz".index(axis)], high["xyz".index(axis)]) for axis in bed["periodic"]}
        for axis in (0, 2):
            if "xyz"[axis] in periodic:
                continue
            for end, way in ((low, 1), (high, -1)):
                normal = tuple(way if c == axis else 0 for c in range(3))
                self._walls.append(Plane(tuple(end), normal))
        self.world = World(
            seed=1, dt=steps * bed["step"], substeps=steps, periodic=periodic, progress="off", threads=1
        )
        self.system: System = self.world.system("grains", attributes={"fixed": 1} if bed["fixed"] else {})
        self._moves: dict[str, Any] = {"where": ex.column("fixed") == 0} if bed["fixed"] else {}
        self._places = places

    def start(self) -> None:
        """Create the grains."""
        position, velocity = self._places
        self.system.emit(
            position=position,
            velocity=velocity,
            size=np.full((len(position), 3), self._bed["diameter"]),
            mass=np.full(len(position), self._bed["mass"]),
            **({"fixed": np.arange(len(position)) < self._bed["fixed"]} if self._moves else {}),
        )

    def frame(self) -> None:
        """Compute a frame."""
        bed = self._bed
        self.system.gravity(bed["gravity"], **self._moves)
        self.system.contact(
            bed["stiffness"],
            restitution=bed["restitution"],
            friction=bed["friction"],
            walls=self._walls,
            **self._moves,
        )
        self.system.move()
        self.world.step()


def main() -> None:
    """Simulate the bed in the file; the manager prints one JSON object."""
    with Path(sys.argv[1]).open("rb") as file:
        told = json.loads(file.readline())
        places = np.frombuffer(file.read()).reshape(2, -1, 3)
    steps = int(sys.argv[2])
    bed = Bed(told, places, steps)
    with bed.world:
        bed.start()
        bed.frame()  # not timed
        wall, used = time.perf_counter(), time.process_time()
        bed.frame()
        figures = {"wall_s": time.perf_counter() - wall, "process_s": time.process_time() - used}
        last = bed.system.gather()
        if last:
            figures["touching"] = float(np.mean(last.contacts))
            figures["height"] = float(np.mean(last.position[:, 1].astype(np.float64)))
            print(json.dumps(figures), flush=True)


if __name__ == "__main__":
    main()
