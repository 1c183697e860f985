"""Several hosts on one machine: network namespaces on a switch, with names and shares of a core.

Needs root, `ip` (Debian's iproute2) and `unshare`. Messages between hosts go over TCP; files are shared.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import stat
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

__all__ = ["Hosts", "missing", "three_hosts"]

PERIOD_US = 10_000  # of a quota; short, to slow down short work, too
CONTROLLERS = ("/sys/fs/cgroup/cpu", "/sys/fs/cgroup")


def missing() -> str:
    """Return what this machine lacks, if anything."""
    if os.name != "posix" or os.geteuid() != 0:
        return "network namespaces need root"
    for tool in ("ip", "unshare"):
        if shutil.which(tool) is None:
            return f"network namespaces need {tool}"
    with contextlib.suppress(subprocess.CalledProcessError):
        probe = f"motes-probe-{os.getpid()}"  # two sessions may probe at once
        _ip("netns", "add", probe)
        _ip("netns", "del", probe)
        return ""
    return "no network namespaces here"


@dataclass
class Hosts:
    """The running hosts."""

    names: list[str]
    folder: Path
    daemons: list[subprocess.Popen[bytes]] = field(default_factory=list)

    @property
    def agent(self) -> Path:
        """The program that the launcher calls instead of ssh."""
        return self.folder / "agent"

    def options(self) -> list[str]:
        """Return arguments for mpirun: start daemons through the agent; between hosts use only TCP."""
        argv = ["--prtemca", "plm_ssh_agent", str(self.agent), "--prtemca", "prte_if_include", "eth0"]
        return [*argv, "--mca", "btl", "tcp,self,sm", "--mca", "btl_tcp_if_include", "eth0"]

    def start(self, name: str, line: str, log: Path, **variables: str) -> None:
        """Start a daemon on a host, by a line of shell; it ends with its host."""
        with log.open("wb") as output:
            daemon = subprocess.Popen(
                [self.agent, name, f"exec {line}"],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                env={**os.environ, **variables},
                start_new_session=True,
            )
        self.daemons.append(daemon)

    def limit(self, name: str) -> bool:
        """Prepare to slow down processes that start on a host later; False if no control group can do so."""
        group = _group(name)
        if group is None:
            return False
        (self.folder / name).mkdir(exist_ok=True)
        # Another name of the same folder: `ip netns exec` hides /sys from what it starts.
        _run("mount", "--bind", str(group), str(self.folder / name))
        return True

    def slow_down(self, name: str, share: float) -> None:
        """Give all processes of a host, together, this share of one core."""
        group, quota = self.folder / name, str(int(share * PERIOD_US))
        if (group / "cpu.max").exists():
            (group / "cpu.max").write_text(f"{quota} {PERIOD_US}")
        else:
            (group / "cpu.cfs_period_us").write_text(str(PERIOD_US))
            (group / "cpu.cfs_quota_us").write_text(quota)

    def lose(self, name: str) -> None:
        """Kill all processes of a host at once, like a power failure."""
        _lose(name)

    def cut_off(self, name: str) -> None:
        """Disconnect a host from the network."""
        _ip("-n", name, "link", "set", "eth0", "down")


@contextlib.contextmanager
def three_hosts(folder: Path) -> Iterator[Hosts]:
    """Put three hosts on a switch; remove them at the end."""
    prefix = f"m{os.getpid()}"
    names, switch = [f"{prefix}{letter}" for letter in "abc"], f"{prefix}s"
    hosts = Hosts(names, folder)
    # Each host has its own UTS namespace for its name; limit sets its control group, if any.
    hosts.agent.write_text(
        "#!/bin/sh\nhost=$1\nshift\n"
        f'group={folder}/$host/cgroup.procs\nif [ -e "$group" ]; then echo $$ > "$group"; fi\n'
        'exec ip netns exec "$host" unshare --uts /bin/sh -c "hostname $host; $*"\n'
    )
    hosts.agent.chmod(hosts.agent.stat().st_mode | stat.S_IXUSR)
    with _removed_at_the_end([*names, switch], folder):
        _switch(switch)
        for number, name in enumerate(names, start=1):
            _host(name, number, switch)
            files = Path("/etc/netns", name)  # seen as /etc there
            files.mkdir(parents=True)
            known = [f"10.77.0.{i} {other}" for i, other in enumerate(names, start=1)]
            (files / "hosts").write_text("\n".join(["127.0.0.1 localhost", *known, ""]))
        yield hosts
    for daemon in hosts.daemons:
        daemon.wait()


@contextlib.contextmanager
def _removed_at_the_end(names: Sequence[str], folder: Path) -> Iterator[None]:
    """Remove the hosts when the block ends, or this process, even by SIGKILL: another process does so."""
    argv = [sys.executable, __file__, str(folder), *names]
    guard = subprocess.Popen(argv, stdin=subprocess.PIPE, start_new_session=True)
    assert guard.stdin is not None
    try:
        yield
    finally:
        guard.stdin.close()  # as the system does at this process's end
        guard.wait()


def _switch(name: str) -> None:
    _ip("netns", "add", name)
    _ip("-n", name, "link", "add", "br0", "type", "bridge")
    _ip("-n", name, "link", "set", "br0", "up")


def _host(name: str, number: int, switch: str) -> None:
    port = f"port{number}"
    _ip("netns", "add", name)
    _ip("link", "add", "eth0", "netns", name, "type", "veth", "peer", "name", port, "netns", switch)
    _ip("-n", name, "addr", "add", f"10.77.0.{number}/24", "dev", "eth0")
    _ip("-n", name, "link", "set", "lo", "up")
    _ip("-n", name, "link", "set", "eth0", "up")
    _ip("-n", switch, "link", "set", port, "master", "br0")
    _ip("-n", switch, "link", "set", port, "up")


def _group(name: str) -> Path | None:
    """Make a control group that can limit the share of a core, with version 1 or 2 of control groups."""
    for root in map(Path, CONTROLLERS):
        with contextlib.suppress(OSError):
            group = root / f"motes-{name}"
            group.mkdir(exist_ok=True)
            if (group / "cpu.max").exists() or (group / "cpu.cfs_quota_us").exists():
                return group
            group.rmdir()
    return None


def _lose(name: str) -> None:
    for pid in _run("ip", "netns", "pids", name).split():
        with contextlib.suppress(ProcessLookupError):
            os.kill(int(pid), signal.SIGKILL)


def _forget(name: str, folder: Path) -> None:
    with contextlib.suppress(subprocess.CalledProcessError):
        for _ in range(3):  # what was killed may have started another process
            _lose(name)
    with contextlib.suppress(subprocess.CalledProcessError):
        _run("umount", str(folder / name))
    with contextlib.suppress(subprocess.CalledProcessError):
        _ip("netns", "del", name)
    shutil.rmtree(Path("/etc/netns", name), ignore_errors=True)
    for root in map(Path, CONTROLLERS):
        with contextlib.suppress(OSError):
            (root / f"motes-{name}").rmdir()


def _ip(*argv: str) -> None:
    _run("ip", *argv)


def _run(*argv: str) -> str:
    return subprocess.run(argv, check=True, capture_output=True, text=True).stdout


if __name__ == "__main__":
    sys.stdin.read()  # until the process that made the hosts ends
    for host in sys.argv[2:]:
        _forget(host, Path(sys.argv[1]))
