"""Balancers play workloads on machines and are scored against the best cuts: `python -m motes arena`."""

from .machines import MACHINES, Machine, machine
from .score import Score, Track
from .table import league, rows, text

__all__ = ["MACHINES", "Machine", "Score", "Track", "league", "machine", "rows", "text"]


def __dir__() -> list[str]:
    return [*__all__]
