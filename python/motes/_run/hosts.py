"""Which hosts of a job still answer: a job that lost one starts again on the others."""

from __future__ import annotations

import os
import shlex
import socket
import subprocess

from ..errors import MotesError
from .output import tell

__all__ = ["reachable"]

_WAIT_S = 10.0
_AGENTS = ("PRTE_MCA_plm_ssh_agent", "OMPI_MCA_plm_rsh_agent")  # what mpirun itself reaches hosts with


def reachable(hosts: str) -> str:
    """Return those of "h1:2,h2" that answer, in the same form, and name the others.

    Raises MotesError where none does.
    """
    given = hosts.split(",")
    answering = [host for host in given if _answers(host.partition(":")[0])]
    silent = [host for host in given if host not in answering]
    if not answering:
        raise MotesError(f"no host answers: {hosts}")
    if silent:
        tell(f"motes run: goes on without {', '.join(silent)}, which no longer answer")
    return ",".join(answering)


def _answers(host: str) -> bool:
    if host in ("localhost", "127.0.0.1", socket.gethostname()):
        return True
    agent = next((os.environ[name] for name in _AGENTS if os.environ.get(name)), "ssh")
    argv = shlex.split(agent)
    if os.path.basename(argv[0]) == "ssh":
        argv += ["-o", "BatchMode=yes", "-o", f"ConnectTimeout={_WAIT_S:.0f}"]
    try:
        asked = subprocess.run([*argv, host, "true"], timeout=_WAIT_S, capture_output=True, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return asked.returncode == 0
