"""A real sshd on each simulated host, with keys and settings of its own: each sees its own /etc/ssh.

Needs what `hosts` needs, and Debian's package openssh-server, whose service need not run.
"""

from __future__ import annotations

import contextlib
import shutil
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import hosts
from hosts import Hosts

import motes

__all__ = ["missing", "with_ssh"]

SSHD = "/usr/sbin/sshd"
START_S = 20.0
# A session has a new environment, with only the package's sources in it.
SERVER = """\
HostKey {folder}/host
AuthorizedKeysFile {folder}/user.pub
StrictModes no
PermitRootLogin prohibit-password
PidFile none
SetEnv PYTHONPATH={package}
"""
CLIENT = """\
IdentityFile {folder}/user
UserKnownHostsFile {folder}/known
"""


def missing() -> str:
    """Return what this machine lacks, if anything."""
    if not Path(SSHD).exists() or shutil.which("ssh") is None:
        return "needs ssh: apt-get install openssh-client openssh-server"
    return hosts.missing()


@contextlib.contextmanager
def with_ssh(folder: Path) -> Iterator[Hosts]:
    """Put three hosts on a switch that reach each other by ssh; remove them at the end."""
    with hosts.three_hosts(folder) as three:
        for key in ("host", "user"):
            subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", folder / key], check=True)
        public = (folder / "host.pub").read_text()
        (folder / "known").write_text("".join(f"{name} {public}" for name in three.names))
        Path("/run/sshd").mkdir(exist_ok=True)
        facts = {"folder": folder, "package": Path(motes.__file__).parents[1]}
        for name in three.names:
            etc = Path("/etc/netns", name, "ssh")  # seen as /etc/ssh there
            etc.mkdir()
            (etc / "sshd_config").write_text(SERVER.format(**facts))
            (etc / "ssh_config").write_text(CLIENT.format(**facts))
            three.start(name, f"{SSHD} -D -e", folder / f"{name}.sshd.log")
        for name in three.names:
            _wait(three, name)
        yield three


def _wait(three: Hosts, name: str) -> None:
    limit = time.monotonic() + START_S
    while True:
        ask = [three.agent, three.names[0], f"ssh -o BatchMode=yes {name} hostname"]
        answer = subprocess.run(
            ask, capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=START_S
        )
        if answer.stdout.strip() == name:
            return
        if time.monotonic() > limit:
            raise AssertionError(f"{name} has not started sshd within {START_S:g} s: {answer.stderr}")
        time.sleep(0.2)
