"""Runs of recorded scenes on a virtual cluster: SimGrid's SMPI executes each rank and keeps the time."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from .. import arguments
from ..analysis.run import Run, open_run
from ..errors import MotesError
from .machines import Cluster, Network
from .platform import hosts, platform

__all__ = ["find_replay", "find_smpirun", "record", "simulate"]

FLAGS = {
    "smpi/simulate-computation": "no",  # work takes what its costs say
    "smpi/test": "0",  # a look whether a message has left takes no time
    "smpi/lat-factor": "0:1",  # networks are as the cluster says, not as SMPI's calibration to another
    "smpi/bw-factor": "0:1",
    "smpi/privatization": "no",  # the engine has no global state
    "network/crosstraffic": "0",
    "smpi/cpu-threshold": "-1",
    "smpi/send-is-detached-thresh": "65536",  # longer messages wait for their receiver
}
ALONE = {
    "smpi/send-is-detached-thresh": "0",  # the simulator searches one list for each message that is nobody's
}
"""Where messages do not share links."""


def find_smpirun() -> str:
    """Find SimGrid's launcher. Raises MotesError where it is absent."""
    found = shutil.which(os.environ.get("MOTES_SMPIRUN", "smpirun"))
    if found is None:
        raise MotesError(
            "virtual clusters need SimGrid's smpirun, and there is none: apt-get install libsimgrid-dev"
        )
    return found


def find_replay() -> Path:
    """Find `motes_replay` built for SMPI: `MOTES_SMPI_REPLAY`, or the source tree's, built anew where old.

    Raises MotesError where there is neither.
    """
    told = os.environ.get("MOTES_SMPI_REPLAY")
    if told:
        if not Path(told).is_file():
            raise MotesError(f"MOTES_SMPI_REPLAY={told} does not exist")
        return Path(told)
    for source in (Path.cwd(), Path(__file__).parents[3]):
        if (source / "cpp" / "driver" / "CMakeLists.txt").is_file():
            return _built(source)
    raise MotesError(
        "virtual clusters need motes_replay built for SMPI: run this in the source tree, or name the program "
        "in MOTES_SMPI_REPLAY (docs/native.md says how it is built)"
    )


@cache
def _built(source: Path) -> Path:
    """Build it where something changed; once a process."""
    cmake = shutil.which("cmake", path=_path())
    if cmake is None:
        raise MotesError("motes_replay for SMPI must be built from the source tree, and there is no cmake")
    folder = source / "build" / "smpi"
    steps = [[cmake, "--build", str(folder), "--target", "motes_replay", "--parallel", "2"]]
    if not (folder / "CMakeCache.txt").is_file():
        print(f"motes: building {folder} for the simulator, once", file=sys.stderr, flush=True)
        options = ["-DMOTES_MPI=smpi", "-DMOTES_PYTHON=OFF"]
        ninja = shutil.which("ninja", path=_path())
        options += ["-G", "Ninja", f"-DCMAKE_MAKE_PROGRAM={ninja}"] if ninja else []
        steps.insert(0, [cmake, "-S", str(source), "-B", str(folder), *options])
    for words in steps:
        made = subprocess.run(words, capture_output=True, text=True, check=False)
        if made.returncode != 0:
            raise MotesError(f"{' '.join(words)}\n{made.stdout[-3000:]}{made.stderr[-3000:]}".rstrip())
    return folder / "cpp" / "driver" / "motes_replay"


def _path() -> str:
    """Look among this environment's own programs first."""
    return os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])


def record(scene: Path, script: Path, words: Sequence[object] = ()) -> None:
    """Record a script's scene, in a process of its own. Raises MotesError with what the script said."""
    command = [sys.executable, "-m", "motes", "record", "-o", scene, script, *words]
    made = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if made.returncode != 0:
        raise MotesError(f"recording {script} failed:\n{made.stderr[-3000:]}".rstrip())


def _costs(path: str | os.PathLike[str] | None, network: Network) -> str:
    """What work costs, and what each message and its bytes take of the processors at its ends."""
    text = "" if path is None else Path(path).read_text()
    byte_s = 0.0 if network.shared else 1 / network.bandwidth
    return f"{text}\nmessage = {1e9 * network.overhead_s!r}\nbyte = {1e9 * byte_s!r}\n"


def simulate(
    scene: str | os.PathLike[str],
    cluster: Cluster,
    *,
    log: str | os.PathLike[str],
    costs: str | os.PathLike[str] | None = None,
    scale: float = 1.0,
    options: Sequence[str] = (),
) -> Run:
    """Replay a recorded scene on a virtual cluster; the run's log, in simulated seconds.

    `costs`: what work costs, lines `name = nanoseconds` on a machine of speed 1 (`paper.costs` is one).
    `scale`: particles that each particle of the scene stands for: work on particles, and messages that hold
    some, cost as many times more. `options` go to `motes_replay`. Raises MotesError where the run fails,
    with what it said.
    """
    scale = arguments.number("scale", scale, low=1e-9)
    smpirun, replay = find_smpirun(), find_replay()
    with tempfile.TemporaryDirectory(prefix="motes-cluster-") as text:
        folder = Path(text)  # run from there, so that the log does not depend on any path
        (folder / "platform.xml").write_text(platform(cluster))
        (folder / "hosts").write_text(hosts(cluster))
        (folder / "scene.motes").symlink_to(Path(scene).absolute())
        flags = FLAGS | ({} if cluster.networks[0].shared else ALONE)
        words = [smpirun, "-np", str(cluster.ranks), "-hostfile", "hosts", "-platform", "platform.xml"]
        words += [f"--cfg={name}:{value}" for name, value in flags.items()]
        words += [
            "--log=root.thresh:error",
            str(replay),
            "scene.motes",
            "--log",
            "log",
            "--scale",
            repr(scale),
        ]
        (folder / "costs").write_text(_costs(costs, cluster.networks[0]))
        words += ["--costs", "costs"]
        words += ["".join(option.split()) for option in options]  # smpirun parts words at blanks
        made = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
        if made.returncode == 0:
            shutil.copytree(folder / "log", log, dirs_exist_ok=True)
    if made.returncode != 0:
        said = [line for line in made.stderr.splitlines() if line.startswith("motes_replay:")]
        raise MotesError("the simulated run failed: " + ("\n".join(said) or made.stderr[-3000:]).rstrip())
    return open_run(log)
