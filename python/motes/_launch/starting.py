"""Starts a script on many ranks with the mpirun that matches Python's MPI library, and the flags it needs."""

from __future__ import annotations

import contextlib
import importlib
import os
import re
import shutil
import signal
import subprocess
import sys
import sysconfig
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

from .._io.output import tell
from .._mpi.loading import import_mpi, paths, problem_of_mpi, same_library, use_mpi
from .._mpi.presence import LAUNCHER_TELLS, started_by
from .._run import losses
from .._values import environment
from ..errors import ArgumentError, MotesError
from .files import folder_of_a_launcher
from .hosts import check_names, reachable
from .resizing import LAUNCHER, Resizing, Size
from .supervisor import supervise

__all__ = [
    *("Mpirun", "Version", "allocated", "cannot_survive", "check_program", "command", "find_mpirun"),
    *("library", "most_ranks", "other_launchers", "reason", "run"),
]

_MOST_RANKS = 1_000_000  # over all hosts
_RANK_BYTES = 16 << 20  # a rank with Python and MPI takes more


class Version(NamedTuple):
    """Which MPI a library or a launcher belongs to."""

    family: str
    """"Open MPI", "MPICH", "Intel MPI" or "unknown"."""
    number: str

    def fits(self, other: Version) -> bool:
        """Whether a launcher of one can start ranks of the other: the same MPI, major and minor version."""
        return self.family == other.family and self.parts[:2] == other.parts[:2]

    @property
    def kind(self) -> str:
        """Which libraries a launcher of this version can connect, as `launchers.kind` says it."""
        if self.family == "Open MPI":
            return "Open MPI 4" if self.parts < (5,) else ""
        return "MPICH" if self.family != "unknown" else ""

    @property
    def parts(self) -> tuple[int, ...]:
        """The version's numbers, such as (5, 0, 11)."""
        return tuple(int(digits) for digits in re.findall(r"\d+", self.number))

    def __str__(self) -> str:
        """Return family and number, such as "Open MPI 5.0.11"."""
        return f"{self.family} {self.number}".strip()


class Mpirun(NamedTuple):
    """A launcher on this machine."""

    path: str
    version: Version
    problem: str = ""
    """Why its version is unknown, if it could not be asked."""

    @property
    def argv(self) -> list[str]:
        """The command that starts it."""
        return _start_of(self.path)

    def __str__(self) -> str:
        """Return the path, and the version or why it is unknown."""
        return f"{self.path} ({self.problem or self.version})"


def library() -> Version:
    """Return which MPI library mpi4py loads, without starting MPI. Raises MotesError if it loads none."""
    if "mpi4py.MPI" not in sys.modules:
        import mpi4py

        mpi4py.rc.initialize = mpi4py.rc.finalize = False
    launcher = _named()
    try:
        MPI = import_mpi(launcher.version.kind if launcher else "")
    except (ImportError, RuntimeError) as error:
        raise MotesError(problem_of_mpi(error)) from None
    return _version(MPI.Get_library_version())


def find_mpirun() -> Mpirun:
    """Find the launcher of the MPI library in use: `MOTES_MPIRUN`, this environment's own, or the site's.

    Raises MotesError when there is none, naming those that belong to another MPI.
    """
    if (launcher := _named()) is not None:
        return launcher
    wanted = library()
    launchers = []
    for path in _launchers():
        launchers.append(_asked(path))
        if launchers[-1].version.fits(wanted):
            return launchers[-1]
    others = ", ".join(map(str, launchers)) or "none at all"
    raise MotesError(f"mpi4py uses {wanted}, and no mpirun of that MPI was found; found: {others}{paths()}")


def _named() -> Mpirun | None:
    """Return the launcher that the user has chosen, if any."""
    name = environment.read("MOTES_MPIRUN")
    if not name:
        return None
    path = shutil.which(name)
    if path is None:
        raise MotesError(f"MOTES_MPIRUN={name} is not a program that can be started")
    return _asked(path)


def other_launchers(mpirun: Mpirun) -> list[Mpirun]:
    """List the launchers here that belong to another MPI than `mpirun`, or do not say to which."""
    return [other for other in map(_asked, _launchers()) if not other.version.fits(mpirun.version)]


