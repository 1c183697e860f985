"""Machines and networks of a virtual cluster, as values."""

from __future__ import annotations

import runpy
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from .._values import arguments
from ..errors import ArgumentError, MotesError

__all__ = ["Cluster", "FastEthernet", "Modern", "Myrinet", "Network", "Node", "described"]


@dataclass(frozen=True)
class Network:
    """A switched network: each node has its own link, at full speed in both directions at once.

    Attributes:
        name: of the network.
        bandwidth: bytes per second of a node's link, in one direction.
        latency_s: seconds from one node to another.
        overhead_s: processor seconds that a message takes at each of its ends; the first network's value
            counts.
        shared: whether messages share their nodes' links as they travel. If not, each message travels alone,
            and the processors at its ends are busy with its bytes for as long as the link would be (the LogGP
            model, Alexandrov et al. 1995). That suits thousands of ranks, for which a simulator would need
            hours to share links among messages. The first network's value counts.
    """

    name: str
    bandwidth: float
    latency_s: float
    """Seconds from one node to another."""
    overhead_s: float = 0.0
    shared: bool = True
    """Whether messages share their nodes' links as they travel. If not, each message travels alone, and the
    processors at its ends are busy with its bytes for as long as the link would be (the LogGP model,
    Alexandrov et al. 1995). That suits thousands of ranks, for which a simulator would need hours to share
    links among messages. The first network's value counts."""

    def __post_init__(self) -> None:
        """Check what was given."""
        arguments.number(f"bandwidth of {self.name}", self.bandwidth, low=1)
        arguments.number(f"latency_s of {self.name}", self.latency_s, low=0)
        arguments.number(f"overhead_s of {self.name}", self.overhead_s, low=0)
        arguments.flag(f"shared of {self.name}", self.shared)


def Myrinet() -> Network:
    """Return Myrinet of 2000: 2 Gb/s, 10 us (Boden et al. 1995 for the switch; Myricom's M3F cards)."""
    return Network("Myrinet", 2e9 / 8, 10e-6)


def FastEthernet() -> Network:
    """Return Fast Ethernet with TCP: 100 Mb/s, 60 us."""
    return Network("Fast Ethernet", 100e6 / 8, 60e-6)


def Modern() -> Network:
    """Return a network of today's clusters: 200 Gb/s, 1.5 us."""
    return Network("200 Gb/s", 200e9 / 8, 1.5e-6)


@dataclass(frozen=True)
class Node:
    """Machines of one kind.

    Attributes:
        name: of the kind.
        speed: relative to the machine on which the costs of work were measured.
        cores: of each machine.
        count: how many machines.
        ranks: started on each; None: one per core.
        sharing: part of its speed that each rank keeps while several are busy: they share memory and caches.
        networks: names of the networks to which it is connected; None: all.
        copy_bandwidth: bytes per second between two ranks of a machine.
    """

    name: str
    speed: float = 1.0
    cores: int = 1
    count: int = 1
    ranks: int | None = None
    sharing: float = 1.0
    """Part of its speed that each rank keeps while several are busy: they share memory and caches."""
    networks: tuple[str, ...] | None = None
    copy_bandwidth: float = 400e6
    """Bytes per second between two ranks of the node."""

    def __post_init__(self) -> None:
        """Check what was given."""
        arguments.number(f"speed of {self.name}", self.speed, low=1e-6)
        arguments.integer(f"cores of {self.name}", self.cores, low=1)
        arguments.integer(f"count of {self.name}", self.count, low=1)
        arguments.number(f"sharing of {self.name}", self.sharing, low=1e-3, high=1)
        arguments.number(f"copy_bandwidth of {self.name}", self.copy_bandwidth, low=1)
        if self.ranks is not None:
            arguments.integer(f"ranks of {self.name}", self.ranks, low=1)

    @property
    def started(self) -> int:
        """Ranks on each machine."""
        return self.cores if self.ranks is None else self.ranks

    @property
    def rank_speed(self) -> float:
        """Speed of each of its ranks while all of them work."""
        alone = self.speed if self.started == 1 else self.speed * self.sharing
        return alone * min(1.0, self.cores / self.started)


@dataclass(frozen=True)
class Cluster:
    """Nodes and the networks between them.

    Attributes:
        nodes: kinds of machines. Ranks go to them in their order: the first is the image generator's, the
            second the manager's (`roles="auto"`).
        network: one, or several, the preferred one first: two nodes talk over the first one that connects
            both.
    """

    nodes: Sequence[Node]
    network: Network | Sequence[Network] = field(default_factory=Modern)

    def __post_init__(self) -> None:
        """Check that the machines can talk to each other."""
        if not self.nodes:
            raise ArgumentError("nodes", self.nodes, "one Node at least")
        names = [node.name for node in self.nodes]
        if len(set(names)) < len(names):
            raise ArgumentError("nodes", names, "of different names, one per kind")
        known = {network.name for network in self.networks}
        for node in self.nodes:
            if node.networks is not None and not set(node.networks) <= known:
                raise ArgumentError(f"networks of {node.name}", node.networks, f"among {sorted(known)}")
        for a in self.nodes:
            for b in self.nodes:
                self.between(a, b)

    @property
    def networks(self) -> list[Network]:
        """All networks, the preferred one first."""
        return [self.network] if isinstance(self.network, Network) else list(self.network)

    @property
    def ranks(self) -> int:
        """Ranks on all machines."""
        return sum(node.count * node.started for node in self.nodes)

    def hosts(self) -> Iterator[tuple[str, Node]]:
        """Go through the machines in the order of ranks.

        Yields:
            Each one's name and kind.
        """
        for node in self.nodes:
            for number in range(node.count):
                yield f"{node.name}-{number}", node

    def between(self, a: Node, b: Node) -> Network:
        """Return the network over which two machines talk.

        Args:
            a: one machine's kind.
            b: the other's.
        """
        for network in self.networks:
            if all(node.networks is None or network.name in node.networks for node in (a, b)):
                return network
        raise ArgumentError("networks", [a.networks, b.networks], f"one of both {a.name} and {b.name}")


def described(path: Path) -> Cluster:
    """Run a file that says `cluster = motes.cluster.Cluster(...)`, and return that.

    Args:
        path: of the file.

    Raises:
        MotesError: if it is absent or says none.
    """
    if not path.is_file():
        raise MotesError(f"cluster file {path} does not exist")
    found = runpy.run_path(str(path)).get("cluster")
    if not isinstance(found, Cluster):
        raise MotesError(f"{path} must say `cluster = motes.cluster.Cluster(...)`")
    return found
