"""Runs recorded scenes on a virtual cluster: SimGrid's SMPI executes each rank and simulates time."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from motes import Run, open_run
from motes.errors import MotesError

from .._engine import arguments
from .build import find_replay, find_smpirun
from .machines import Cluster, Network
from .platform import hosts, platform

if TYPE_CHECKING:
    from motes.balance import Balancer

__all__ = ["MEASURED_COSTS", "costs_of", "migrant_s", "record", "simulate"]

FLAGS = {
    "smpi/simulate-computation": "no",  # work takes the time given by its costs
    "smpi/test": "0",  # MPI_Test takes no time
    "smpi/lat-factor": "0:1",  # use the cluster's networks without SMPI's calibration factors
    "smpi/bw-factor": "0:1",
    "smpi/privatization": "no",  # the engine has no global state
    "network/crosstraffic": "0",
    "smpi/cpu-threshold": "-1",
    "smpi/send-is-detached-thresh": "65536",  # sends of longer messages wait for their receiver
}
ALONE = {
    "smpi/send-is-detached-thresh": "0",  # the simulator searches a list of all unreceived messages
}
"""Flags for networks whose messages do not share links."""
MEASURED_COSTS = Path(__file__).with_name("measured.costs")


def record(scene: Path, script: Path, arguments: Sequence[object] = ()) -> None:
    """Record a script's scene in another process. Raises MotesError with the script's errors."""
    argv = [sys.executable, "-m", "motes", "record", "-o", scene, script, *arguments]
    made = subprocess.run([str(part) for part in argv], capture_output=True, text=True, check=False)
    if made.returncode != 0:
        raise MotesError(f"recording {script} failed:\n{made.stderr[-3000:]}".rstrip())


def simulate(
    scene: str | os.PathLike[str],
    cluster: Cluster,
    *,
    log: str | os.PathLike[str],
    costs: str | os.PathLike[str] | None = None,
    scale: float = 1.0,
    balancer: Balancer | None = None,
    options: Sequence[str] = (),
) -> Run:
    """Replay a recorded scene on a virtual cluster.

    Args:
        scene: a file that `python -m motes record` wrote.
        cluster: the machines and networks.
        log: the directory for the run's log.
        costs: a file of the costs of work, lines `name = nanoseconds` on a machine of speed 1; None:
            `measured.costs` of this package, for one core of a Xeon with AVX-512.
        scale: how many particles each particle of the scene stands for: work on particles, and messages with
            particles, cost that many times more.
        balancer: may be your own class; it runs in this process and takes no simulated time. None: the
            scene's balancer, or that of the options.
        options: of `motes_replay`.

    Returns:
        The run's log, in simulated seconds.

    Raises:
        MotesError: if the run fails, with its errors.
    """
    scale = arguments.number("scale", scale, low=1e-9)
    smpirun, replay = find_smpirun(), find_replay()
    with tempfile.TemporaryDirectory(prefix="motes-cluster-") as text:
        folder = Path(text)  # the working directory, so that the log depends on no path
        (folder / "platform.xml").write_text(platform(cluster))
        (folder / "hosts").write_text(hosts(cluster))
        (folder / "costs").write_text(_costs(costs, cluster.networks[0]))
        (folder / "scene.motes").symlink_to(Path(scene).absolute())
        argv = [*_launcher(smpirun, cluster), str(replay), *_replay_options(scale, options)]
        if balancer is None:
            _run(argv, folder)
        else:
            _run_under(balancer, argv, folder)
        shutil.copytree(folder / "log", log, dirs_exist_ok=True)
    return open_run(log)


def _run_under(balancer: Balancer, argv: Sequence[str], folder: Path) -> None:
    from motes.balance import is_native  # needs the compiled core, unlike the rest of this module

    from .deciding import deciding

    if is_native(balancer):
        _run([*argv, "--balancer", "".join(repr(balancer).split())], folder)
        return
    with deciding(balancer, folder / "balancer"):
        _run([*argv, "--ask", "balancer"], folder)


def _run(argv: Sequence[str], folder: Path) -> None:
    made = subprocess.run(argv, cwd=folder, capture_output=True, text=True, check=False)
    if made.returncode != 0:
        said = [line for line in made.stderr.splitlines() if line.startswith("motes_replay:")]
        raise MotesError("the simulated run failed: " + ("\n".join(said) or made.stderr[-3000:]).rstrip())


def _launcher(smpirun: str, cluster: Cluster) -> list[str]:
    """Return smpirun's own part of the command line."""
    flags = FLAGS | ({} if cluster.networks[0].shared else ALONE)
    return [
        smpirun,
        *("-np", str(cluster.ranks)),
        *("-hostfile", "hosts"),
        *("-platform", "platform.xml"),
        *(f"--cfg={name}:{value}" for name, value in flags.items()),
        "--log=root.thresh:error",
    ]


def _replay_options(scale: float, options: Sequence[str]) -> list[str]:
    """Return the arguments of motes_replay, without blanks, at which smpirun would split them."""
    own = ["scene.motes", "--log", "log", "--scale", repr(scale), "--costs", "costs"]
    return own + ["".join(option.split()) for option in options]


def _costs(path: str | os.PathLike[str] | None, network: Network) -> str:
    """Return the costs of work, of each message, and of its bytes for the processors at both ends."""
    text = Path(MEASURED_COSTS if path is None else path).read_text()
    byte_s = 0.0 if network.shared else 1 / network.bandwidth
    return f"{text}\nmessage = {1e9 * network.overhead_s!r}\nbyte = {1e9 * byte_s!r}\n"


def costs_of(text: str) -> dict[str, float]:
    """Parse costs of work, lines `name = nanoseconds`; return seconds by name."""
    lines = (line.partition("#")[0].partition("=") for line in text.splitlines())
    return {name.strip().strip('"'): 1e-9 * float(value) for name, equals, value in lines if equals}


def migrant_s(
    cluster: Cluster, costs: str | os.PathLike[str] | None = None, *, scale: float = 1.0, size: float = 36.0
) -> float:
    """Return the cost of a migrating particle for each of the two calculators, for `Run.replay(migrant_s=)`.

    It cannot be derived from a log in which few particles, or equally many in each frame, were exchanged.

    Args:
        cluster: the machines, averaged over ranks, and the networks, of which the first counts.
        costs: as in `simulate`.
        scale: as in `simulate`.
        size: bytes of a particle in a message; 36 for one with position, velocity, age and id.

    Returns:
        Seconds for packing or unpacking the particle, and for its bytes on the link.
    """
    found = costs_of(Path(MEASURED_COSTS if costs is None else costs).read_text())
    slowness = [node.started / node.rank_speed for node in cluster.nodes for _ in range(node.count)]
    each = (found.get("leave", 0.0) + found.get("arrive", 0.0)) / 2 * sum(slowness) / cluster.ranks
    return scale * (each + size / cluster.networks[0].bandwidth)
