"""Replay the loads of an earlier run under another balancer: without MPI, with the same policies.

`predict` takes the tables of a recorded run, `predict_tasks` another code's load files; `Run.replay` calls
them. `synthetic` makes loads that isolate one effect each; `simulate` runs a recorded or synthetic history
under a balancer, frame by frame; `compare` compares several balancers.
"""

from .._interchange.task_loads import TaskLoads, load_files, read_task_loads
from .compare import candidates, compare, planning_ms
from .frames import Step, SystemStep, simulate
from .history import History, Recorded
from .loads import LOADS, Synthetic, synthetic
from .phases import Phases, predict_tasks
from .predict import predict
from .tables import Tables

__all__ = [
    "LOADS",
    "History",
    "Phases",
    "Recorded",
    "Step",
    "Synthetic",
    "SystemStep",
    "Tables",
    "TaskLoads",
    "candidates",
    "compare",
    "load_files",
    "planning_ms",
    "predict",
    "predict_tasks",
    "read_task_loads",
    "simulate",
    "synthetic",
]


def __dir__() -> list[str]:
    return [*__all__]
