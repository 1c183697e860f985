"""The paper's experiments on a virtual copy of its cluster, with separate runs for each cell of a table."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from ..._engine import extras
from ..build import find_replay, find_smpirun
from ..machines import Cluster
from ..simulate import record, simulate
from .model import FOLDER, alone, balancer, cluster, costs, fitted, model, scale
from .tables import Cell, cells

__all__ = ["Row", "measure", "reproduce"]

_PAPER = ("--blocking", "--births", "manager", "--balancer")
_OURS = ("--births", "manager", "--balancer", "PrefixCuts", "--combine", "together")
_ALL = (*_OURS[:3], "PrefixCuts(threshold=0.03,min_particles=8)", *_OURS[4:], "--roles", "all")
BEST = (_OURS, (*_OURS, "--path", "tiles", "--roles", "shared"), _ALL)
"""Options of our runs, of which the fastest counts: the paper's roles; all processes calculate and draw; all
calculate, while one also draws and another also manages."""


@dataclass(frozen=True)
class Row:
    """A cell: the paper's speed-up, ours with the paper's policy and protocol, and ours at its best."""

    cell: Cell
    ours: float
    best: float

    @property
    def error(self) -> float:
        """Relative error of the paper's policy on the virtual cluster, compared with the paper."""
        return self.ours / self.cell.speedup - 1

    @property
    def fitted(self) -> bool:
        """Whether the model was fitted to this cell."""
        return fitted(self.cell)


def reproduce(table: int, jobs: int = 2) -> list[Row]:
    """Run a whole table; `jobs` simulations at a time."""
    return measure(cells(table), jobs)


def measure(wanted: list[Cell], jobs: int = 2) -> list[Row]:
    """Run any cells; `jobs` simulations at a time."""
    find_smpirun(), find_replay(), extras.pandas()  # raise before minutes of work
    with tempfile.TemporaryDirectory(prefix="motes-paper-") as folder, ThreadPoolExecutor(jobs) as pool:
        bench = _Bench(Path(folder), pool)
        bench.record({(cell.experiment, cell.finite) for cell in wanted})
        try:
            return bench.rows(wanted)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


class _Bench:
    """Scenes, costs and runs of one table; a run that several cells need is made once."""

    def __init__(self, folder: Path, pool: ThreadPoolExecutor) -> None:
        self._folder = folder
        self._pool = pool
        self._runs: dict[tuple[object, ...], Future[float]] = {}
        for program in ("paper", "motes"):
            (folder / f"{program}.costs").write_text(costs(program))

    def record(self, scenes: Iterable[tuple[str, bool]]) -> None:
        """Record scenes, each given as its experiment and whether the space is finite."""
        size = model()["scale"]
        fixed = [f"--{name}={size[name]}" for name in ("systems", "particles", "frames")]
        for experiment, finite in scenes:
            own = dict(model()["scene"][experiment])
            space = own.pop("space")
            options = [*fixed, f"--space={space if finite else 'infinite'}"]
            options += [f"--{name}={value}" for name, value in own.items()]
            record(self._scene(experiment, finite), FOLDER / f"{experiment}.py", options)

    def rows(self, wanted: list[Cell]) -> list[Row]:
        """Run all cells."""
        started = [(cell, self._sequential(cell), self._paper(cell), self._best(cell)) for cell in wanted]
        made = []
        for cell, sequential, paper, best in started:
            whole = sequential.result() * alone(cell)[1]
            fastest = min(one.result() for one in best)
            made.append(Row(cell, whole / paper.result(), whole / fastest))
        return made

    def _sequential(self, cell: Cell) -> Future[float]:
        machine, _ = alone(cell)
        return self._frame_s(cell, True, machine, "paper", ())

    def _paper(self, cell: Cell) -> Future[float]:
        policy = balancer() if cell.dynamic else "Static"
        return self._frame_s(cell, cell.finite, cluster(cell), "paper", (*_PAPER, policy))

    def _best(self, cell: Cell) -> list[Future[float]]:
        return [self._frame_s(cell, cell.finite, cluster(cell), "motes", options) for options in BEST]

    def _frame_s(
        self, cell: Cell, finite: bool, machines: Cluster, program: str, options: tuple[str, ...]
    ) -> Future[float]:
        """Return the simulated seconds per frame, over the measured frames."""
        key = (cell.experiment, finite, repr(machines), program, options)
        if key not in self._runs:
            log = self._folder / f"run-{len(self._runs)}"
            work = (self._scene(cell.experiment, finite), machines, log, program, options)
            self._runs[key] = self._pool.submit(self._run, *work)
        return self._runs[key]

    def _run(
        self, scene: Path, machines: Cluster, log: Path, program: str, options: tuple[str, ...]
    ) -> float:
        run = simulate(
            scene,
            machines,
            log=log,
            costs=self._folder / f"{program}.costs",
            scale=scale(),
            options=options,
        )
        return float(run.frames["t_frame_s"].iloc[-model()["scale"]["measured"] :].mean())

    def _scene(self, experiment: str, finite: bool) -> Path:
        return self._folder / f"{experiment}-{'finite' if finite else 'infinite'}.motes"
