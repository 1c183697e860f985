"""Replay the loads of an earlier run under another balancer: without MPI, with the same policies.

`predict` takes the tables of a recorded run; `Run.replay` calls it for a log. `synthetic` makes loads that
isolate one effect each; `simulate` runs a recorded or synthetic history under a balancer, frame by frame;
`compare` compares several balancers.
"""

from .compare import candidates, compare, planning_ms
from .frames import Step, SystemStep, simulate
from .history import History, Recorded
from .loads import LOADS, Synthetic, synthetic
from .predict import predict
from .tables import Tables

__all__ = [
    "LOADS",
    "History",
    "Recorded",
    "Step",
    "Synthetic",
    "SystemStep",
    "Tables",
    "candidates",
    "compare",
    "planning_ms",
    "predict",
    "simulate",
    "synthetic",
]


def __dir__() -> list[str]:
    return [*__all__]
