"""The model of the paper's cluster and programs: `model.toml`, and values derived from it."""

from __future__ import annotations

import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

from ..machines import Cluster, FastEthernet, Myrinet, Node
from .tables import Cell

__all__ = ["WITHIN", "alone", "balancer", "cluster", "costs", "fitted", "model", "scale"]

FOLDER = Path(__file__).parent
WITHIN = {1: 0.2, 2: 0.3, 3: 0.2}
"""Largest relative error that counts as near the paper, by table."""
NETWORKS = {"myrinet": Myrinet, "fast-ethernet": FastEthernet}


@cache
def model() -> dict[str, Any]:
    """Read model.toml."""
    return tomllib.loads((FOLDER / "model.toml").read_text())


def fitted(cell: Cell) -> bool:
    """Return whether the model's parameters were fitted to this cell; other cells are predictions."""
    return f"{cell.nodes} {cell.variant}" in model()["fitted"].get(str(cell.table), ())


def scale() -> float:
    """Return how many of the paper's particles each computed one stands for."""
    return float(model()["scale"]["paper_particles"] / model()["scale"]["particles"])


def costs(program: str) -> str:
    """Return the costs of the paper's program ("paper") or of this one ("motes"), as text for the engine."""
    return "".join(f"{name} = {value}\n" for name, value in model()["costs"][program].items())


def balancer() -> str:
    """Return the paper's dynamic balancer with its free parameters, as an option of motes_replay."""
    own = model()["balancer"]
    return f"Pairwise(threshold={own['threshold']}, min_particles={round(own['min_particles'] / scale())})"


def cluster(cell: Cell) -> Cluster:
    """Return a row's machines: "8*B" with 16 processes, or "4*B(8)+2*C(2)"."""
    nodes = []
    for term in cell.hosts.split("+"):
        found = re.fullmatch(r"(\d+)\*([ABC])(?:\((\d+)\))?", term)
        assert found is not None, term
        count, ranks = int(found[1]), int(found[3] or cell.processes)
        nodes.append(_node(found[2], cell.compiler, count, ranks // count))
    return Cluster(nodes, NETWORKS[cell.network]())


def alone(cell: Cell) -> tuple[Cluster, float]:
    """Return the machine of the sequential run, and the factor for its time."""
    own = model()["baseline"][cell.compiler]
    return Cluster([_node(own["node"], cell.compiler, 1, 1)], NETWORKS[cell.network]()), float(own["factor"])


def _node(kind: str, compiler: str, count: int, ranks: int) -> Node:
    own = model()["nodes"][compiler][kind]
    cores = 1 if kind == "C" else 2
    return Node(kind, own["speed"], cores, count, ranks=ranks, sharing=own["sharing"])
