"""Machines and networks of a virtual cluster, as values."""

from __future__ import annotations

import runpy
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from motes.errors import ArgumentError, MotesError

from .._engine import arguments

__all__ = ["Cluster", "FastEthernet", "Modern", "Myrinet", "Network", "Node", "described"]


@dataclass(frozen=True)
class Network:
    """A switched network: each node has its own link, with full bandwidth in both directions at once.

    Attributes:
        name: of the network.
        bandwidth: bytes per second of a node's link, in one direction.
        latency_s: seconds from one node to another.
        overhead_s: processor seconds that a message takes at each end; the first network's value counts.
        shared: whether concurrent messages share their nodes' links. If not, messages do not affect each
            other, and the processors at both ends are busy with a message's bytes for as long as the link
            would be (the LogGP model, Alexandrov et al. 1995). That suits thousands of ranks, for which
            simulating shared links would take hours. The first network's value counts.
    """

    name: str
    bandwidth: float
    latency_s: float
    """Seconds from one node to another."""
    overhead_s: float = 0.0
    shared: bool = True
    """Whether concurrent messages share their nodes' links. If not, messages do not affect each other, and
    the processors at both ends are busy with a message's bytes for as long as the link would be (the LogGP
    model, Alexandrov et al. 1995). That suits thousands of ranks, for which simulating shared links would
    take hours. The first network's value counts."""

    def __post_init__(self) -> None:
        """Check the values."""
        arguments.number(f"bandwidth of {self.name}", self.bandwidth, low=1)
        arguments.number(f"latency_s of {self.name}", self.latency_s, low=0)
        arguments.number(f"overhead_s of {self.name}", self.overhead_s, low=0)
        arguments.flag(f"shared of {self.name}", self.shared)


def Myrinet() -> Network:
    """Return the Myrinet of 2000: 2 Gb/s, 10 us (Boden et al. 1995 for the switch; Myricom's M3F cards)."""
    return Network("Myrinet", 2e9 / 8, 10e-6)


def FastEthernet() -> Network:
    """Return Fast Ethernet with TCP: 100 Mb/s, 60 us."""
    return Network("Fast Ethernet", 100e6 / 8, 60e-6)


def Modern() -> Network:
    """Return a network of current clusters: 200 Gb/s, 1.5 us."""
    return Network("200 Gb/s", 200e9 / 8, 1.5e-6)


@dataclass(frozen=True)
class Node:
    """Machines of one kind.

    Attributes:
        name: of the kind.
        speed: relative to the machine on which the costs of work were measured.
        cores: per machine.
        count: number of machines.
        ranks: per machine; None: one per core.
        sharing: fraction of its speed that each rank keeps while others are busy, since they share memory and
            caches.
        networks: names of the networks to which the machines are connected; None: all.
        copy_bandwidth: bytes per second between two ranks of a machine.
    """

    name: str
    speed: float = 1.0
    cores: int = 1
    count: int = 1
    ranks: int | None = None
    sharing: float = 1.0
    """Fraction of its speed that each rank keeps while others are busy: they share memory and caches."""
    networks: tuple[str, ...] | None = None
    copy_bandwidth: float = 400e6
    """Bytes per second between two ranks of the node."""

    def __post_init__(self) -> None:
        """Check the values."""
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
        """Speed of each rank while all ranks of the machine work."""
        alone = self.speed if self.started == 1 else self.speed * self.sharing
        return alone * min(1.0, self.cores / self.started)


@dataclass(frozen=True)
class Cluster:
    """Nodes and the networks between them.

    Attributes:
        nodes: kinds of machines. Ranks are assigned in order: the first is the image generator, the second
            the manager (`roles="auto"`).
        network: one network or several, in order of preference: two nodes use the first one that connects
            both.
    """

    nodes: Sequence[Node]
    network: Network | Sequence[Network] = field(default_factory=Modern)

    def __post_init__(self) -> None:
        """Check that a network connects each pair of machines."""
        if not self.nodes:
            raise ArgumentError("nodes", self.nodes, "at least one Node")
        names = [node.name for node in self.nodes]
        if len(set(names)) < len(names):
            raise ArgumentError("nodes", names, "Nodes with different names, one per kind")
        known = {network.name for network in self.networks}
        for node in self.nodes:
            if node.networks is not None and not set(node.networks) <= known:
                raise ArgumentError(f"networks of {node.name}", node.networks, f"among {sorted(known)}")
        for a in self.nodes:
            for b in self.nodes:
                self.between(a, b)

    @property
    def networks(self) -> list[Network]:
        """All networks, in order of preference."""
        return [self.network] if isinstance(self.network, Network) else list(self.network)

    @property
    def ranks(self) -> int:
        """Number of ranks on all machines."""
        return sum(node.count * node.started for node in self.nodes)

    def hosts(self) -> Iterator[tuple[str, Node]]:
        """Iterate over the machines in the order of ranks.

        Yields:
            The name and the kind of each machine.
        """
        for node in self.nodes:
            for number in range(node.count):
                yield f"{node.name}-{number}", node

    def between(self, a: Node, b: Node) -> Network:
        """Return the network that two machines use.

        Args:
            a: kind of one machine.
            b: kind of the other.
        """
        for network in self.networks:
            if all(node.networks is None or network.name in node.networks for node in (a, b)):
                return network
        raise ArgumentError(
            "networks", [a.networks, b.networks], f"such that one connects {a.name} and {b.name}"
        )


def described(path: Path) -> Cluster:
    """Run a file that sets `cluster = motes.cluster.Cluster(...)`, and return the cluster.

    Args:
        path: of the file.

    Raises:
        MotesError: if the file is absent or sets no cluster.
    """
    if not path.is_file():
        raise MotesError(f"cluster file {path} does not exist")
    found = runpy.run_path(str(path)).get("cluster")
    if not isinstance(found, Cluster):
        raise MotesError(f"{path} must set `cluster = motes.cluster.Cluster(...)`")
    return found
