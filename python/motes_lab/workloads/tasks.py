"""A workload from load files of vt and LBAF: tasks that another code measured."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import numpy.typing as npt

from motes.errors import ArgumentError
from motes.replay import Phases, load_files, read_task_loads
from motes.replay.phases import counts, fixed_s

from .._engine import arguments
from .base import Counts, Floats, Workload

__all__ = ["Tasks"]


class Tasks(Workload):
    """Tasks of another code in a row of cells, one task in each; its phases are frames.

    A task is as many particles as it takes `particle_s` seconds on a machine of speed 1. It plays on virtual
    machines only; there, moving a task costs its messages.

    Attributes:
        loads: what the files say.
        particle_s: seconds of a particle on a machine of speed 1.
        ranks: number of files.
    """

    def __init__(self, path: str | os.PathLike[str], *, frames: int | None = None) -> None:
        """Read the files.

        Args:
            path: their directory; DIRECTORY/NAME if it has files of several names; or one of them.
            frames: number of phases; the last one of the files is repeated if they have fewer. None: theirs.

        Raises:
            ArgumentError: if there are no load files.
            LogError: if a file is damaged, naming the field.
        """
        files = load_files(Path(path))
        if not files:
            raise ArgumentError("workload", os.fspath(path), "a directory of load files, NAME.RANK.json")
        self.loads = read_task_loads(files)
        if frames is not None:
            self.loads = self.loads.lasting(arguments.integer("frames", frames, low=1, high=10**6))
        self._counts = [counts(self.loads, k) for k in range(len(self.loads.phases))]
        self.name, self.frames, self.cells = self.loads.name, len(self.loads.phases), len(self.loads.first)
        self.particles = max(int(one.sum()) for one in self._counts)
        self.particle_s, self.ranks = self.loads.particle_s, self.loads.ranks
        if not self.particles:
            raise ArgumentError(
                "workload", os.fspath(path), "files with tasks that can migrate and take time"
            )

    def born(self, frame: int) -> Counts | None:
        """Refuse to give births to a script: the work of tasks changes without any.

        Args:
            frame: frame index, from 0.

        Returns:
            Never: it raises ArgumentError.
        """
        raise ArgumentError(
            "workload", self.name, "a made load on real ranks; load files need virtual machines"
        )

    def acting(self, frame: int) -> Counts:
        """Return the particles of each task in a phase, int64 (tasks,).

        Args:
            frame: index of the phase.
        """
        return self._counts[frame]

    def counts(self, frame: int) -> Counts:
        """Return the same as `acting`: tasks move between phases.

        Args:
            frame: index of the phase.
        """
        return self._counts[frame]

    def fixed_s(self, frame: int, speeds: npt.ArrayLike) -> Floats:
        """Return the seconds of each rank's tasks that cannot migrate, (calculators,).

        Args:
            frame: index of the phase.
            speeds: particles per second of each calculator.
        """
        return fixed_s(self.loads, frame, np.asarray(speeds, np.float64))

    def history(self, speeds: npt.ArrayLike) -> Phases:
        """Return the tasks as a history for `motes.replay.simulate`.

        Args:
            speeds: particles per second of each calculator.
        """
        return Phases(self.loads, speeds)
