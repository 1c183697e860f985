"""Virtual clusters: machines and networks simulated by SimGrid."""

from .machines import Cluster, FastEthernet, Modern, Myrinet, Network, Node
from .simulate import migrant_s, simulate

__all__ = ["Cluster", "FastEthernet", "Modern", "Myrinet", "Network", "Node", "migrant_s", "simulate"]


def __dir__() -> list[str]:
    return [*__all__]
