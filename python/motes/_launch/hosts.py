"""Asks hosts: which still answer, for a job that restarts on them; what a program says there."""

from __future__ import annotations

import os
import re
import shlex
import socket
import subprocess
from collections.abc import Iterable, Sequence

from .._io.output import tell
from ..errors import ArgumentError, MotesError

__all__ = ["answer_of", "check_names", "reachable"]

_WAIT_S = 10.0
_AGENTS = ("PRTE_MCA_plm_ssh_agent", "OMPI_MCA_plm_rsh_agent")  # the remote shell that mpirun uses


_NAME = re.compile(r"(?:[A-Za-z0-9_][A-Za-z0-9_.-]*@)?[A-Za-z0-9_][A-Za-z0-9_.-]*")
"""Names that ssh takes for a host, never for an option."""


def check_names(argument: str, hosts: Iterable[str]) -> None:
    """Raise ArgumentError if one of the names, given without numbers of ranks, is not a valid host name."""
    for host in hosts:
        if not _NAME.fullmatch(host):
            allowed = "names of hosts made of letters, digits, '.', '-' and '_', not beginning with '-'"
            raise ArgumentError(argument, host, allowed)


def reachable(hosts: str) -> str:
    """Return the hosts of "h1:2,h2" that answer, in the same form; print the names of the others.

    Raises MotesError if none answers, ArgumentError for an invalid name.
    """
    given = hosts.split(",")
    check_names("hosts", (host.partition(":")[0] for host in given))
    answering = [host for host in given if _answers(host.partition(":")[0])]
    silent = [host for host in given if host not in answering]
    if not answering:
        raise MotesError(f"no host answers: {hosts}")
    if silent:
        tell(f"motes run: continues without {', '.join(silent)}, which no longer answer")
    return ",".join(answering)


def answer_of(host: str, argv: Sequence[str], seconds: float) -> subprocess.CompletedProcess[str]:
    """Run a program on a host, by the remote shell that mpirun uses, and return what it answers.

    Raises OSError and subprocess.TimeoutExpired.
    """
    if host not in ("localhost", "127.0.0.1", socket.gethostname()):
        agent = shlex.split(next((os.environ[name] for name in _AGENTS if os.environ.get(name)), "ssh"))
        if os.path.basename(agent[0]) == "ssh":
            agent += ["-o", "BatchMode=yes", "-o", f"ConnectTimeout={_WAIT_S:.0f}"]
        argv = [*agent, host, shlex.join(argv)]
    return subprocess.run(
        argv, timeout=seconds, capture_output=True, text=True, errors="replace", stdin=subprocess.DEVNULL
    )


def _answers(host: str) -> bool:
    try:
        return answer_of(host, ["true"], _WAIT_S).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        return False
