"""Measures the cost of balancing when there is nothing to balance: one rank of `bench overhead`.

Worlds that differ only in their balancer run in one job and take turns of a few frames, so other programs
affect all of them. All figures, for the frame and its phases, are the static world's median over the rounds
plus the median difference to it within a round. A second static world shows how accurate they are.
"""

from __future__ import annotations

import argparse
import json
import statistics
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from typing import Any

from mpi4py import MPI

from motes import World
from motes.balance import Balancer, Diffusive, Pairwise, PrefixCuts, Proportional, Static
from motes.shapes import Box, Sphere

from .snow import Snow

__all__ = ["main"]

PHASES = ("create", "act", "report", "exchange", "balance", "wait")
SNOW = Snow(
    depth=10,
    velocity=Box((-0.3, -1.4, -0.3), (0.4, -1.2, 0.3)),
    gusts=Sphere((0, 0, 0), 1),
    obstacles=(Box((-4, 0, -3), (4, 3, 3)), Sphere((10, 1, 0), 1)),
)
WARM = 16  # frames that do not count, in which balancers learn the machine's speed


class Lane:
    """One running world, and the times of its frames on this rank."""

    def __init__(self, balancer: Balancer, systems: int, particles: int, frames: int) -> None:
        """Make a world of the paper's snow, whose load is equal on all calculators."""
        self.world = World(seed=1, space=(-30, 30), balancer=balancer, progress="off")
        self.layers = [self.world.system(f"snow {i}", capacity=2 * particles) for i in range(systems)]
        self.particles = particles
        self.frames: Iterator[int] = iter(self.world.frames(frames))
        self.times: list[dict[str, float]] = []

    def run(self, count: int) -> None:
        """Compute `count` frames."""
        for _ in range(count):
            frame = next(self.frames)
            for snow in self.layers:
                SNOW.record(snow, frame, self.particles)
            self.world.step()
            self.times.append(self.world.timings)


def _balancers(calculators: int) -> dict[str, Balancer]:
    return {
        "static": Static(),
        "static again": Static(),
        "pairwise": Pairwise(),
        "diffusive": Diffusive(),
        "prefix": PrefixCuts(),
        "proportional": Proportional([1.0] * calculators),
    }


def _job(arguments: argparse.Namespace) -> dict[str, Any]:
    """Run all worlds in turn and return the figures."""
    comm = MPI.COMM_WORLD
    total = WARM + arguments.rounds * arguments.frames
    sizes = (arguments.systems, arguments.particles, total + 1)
    with ExitStack() as stack:
        calculators = len(World(seed=1, progress="off").calculators)
        lanes = {name: Lane(balancer, *sizes) for name, balancer in _balancers(calculators).items()}
        for lane in lanes.values():
            stack.enter_context(lane.world)
            lane.run(WARM)
            lane.times.clear()
        seconds: dict[str, list[float]] = {name: [] for name in lanes}
        for number in range(arguments.rounds):
            names = list(lanes) if number % 2 else list(reversed(lanes))
            for name in names:
                comm.Barrier()
                start = MPI.Wtime()
                lanes[name].run(arguments.frames)
                comm.Barrier()
                seconds[name].append((MPI.Wtime() - start) / arguments.frames)
        return _figures(arguments, lanes, seconds)


def _figures(
    arguments: argparse.Namespace, lanes: dict[str, Lane], seconds: dict[str, list[float]]
) -> dict[str, Any]:
    comm = MPI.COMM_WORLD
    calculators = lanes["static"].world.calculators
    mine = {name: _by_round(lane.times, arguments.frames) for name, lane in lanes.items()}
    everywhere = [one for rank, one in enumerate(comm.allgather(mine)) if rank in calculators]
    rows = []
    for name in lanes:
        phases = {
            phase: _beside(*(_mean([one[which][phase] for one in everywhere]) for which in (name, "static")))
            for phase in PHASES
        }
        frame, static = _beside(seconds[name], seconds["static"]), statistics.median(seconds["static"])
        rows.append(
            {
                "balancer": name,
                "frame_ms": 1e3 * frame,
                "overhead_percent": 100 * (frame / static - 1),
                **{f"{phase}_ms": 1e3 * value for phase, value in phases.items()},
            }
        )
    return {
        "ranks": comm.size,
        "calculators": len(calculators),
        **{name: getattr(arguments, name) for name in ("systems", "particles", "rounds", "frames")},
        "rows": rows,
    }


def _by_round(times: Sequence[Mapping[str, float]], frames: int) -> dict[str, list[float]]:
    """Average each phase over the frames of each round: seconds per frame, one value per round."""
    rounds = [times[start : start + frames] for start in range(0, len(times), frames)]
    return {p: [statistics.fmean(one[f"t_{p}_s"] for one in each) for each in rounds] for p in PHASES}


def _mean(values: Sequence[Sequence[float]]) -> list[float]:
    """Average over calculators, round by round."""
    return [statistics.fmean(each) for each in zip(*values, strict=True)]


def _beside(values: Sequence[float], static: Sequence[float]) -> float:
    """Return the median of the static world's rounds plus the median difference to it within a round."""
    differences = [a - b for a, b in zip(values, static, strict=True)]
    return statistics.median(static) + statistics.median(differences)


def main(argv: Sequence[str] | None = None) -> None:
    """Run one rank of the job."""
    parser = argparse.ArgumentParser(prog="python -m motes_lab.bench.overhead")
    for name in ("systems", "particles", "rounds", "frames"):
        parser.add_argument(f"--{name}", type=int, required=True)
    figures = _job(parser.parse_args(argv))
    if MPI.COMM_WORLD.rank == 0:
        print(json.dumps(figures), flush=True)


if __name__ == "__main__":
    main()
