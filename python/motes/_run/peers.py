"""Watch whether the other ranks' processes are alive, as far as this host can tell."""

from __future__ import annotations

import contextlib
import os
import select
import time
from collections.abc import Sequence
from typing import NamedTuple

__all__ = ["Peer", "PeerWatch", "lives"]

PEER_CHECK_S = 0.02


class Peer(NamedTuple):
    """How to find another rank's process."""

    rank: int
    role: str
    host: str
    pid: int
    started: int
    """The process's start in clock ticks since boot, to detect that its pid has been reused."""
    space: str
    """The scope of `pid`: the host's boot id and the pid namespace (containers)."""
    machine: str = ""
    """What this process computes with: the kernels' instruction set and NumPy's version."""

    @classmethod
    def here(cls, *, rank: int, role: str) -> Peer:
        """Describe this process to the other ranks."""
        space = ""
        with contextlib.suppress(OSError), open("/proc/sys/kernel/random/boot_id") as file:
            space = f"{file.read().strip()} {os.readlink('/proc/self/ns/pid')}"
        with contextlib.suppress(OSError):
            started = _started(os.getpid()) or 0
            return cls(rank, role, os.uname().nodename, os.getpid(), started, space)
        return cls(rank, role, os.uname().nodename, os.getpid(), 0, "")


class PeerWatch:
    """Detects that a process on this host is gone, by pidfds if the system has them."""

    def __init__(self, peers: Sequence[Peer], *, rank: int) -> None:
        """Watch the peers that share the host of `rank`, this process."""
        self.rank = rank
        self.size = len(peers)
        mine = next(peer for peer in peers if peer.rank == rank)
        self.peers = {
            peer.rank: peer for peer in peers if mine.space and peer.space == mine.space and peer.rank != rank
        }
        self._by_handle: dict[int, Peer] = {}
        self._by_number: list[Peer] = []
        self._poll = select.poll()
        self._last = float("-inf")
        for peer in self.peers.values():
            try:
                handle = os.pidfd_open(peer.pid)
            except (OSError, AttributeError):  # gone already, or no pidfds on this system: check by pid
                self._by_number.append(peer)
            else:
                self._by_handle[handle] = peer
                self._poll.register(handle, select.POLLIN)
                if not lives(peer):  # the pid was reused before the handle was opened
                    self._by_number.append(peer)

    def check(self, now: float | None = None) -> int | None:
        """Return a rank whose process is gone or a zombie, or None; check at most every 20 ms.

        `now`: the monotonic time in seconds, if the caller knows it.
        """
        now = time.monotonic() if now is None else now
        if now - self._last < PEER_CHECK_S:
            return None
        self._last = now
        for handle, _ in self._poll.poll(0) if self._by_handle else ():
            return self._by_handle[handle].rank
        for peer in self._by_number:
            if not lives(peer):
                return peer.rank
        return None

    def alive(self, rank: int) -> bool | None:
        """Return whether the process of a rank is alive; None if this host cannot tell."""
        if rank == self.rank:
            return True
        peer = self.peers.get(rank)
        return None if peer is None else lives(peer)

    def life(self, rank: int) -> tuple[bool | None, str]:
        """Return `alive(rank)` and a description, as "its process 4711 is stopped"; `rank` < 0: all ranks."""
        if rank < 0:
            lives = [self.alive(peer) for peer in range(self.size)]
            known = False if False in lives else None if None in lives else True
            return known, "their processes are alive" if known else ""
        known = self.alive(rank)
        if known is None:
            return None, "its process is on another host, so whether it is alive is unknown"
        if not known:
            return False, "its process is gone"
        if rank == self.rank:
            return True, "its process is alive"
        return True, f"its process {self.peers[rank].pid} {_state(self.peers[rank].pid)}"

    def close(self) -> None:
        """Close the handles."""
        for handle in self._by_handle:
            os.close(handle)
        self._by_handle, self._by_number, self._poll = {}, [], select.poll()

    def __del__(self) -> None:
        """Close the handles."""
        with contextlib.suppress(Exception):
            self.close()


def lives(peer: Peer) -> bool:
    """Return whether a process of this host is alive, and its pid has not been reused."""
    try:
        return _started(peer.pid) == peer.started
    except OSError:  # for example, out of file descriptors: a false alarm would end the job
        return True


def _state(pid: int) -> str:
    """Describe the state of a live process."""
    with contextlib.suppress(OSError, IndexError):
        with open(f"/proc/{pid}/stat", "rb") as file:
            state = file.read().rpartition(b")")[2].split()[0]
        if state == b"T":
            return f"is stopped (`kill -CONT {pid}` resumes it)"
        if state == b"t":
            return "is stopped by a debugger"
    return "is alive"


def _started(pid: int) -> int | None:
    """Return a live process's start in clock ticks since boot; None if it is gone or a zombie."""
    try:
        with open(f"/proc/{pid}/stat", "rb") as file:
            # The name, in parentheses, may contain anything. The state follows it, and the start is 19 fields
            # after the state.
            fields = file.read().rpartition(b")")[2].split()
    except (FileNotFoundError, ProcessLookupError):
        return None
    return None if fields[0] in (b"Z", b"X") else int(fields[19])
