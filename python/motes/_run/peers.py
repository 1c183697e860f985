"""Whether the processes of the other ranks are alive, as far as this host can tell."""

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
    """Start of the process in ticks since the host's start: it tells reused process numbers apart."""
    space: str
    """Where that number means something: the host's boot and its space of process numbers (containers)."""

    @classmethod
    def here(cls, *, rank: int, role: str) -> Peer:
        """Describe this process, for the others."""
        space = ""
        with contextlib.suppress(OSError), open("/proc/sys/kernel/random/boot_id") as file:
            space = f"{file.read().strip()} {os.readlink('/proc/self/ns/pid')}"
        with contextlib.suppress(OSError):
            started = _started(os.getpid()) or 0
            return cls(rank, role, os.uname().nodename, os.getpid(), started, space)
        return cls(rank, role, os.uname().nodename, os.getpid(), 0, "")


class PeerWatch:
    """Notices that a process on this host is gone, by the system's process handles where it has them."""

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
            except (OSError, AttributeError):  # gone already, or an old system: its number tells
                self._by_number.append(peer)
            else:
                self._by_handle[handle] = peer
                self._poll.register(handle, select.POLLIN)
                if not lives(peer):  # the number went to another process before the handle was opened
                    self._by_number.append(peer)

    def check(self, now: float | None = None) -> int | None:
        """Name a rank whose process is gone or a zombie, or None; looks at most once in 20 ms.

        `now` is a monotonic time in seconds, for a caller who has it at hand.
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
        """Tell whether the process of a rank is alive; None if this host cannot tell."""
        if rank == self.rank:
            return True
        peer = self.peers.get(rank)
        return None if peer is None else lives(peer)

    def life(self, rank: int) -> tuple[bool | None, str]:
        """Return the same, and words for it: "its process 4711 is stopped". A rank below 0: all ranks."""
        if rank < 0:
            lives = [self.alive(peer) for peer in range(self.size)]
            known = False if False in lives else None if None in lives else True
            return known, "their processes live" if known else ""
        known = self.alive(rank)
        if known is None:
            return None, "its process is on another host, where nobody here can tell whether it lives"
        if not known:
            return False, "its process is gone"
        if rank == self.rank:
            return True, "its process lives"
        return True, f"its process {self.peers[rank].pid} {_state(self.peers[rank].pid)}"

    def close(self) -> None:
        """Give the handles back."""
        for handle in self._by_handle:
            os.close(handle)
        self._by_handle, self._by_number, self._poll = {}, [], select.poll()

    def __del__(self) -> None:
        """Give the handles back."""
        with contextlib.suppress(Exception):
            self.close()


def lives(peer: Peer) -> bool:
    """Tell whether a process of this host is there, and the same one."""
    try:
        return _started(peer.pid) == peer.started
    except OSError:  # out of file descriptors, say: nothing is known, and a false alarm would end the job
        return True


def _state(pid: int) -> str:
    """Describe what the system does with a live process."""
    with contextlib.suppress(OSError, IndexError):
        with open(f"/proc/{pid}/stat", "rb") as file:
            state = file.read().rpartition(b")")[2].split()[0]
        if state == b"T":
            return f"is stopped (`kill -CONT {pid}` lets it go on)"
        if state == b"t":
            return "is stopped by a debugger"
    return "lives"


def _started(pid: int) -> int | None:
    """Return when a live process started, in ticks since the host's start; None if it is gone or a zombie."""
    try:
        with open(f"/proc/{pid}/stat", "rb") as file:
            # The name, in parentheses, may hold anything; the state and 18 numbers on, the start, come
            # after it.
            fields = file.read().rpartition(b")")[2].split()
    except (FileNotFoundError, ProcessLookupError):
        return None
    return None if fields[0] in (b"Z", b"X") else int(fields[19])