def command(
    ranks: int,
    program: Sequence[str],
    *,
    hosts: str | None = None,
    hostfile: str | None = None,
    options: Sequence[str] = (),
    survive: bool = False,
    mpirun: Mpirun | None = None,
) -> list[str]:
    """Compose the command line that starts `program` on `ranks` ranks.

    `hosts` is "h1,h2:2" with the number of ranks that each may take (default 1); `options` go to mpirun.
    `survive`: a rank that is killed does not end the others; raises MotesError if the MPI cannot do that.
    """
    if hosts is not None and hostfile is not None:
        raise MotesError("give either --hosts or --hostfile")
    one_host = hosts is None and hostfile is None and allocated() is None
    most = most_ranks() if one_host else _MOST_RANKS
    if not 1 <= ranks <= most:
        where = f" on this machine, with {_RANK_BYTES >> 20} MB for each" if one_host else ""
        raise ArgumentError("n", ranks, f"in 1..{most}, the number of ranks{where}")
    if hosts is not None:
        check_names("hosts", (host.partition(":")[0] for host in hosts.split(",")))
    if hostfile is not None:
        _check_hostfile(hostfile)
    mpirun = mpirun or find_mpirun()
    argv = [*mpirun.argv, "-n", str(ranks)]
    if survive:
        _check_survival(mpirun.version)
        argv += ["--with-ft", "ulfm"]
    if mpirun.version.family == "Open MPI":
        argv += _open_mpi_flags(ranks, mpirun.version, hosts, hostfile, options)
    elif hosts is not None:
        argv += ["-hosts", hosts]
    elif hostfile is not None:
        argv += ["-f", hostfile]
    return [*argv, *options, *program]


def run(
    ranks: int,
    program: Sequence[str],
    *,
    hosts: str | None = None,
    hostfile: str | None = None,
    options: Sequence[str] = (),
    survive: bool = False,
    restarts: int = 0,
) -> int:
    """Run `python program...` on `ranks` ranks and return the exit code.

    `survive`: a rank that is killed does not end the others; 0 then means that the others succeeded.
    `restarts`: how often the job may restart after a process or host was lost, on the `hosts` that answer.

    A single rank on this host needs no launcher, unless viewers may ask for more: this process becomes Python
    and does not return. Otherwise it supervises the launcher (`_launch/supervisor.py`).
    """
    check_program(program)
    if restarts < 0:
        raise ArgumentError("restarts", restarts, "an integer >= 0")
    python = [sys.executable, *program]
    rank = started_by(python, is_rank=program[0] != "-m")  # a module may start the script in another process
    if survive:
        _check_survival()

    def compose(size: Size) -> list[str]:
        if size.ranks == 1 and not size.hosts and not hostfile and not options:
            return python
        return command(
            size.ranks, rank, hosts=size.hosts, hostfile=hostfile, options=options, survive=survive
        )

    argv = compose(size := Size(ranks, hosts))
    if argv is not python:
        library()
        os.environ.update(same_library(import_mpi()))  # also for scripts that import mpi4py before motes
    _leave_mpi()
    sys.stdout.flush()
    sys.stderr.flush()
    if argv != python or restarts > 0 or environment.read("MOTES_LIVE") not in (None, environment.LIVE_OFF):
        variables = {**losses.ENVIRONMENT, **LAUNCHER_TELLS} if survive else {}
        with folder_of_a_launcher() as folder:
            return _run_again(Resizing(folder, size, compose), compose, variables, restarts)
    if os.name == "posix":
        os.execve(argv[0], argv, os.environ)  # os.environ lacks what MPI added when it started
    return subprocess.run(argv).returncode


def _run_again(
    resizing: Resizing, compose: Callable[[Size], list[str]], variables: Mapping[str, str], restarts: int
) -> int:
    """Run a job to its end, over all its starts, and return the exit code."""
    os.environ[LAUNCHER] = resizing.address  # for the ranks of all starts
    if hasattr(signal, "SIGUSR2"):  # must not end this process between two starts of the job
        signal.signal(signal.SIGUSR2, lambda *_: None)
    while True:
        ended = supervise(compose(resizing.size), variables, resizing.size.ranks, resizing)
        resized = resizing.take(ended.code)
        if not resized and (restarts == 0 or not ended.lost):
            return ended.code
        os.environ.pop("MOTES_FRESH", None)  # a restart resumes from this run's checkpoints
        environment.wait_no_longer()
        if resized:
            continue
        restarts -= 1
        if resizing.size.hosts is not None:
            resizing.size = resizing.size._replace(hosts=reachable(resizing.size.hosts))
        more = f"{restarts} more {'restart is' if restarts == 1 else 'restarts are'} allowed"
        tell(f"motes run: restarts; {more}")


