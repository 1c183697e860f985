"""Compares `contact` with LAMMPS: grains at rest in a box, and on a chute, on one rank and on two.

Friction has a history. Both start from the same positions and velocities, computed by the engine, and must
end with the same mean height and number of contacts. LAMMPS is a separate job, perhaps of another Python: see
lammps_run.py.
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

__all__ = ["bed", "chute"]

DIAMETER, MASS, STEP = 0.01, 1e-3, 1e-4
STIFFNESS, RESTITUTION, FRICTION = 2000.0, 0.5, 0.5
SETTLE_S = 0.1
CHUTE_DEG, CHUTE_STIFFNESS, CHUTE_RESTITUTION, CHUTE_S = 26.0, 2e5, 0.88, 1.0
CHUTE_PART, CHUTE_SPEED = (51, 27, 27), 12.0
LEAVES_OUT = {
    "motes": "double-precision numbers",
    "lammps": "equal bits on any number of ranks, events, balancing, pictures",
}


def bed(*, grains: int, steps: int, rounds: int, python: str) -> dict[str, Any]:
    """Time steps of grains at rest in both, in turn, on one rank (processor time) and on two (wall time).

    `python` runs LAMMPS. Raises NotInstalled, and MotesError if the results differ.
    """
    return _in_turn(*_settled(grains), steps, rounds, python)


def chute(*, grains: int, steps: int, rounds: int, python: str) -> dict[str, Any]:
    """Time steps of grains on a chute of 26 degrees, periodic along and across it, like `bed`.

    The grains of the lowest layer are fixed. Lengths are in diameters; masses and gravity are 1.
    """
    return _in_turn(*_flowing(grains), steps, rounds, python)


def _in_turn(
    told: dict[str, Any], places: NDArray[np.float64], steps: int, rounds: int, python: str
) -> dict[str, Any]:
    """Time steps of both from the same start."""
    with tempfile.TemporaryDirectory(prefix="motes-bed-") as folder:
        file = Path(folder) / "bed"
        file.write_bytes(json.dumps(told).encode() + b"\n" + places.tobytes())
        updates = places.shape[1] * steps
        rows: list[dict[str, Any]] = []
        for ranks, clock in ((1, "process_s"), (2, "wall_s")):
            seconds: dict[str, list[float]] = {"motes": [], "lammps": []}
            for _ in range(rounds):
                peer = _lammps(python, ranks, file, steps)
                own = figures_of("motes_lab.bench.peers.bed_motes", ranks, [str(file), str(steps)])
                _compare(own, peer, told["diameter"])
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


def _law(stiffness: float, restitution: float, mass: float) -> dict[str, float]:
    """Return the law's parameters for both programs."""
    # Damping as in LAMMPS' law: in 1/s, per reduced mass.
    loss = math.log(restitution)
    zeta = -loss / math.sqrt(math.pi**2 + loss**2)
    damping = 2 * zeta * math.sqrt(stiffness / (mass / 2))
    return {
        "step": STEP,
        "stiffness": stiffness,
        "along": stiffness * 2 / 7,
        "damping": damping,
        "damping_along": damping / 2,
        "friction": FRICTION,
        "restitution": restitution,
    }


def _settled(grains: int) -> tuple[dict[str, Any], NDArray[np.float64]]:
    """Return the bed's parameters, and positions and velocities, shape (2, grains, 3)."""
    side = max(2, round(grains ** (1 / 3)))
    rng = np.random.default_rng(1)
    lattice = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), -1).reshape(-1, 3)
    width = side * 1.02 * DIAMETER
    position = (lattice * 1.02 + 0.6 + rng.uniform(-0.1, 0.1, lattice.shape)) * DIAMETER
    told: dict[str, Any] = {
        "low": [0.0, 0.0, 0.0],
        "high": [width + 0.2 * DIAMETER, 2 * width, width + 0.2 * DIAMETER],
        "diameter": DIAMETER,
        "mass": MASS,
        "density": MASS / (math.pi / 6 * DIAMETER**3),
        "gravity": [0.0, -9.81, 0.0],
        "periodic": "",
        "fixed": 0,
    } | _law(STIFFNESS, RESTITUTION, MASS)
    return told, _after(SETTLE_S, told, np.stack((position, np.zeros_like(position))))


def _flowing(grains: int) -> tuple[dict[str, Any], NDArray[np.float64]]:
    """Return the chute's parameters, and positions and velocities, shape (2, grains, 3)."""
    scale = (grains / math.prod(CHUTE_PART)) ** (1 / 3)
    long, high, wide = (max(4, round(n * scale)) for n in CHUTE_PART)
    rng = np.random.default_rng(1)
    y, x, z = np.meshgrid(*map(np.arange, (high, long, wide)), indexing="ij")
    lattice = np.stack((x, y, z), -1).reshape(-1, 3)
    layer, moves = lattice[:, 1], lattice[:, 1] > 0
    position = lattice * (1, 0.9, 1) + 0.5
    position[:, ::2] += 0.5 * (layer % 2)[:, None]
    position += rng.uniform(-0.05, 0.05, position.shape) * moves[:, None]
    position[~moves, 1] -= rng.uniform(0, 0.4, int((~moves).sum()))
    velocity = rng.normal(0, 0.5, position.shape) * moves[:, None]
    velocity[:, 0] += CHUTE_SPEED * (1 - (1 - layer / high) ** 1.5) * moves  # Bagnold's profile
    ends = np.array((long, 1, wide))
    position[:, ::2] %= ends[::2]
    slope = math.radians(CHUTE_DEG)
    told: dict[str, Any] = {
        "low": [0.0, -1.0, 0.0],
        "high": [float(long), 3.0 * high, float(wide)],
        "diameter": 1.0,
        "mass": 1.0,
        "density": 6 / math.pi,
        "gravity": [math.sin(slope), -math.cos(slope), 0.0],
        "periodic": "xz",
        "fixed": int((~moves).sum()),
    } | _law(CHUTE_STIFFNESS, CHUTE_RESTITUTION, 1.0)
    return told, _after(CHUTE_S, told, np.stack((position, velocity)))


def _after(seconds: float, told: dict[str, Any], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the positions and velocities after some time, in the order of births."""
    made = Bed(told, places, 50)
    with made.world:
        made.start()
        for _ in range(round(seconds / STEP / 50)):
            made.frame()
        last = made.system.gather()
    order = np.argsort(last.id)
    return np.stack((last.position[order], last.velocity[order])).astype(np.float64)


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


def _compare(own: dict[str, Any], peer: dict[str, Any], diameter: float) -> None:
    """Raise MotesError if results differ by more than chaos and the order of a step's actions explain."""
    high = abs(own["height"] - peer["height"]) > 0.2 * diameter
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
