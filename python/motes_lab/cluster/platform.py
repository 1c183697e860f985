"""Writes a cluster for SimGrid: the platform (hosts, links, routes) and the host of each rank."""

from __future__ import annotations

from xml.sax.saxutils import quoteattr

from .machines import Cluster, Network, Node

__all__ = ["hosts", "platform"]

HEAD = """<?xml version="1.0"?>
<!DOCTYPE platform SYSTEM "https://simgrid.org/simgrid.dtd">
<platform version="4.1">
"""

OPERATIONS = 1e9
"""Operations per second of a machine of speed 1 in the simulator: one operation takes a nanosecond."""


def platform(cluster: Cluster) -> str:
    """Return the platform file (XML)."""
    if len(cluster.nodes) == 1 and len(cluster.networks) == 1:
        return HEAD + _uniform(cluster.nodes[0], cluster.networks[0]) + "</platform>\n"
    machines = list(cluster.hosts())
    lines = [HEAD + '<zone id="cluster" routing="Full">']
    for name, node in machines:
        facts = f"id={quoteattr(name)} speed={quoteattr(f'{node.rank_speed * OPERATIONS!r}f')}"
        lines.append(f'<host {facts} core="{node.started}"/>')
        lines.append(_link(f"memory {name}", node.copy_bandwidth, 0.0, "FATPIPE"))
        for network in cluster.networks:
            if node.networks is None or network.name in node.networks:
                half = network.latency_s / 2
                lines.append(_link(_port(network, name), network.bandwidth, half, _sharing(network)))
    for i, (source, a) in enumerate(machines):
        lines.append(_route(source, source, [f"<link_ctn id={quoteattr(f'memory {source}')}/>"]))
        for target, b in machines[i + 1 :]:
            network = cluster.between(a, b)
            ends = (source, "UP"), (target, "DOWN")
            links = [_end(network, name, way) for name, way in ends]
            lines.append(_route(source, target, links))
    return "\n".join([*lines, "</zone></platform>", ""])


def _uniform(node: Node, network: Network) -> str:
    """Return a short description of machines of one kind: thousands of them would have millions of routes."""
    facts = {
        **{"id": "cluster", "prefix": f"{node.name}-", "suffix": "", "radical": f"0-{node.count - 1}"},
        **{"speed": f"{node.rank_speed * OPERATIONS!r}f", "core": str(node.started)},
        **{"bw": f"{network.bandwidth!r}Bps", "lat": f"{network.latency_s / 2!r}s"},
        **{
            "sharing_policy": _sharing(network),
            "loopback_bw": f"{node.copy_bandwidth!r}Bps",
            "loopback_lat": "0s",
        },
    }
    return f"<cluster {' '.join(f'{name}={quoteattr(value)}' for name, value in facts.items())}/>\n"


def hosts(cluster: Cluster) -> str:
    """Return the host file: one line per rank."""
    return "".join(f"{name}\n" * node.started for name, node in cluster.hosts())


def _port(network: Network, host: str) -> str:
    return f"{network.name} {host}"


def _sharing(network: Network) -> str:
    return "SPLITDUPLEX" if network.shared else "FATPIPE"


def _end(network: Network, host: str, way: str) -> str:
    direction = f" direction={quoteattr(way)}" if network.shared else ""
    return f"<link_ctn id={quoteattr(_port(network, host))}{direction}/>"


def _link(name: str, bandwidth: float, latency_s: float, sharing: str) -> str:
    return (
        f"<link id={quoteattr(name)} bandwidth={quoteattr(f'{bandwidth!r}Bps')} "
        f"latency={quoteattr(f'{latency_s!r}s')} sharing_policy={quoteattr(sharing)}/>"
    )


def _route(source: str, target: str, links: list[str]) -> str:
    return f"<route src={quoteattr(source)} dst={quoteattr(target)}>{''.join(links)}</route>"