def cannot_survive(launcher: Version | None = None) -> str | None:
    """Return why the loss of a rank ends a job here; None: `run(..., survive=True)` lets others continue."""
    wanted = "surviving the loss of a rank needs Open MPI 5 or later, built with ULFM"
    version = library()
    for each in (version, launcher or version):
        if each.family != "Open MPI" or each.parts < (5,):
            return f"{wanted}; this is {each}"
    use_mpi(import_mpi())  # without starting MPI
    if not importlib.import_module("motes._core").mpi_can_survive():
        return f"{wanted}; this {version} was built without it"
    return None


def _check_survival(launcher: Version | None = None) -> None:
    if (reason := cannot_survive(launcher)) is not None:
        raise MotesError(f"--survive: {reason}")


_TOLD_ALL = (
    *("MOTES_ANYWAY", "MOTES_FRAMES", "MOTES_FRESH", "MOTES_LIVE", "MOTES_PREVIEW", "MOTES_STEERING"),
    *("MOTES_STILL", "MOTES_SWEEP", LAUNCHER, "MPI4PY_LIBMPI"),
)
"""Variables that `motes run` sets; Open MPI does not pass variables to other hosts by itself."""


def most_ranks() -> int:
    """Return how many ranks this machine may hold, as limited by memory and the number of processes."""
    memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    numbers = 32768
    with contextlib.suppress(OSError, ValueError):
        numbers = int(Path("/proc/sys/kernel/pid_max").read_text())
    return max(64, min(memory // _RANK_BYTES, numbers // 2))


_BINDING_POLICY = "_binding_policy"  # how the binding parameters of Open MPI 4 and 5 end
_PLACING = re.compile(
    rf"-?-(bind-to|cpu-set|cpu-list|rankfile|rf)\b|.*\b(pe|pe-list|rankfile)\b|.*{_BINDING_POLICY}$",
    re.IGNORECASE,
)
"""Options of mpirun that bind ranks to processors or choose their processors."""


def _open_mpi_flags(
    ranks: int, version: Version, hosts: str | None, hostfile: str | None, options: Sequence[str]
) -> list[str]:
    flags = []
    is_one_host = False
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        flags.append("--allow-run-as-root")  # as in a container; mpirun refuses root otherwise
    if hosts is not None or hostfile is not None or allocated() is not None:
        for name in _TOLD_ALL:
            flags += ["-x", name] if os.environ.get(name) else []
    if hosts is not None:
        slots = _slots(host.partition(":")[2] or "1" for host in hosts.split(","))
        flags += ["--host", ",".join(host if ":" in host else f"{host}:1" for host in hosts.split(","))]
    elif hostfile is not None:
        lines = [line.split("#")[0] for line in Path(hostfile).read_text().splitlines()]
        matches = [re.search(r"slots\s*=\s*(\d+)", line) for line in lines if line.strip()]
        slots = _slots(match[1] if match else "" for match in matches)
        flags += ["--hostfile", hostfile]
    elif (slots := allocated()) is None:
        slots = os.cpu_count() or 1
        flags.append("--oversubscribe")  # otherwise mpirun refuses more ranks than cores
        is_one_host = True
    bound = any(map(_PLACING.match, options)) or any(name.endswith(_BINDING_POLICY) for name in os.environ)
    if not is_one_host and not bound:
        # mpirun would bind each rank to one core, and refuse more ranks than cores.
        flags += ["--bind-to", "none"]
    if slots is not None and ranks > slots:
        # Waiting ranks give their core to those that work.
        flags += ["--mca", "mpi_yield_when_idle", "1"]
        if not is_one_host and not any(text.lstrip("-") == "map-by" for text in options):
            # "node" spreads the ranks; without it all excess ranks land on the first host.
            if version.parts >= (5,):
                flags += ["--map-by", "node:OVERSUBSCRIBE"]
            else:
                flags += ["--map-by", "node", "--oversubscribe"]
    return flags


def allocated() -> int | None:
    """Return how many ranks the scheduler has allocated to this job, or None; Open MPI asks it where."""
    tasks = os.environ.get("SLURM_NTASKS", "")
    if "SLURM_JOB_ID" in os.environ and tasks.isdigit():
        return int(tasks)
    nodes = Path(os.environ.get("PBS_NODEFILE", ""))
    return len(nodes.read_text().split()) if nodes.is_file() else None


def _slots(numbers: Iterable[str]) -> int | None:
    """Return how many ranks the hosts take; None if one has no number (Open MPI then counts its cores)."""
    listed = list(numbers)
    return sum(map(int, listed)) if all(number.isdigit() for number in listed) else None


def _check_hostfile(hostfile: str) -> None:
    try:
        lines = Path(hostfile).read_text().splitlines()
    except FileNotFoundError:
        raise MotesError(f"hostfile {hostfile} does not exist") from None
    except (OSError, ValueError) as error:
        raise MotesError(f"hostfile {hostfile} cannot be read: {error}") from None
    names = [line.partition("#")[0].split()[:1] for line in lines]
    check_names("hostfile", (name[0].partition(":")[0].lstrip("+^") for name in names if name))


def check_program(program: Sequence[str]) -> None:
    """Raise MotesError if there is no such script or no argument after -m or -c."""
    if not program:
        raise MotesError("no script given: python -m motes run -n 4 script.py")
    if program[0].startswith("-"):
        if len(program) < 2:
            raise MotesError(f"{program[0]} needs an argument after it")
    elif not Path(program[0]).is_file():
        raise MotesError(f"script {program[0]} does not exist")


def _leave_mpi() -> None:
    """Finalize MPI if importing motes started it: the new ranks must not inherit its session."""
    module = sys.modules.get("mpi4py.MPI")
    if module is not None and module.Is_initialized() and not module.Is_finalized():
        module.Finalize()


_NAMES = (
    *("mpirun", "mpirun.openmpi", "mpirun.mpich"),
    *("mpiexec", "mpiexec.openmpi", "mpiexec.mpich", "mpiexec.hydra", "ompirun_wrapper"),
)
"""Names of launchers. Packages of two MPIs overwrite each other's mpirun, but not the last two."""


def _launchers() -> list[str]:
    """List the launchers of this environment, then those on the PATH."""
    own = [Path(sys.executable).parent, Path(sysconfig.get_path("scripts"))]
    paths = [shutil.which(name, path=str(folder)) for folder in own for name in _NAMES]
    paths += [shutil.which(name) for name in _NAMES]
    return list(dict.fromkeys(path for path in paths if path is not None))


def _start_of(path: str) -> list[str]:
    """Return the command that starts a launcher.

    `mpirun` of the package `openmpi` is a program that sets OPAL_PREFIX and becomes ompirun_wrapper.
    """
    if os.path.basename(path) != "ompirun_wrapper":
        return [path]
    return [shutil.which("env") or "/usr/bin/env", f"OPAL_PREFIX={Path(path).resolve().parents[1]}", path]


@cache
def _asked(path: str) -> Mpirun:
    """Ask a launcher for its version."""
    try:
        answer = subprocess.run(
            [*_start_of(path), "--version"], capture_output=True, text=True, errors="replace", timeout=20
        )
    except (OSError, subprocess.SubprocessError) as error:
        return Mpirun(path, Version("unknown", ""), f"--version: {error}")
    version = _version(answer.stdout + answer.stderr)
    if version.family != "unknown" or answer.returncode == 0:
        return Mpirun(path, version)
    return Mpirun(path, version, f"--version: {reason(answer)}")


def reason(failed: subprocess.CompletedProcess[str]) -> str:
    """Return the line of a failed program's standard error that says why it failed, or its exit code."""
    lines = [line.strip() for line in failed.stderr.splitlines() if line.strip(" -\t")]
    if not lines:
        return f"exit code {failed.returncode}"
    return lines[-1] if "Traceback" in failed.stderr else lines[0]  # Python prints it last, mpirun first


def _version(text: str) -> Version:
    """Parse the version text of a library or a launcher."""
    patterns = {
        # "Open MPI v5.0.11, ...", "mpirun (Open MPI) 5.0.11" and "mpiexec (OpenRTE) 4.1.4"
        "Open MPI": r"Open(?: MPI|RTE)\)? v?(\d[\w.]*)",
        "Intel MPI": r"Intel\(R\) MPI Library.*?(?:Version )?(\d{4}[\w.]*)",
        "MPICH": r"(?:MPICH|HYDRA)[\s\S]*?Version:\s*(\d[\w.]*)",
    }
    for family, pattern in patterns.items():
        match = re.search(pattern, text)
        if match:
            return Version(family, match[1])
    return Version("unknown", "")
