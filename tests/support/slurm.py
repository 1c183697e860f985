"""Slurm on simulated hosts: munge, slurmctld, a slurmd per host, in namespaces and folders of their own.

Needs what `hosts` needs, and Debian's packages slurm-wlm, munge and libpmix-dev, whose daemons need not run.
"""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import hosts
from hosts import Hosts
from launching import Result, command

import motes

__all__ = ["Cluster", "Job", "missing", "slurm"]

PROGRAMS = ("munged", "slurmctld", "slurmd", "srun", "sbatch", "salloc", "scontrol")
PACKAGES = "apt-get install slurm-wlm munge libpmix-dev"
CPUS = 4
START_S = 60.0
PATH = os.pathsep.join([os.environ.get("PATH", ""), "/usr/sbin", "/sbin"])
EXPIRES_S = 10  # a credential; also how long a job waits before it is started again

# Nodes have more processors than this machine may have; jobs share them, nothing is bound or accounted.
CONFIGURATION = """\
ClusterName=motes
SlurmctldHost={first}(10.77.0.1)
SlurmUser=root
SlurmdUser=root
AuthInfo=socket={folder}/munge/socket,cred_expire={expires}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/%h
TmpFS={folder}/%h/tmp
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.%h.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.%h.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=2,bf_interval=2,batch_sched_delay=0
ReturnToService=2
KillWait=5
{nodes}
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def missing() -> str:
    """Return what this machine lacks, if anything."""
    lacking = [name for name in PROGRAMS if shutil.which(name, path=PATH) is None]
    if lacking:
        return f"needs Slurm ({', '.join(lacking)}): {PACKAGES}"
    return hosts.missing()


@dataclass(frozen=True)
class Job:
    """A job as scontrol shows it."""

    state: str
    restarts: int
    code: int
    output: str
    """What it has printed."""


@dataclass
class Cluster:
    """A running Slurm."""

    hosts: Hosts
    folder: Path

    @property
    def pmix(self) -> bool:
        """Whether srun can start ranks by PMIx."""
        return bool(re.search(r"\bpmix", self.run("srun", "--mpi=list").text))

    def run(self, *argv: object, timeout: float = 120, env: dict[str, str] | None = None) -> Result:
        """Run a command on the first host."""
        package = str(Path(motes.__file__).parents[1])
        given = {"SLURM_CONF": str(self.folder / "slurm.conf"), "PYTHONPATH": package, **(env or {})}
        line = shlex.join(map(str, argv))
        return command([self.hosts.agent, self.hosts.names[0], f"exec {line}"], timeout=timeout, env=given)

    def submit(self, script: Path, *options: object) -> str:
        """Submit a batch script and return the job's number."""
        ended = self.run("sbatch", "--parsable", *options, script)
        return ended.lines[-1]

    def wait(self, job: str, timeout: float) -> list[Job]:
        """Return a job's tasks (one, or an array's) once all have ended; cancel it at the limit."""
        limit = time.monotonic() + timeout
        while True:
            tasks = self.jobs(job)
            if tasks and not any(task.state in ("PENDING", "RUNNING", "COMPLETING") for task in tasks):
                return tasks
            if time.monotonic() > limit:
                self.run("scancel", job)
                raise AssertionError(f"job {job} has not ended within {timeout:g} s: {tasks}\n{self.logs()}")
            time.sleep(0.5)

    def jobs(self, job: str) -> list[Job]:
        """Return a job's tasks in ascending order."""
        shown = self.run("scontrol", "show", "job", "--oneliner", job).lines
        facts = [dict(re.findall(r"(\w+)=(\S*)", line)) for line in shown if line.startswith("JobId=")]
        facts.sort(key=lambda one: int(one["JobId"]))
        return [
            Job(
                one["JobState"],
                int(one["Restarts"]),
                int(one["ExitCode"].partition(":")[0]),
                _text(Path(one["StdOut"])),
            )
            for one in facts
        ]

    def logs(self) -> str:
        """Return the ends of the daemons' logs."""
        return "\n".join(f"{path.name}: {_text(path)[-3000:]}" for path in sorted(self.folder.glob("*.log")))


@contextlib.contextmanager
def slurm(folder: Path) -> Iterator[Cluster]:
    """Start Slurm on three hosts, and end it with them: no daemon leaves its host's namespace."""
    # Names of sockets are short: not below pytest's folders.
    with hosts.three_hosts(folder) as three, tempfile.TemporaryDirectory(prefix="motes-slurm-") as name:
        cluster = Cluster(three, Path(name))
        _configure(cluster)
        munge = cluster.folder / "munge"
        key = ["--key-file", munge / "key", "--seed-file", munge / "seed", "--pid-file", munge / "pid"]
        where = ["--socket", munge / "socket", "--log-file", cluster.folder / "munged.log"]
        _daemon(cluster, three.names[0], "munged", "--foreground", "--force", *key, *where)
        _wait(cluster, (munge / "socket").exists)
        _daemon(cluster, three.names[0], "slurmctld", "-D")
        for host in three.names:
            _daemon(cluster, host, "slurmd", "-D")
        _wait(cluster, lambda: _idle(cluster) == len(three.names))
        yield cluster


def _configure(cluster: Cluster) -> None:
    folder, names = cluster.folder, cluster.hosts.names
    for name in ("munge", "state", *names):
        (folder / name).mkdir(mode=0o755)
    for name in names:
        (folder / name / "tmp").mkdir()
    (folder / "munge" / "key").write_bytes(os.urandom(128))
    (folder / "munge" / "key").chmod(0o600)
    folder.chmod(0o755)
    nodes = "\n".join(
        f"NodeName={name} NodeAddr=10.77.0.{number} CPUs={CPUS} State=UNKNOWN"
        for number, name in enumerate(names, start=1)
    )
    text = CONFIGURATION.format(first=names[0], folder=folder, expires=EXPIRES_S, nodes=nodes)
    (folder / "slurm.conf").write_text(text)
    (folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\n")


def _daemon(cluster: Cluster, host: str, *argv: object) -> None:
    log = cluster.folder / f"{argv[0]}.{host}.out.log"
    variables = {"PATH": PATH, "SLURM_CONF": str(cluster.folder / "slurm.conf")}
    cluster.hosts.start(host, shlex.join(map(str, argv)), log, **variables)


def _idle(cluster: Cluster) -> int:
    shown = cluster.run("sinfo", "--noheader", "--Node", "--format=%T")
    return shown.out.split().count("idle") if shown.code == 0 else 0


def _wait(cluster: Cluster, condition: Callable[[], bool]) -> None:
    limit = time.monotonic() + START_S
    while not condition():
        if time.monotonic() > limit:
            raise AssertionError(f"Slurm has not started within {START_S:g} s\n{cluster.logs()}")
        time.sleep(0.2)


def _text(path: Path) -> str:
    return path.read_text(errors="replace") if path.is_file() else ""
