"""What another balancer would have done with the loads of an earlier run: no MPI, the same policies.

`predict` takes the tables of a recorded run; `Run.replay` calls it for a log. `synthetic` makes loads that
each show one effect; `simulate` runs a history, recorded or synthetic, under a balancer, frame by frame;
`compare` puts several balancers side by side.
"""

from .compare import candidates, compare, planning_ms
from .frames import Step, SystemStep, simulate
from .history import History, Recorded, Tables
from .loads import LOADS, Synthetic, synthetic
from .predict import predict

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
