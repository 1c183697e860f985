"""Play on real ranks: one job runs a world per balancer, one after another, and prints one JSON object."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from motes.replay.density import Density

from ..bench.jobs import figures_of
from ..workloads import Planned, Workload, workload
from .players import player
from .score import Bounds, Score, scored

__all__ = ["play"]

PASSES = 8
"""Passes of synthetic work over all particles per frame, on a machine at full speed."""


def play(
    name: str, balancers: Sequence[str], ranks: int, *, frames: int, cells: int, particles: int
) -> list[Score]:
    """Start a job on real ranks, all of them calculators, and score each balancer.

    The optimum is computed from each rank's undisturbed speed, its mean over all balancers. Seconds are the
    time of the actions on the slowest rank in each frame.

    Args:
        name: the workload's name.
        balancers: balancers as text for `player`.
        ranks: number of ranks.
        frames: number of frames per balancer.
        cells: number of the workload's cells.
        particles: total number of particles.

    Raises:
        MotesError: if the job fails, with its errors.
    """
    sizes = {"frames": frames, "cells": cells, "particles": particles}
    played = {"workload": name, "sizes": sizes, "balancers": list(balancers)}
    figures = figures_of(__name__, ranks, [json.dumps(played)])
    game = workload(name, **sizes)
    processed = np.sum([row["processed"] for row in figures["rows"]], axis=0)
    parts = np.array([game.slowdown(frame, ranks) for frame in range(frames)])
    undisturbed_s = np.sum([parts * row["act_s"] for row in figures["rows"]], axis=(0, 1))
    bounds = Bounds(game, np.maximum(processed, 1) / np.maximum(undisturbed_s, 1e-9))
    return [
        scored(
            f"{ranks} ranks",
            text,
            np.max(row["act_s"], axis=1).tolist(),
            bounds,
            moved=row["moved"],
            verified=row["verified"],
            digest=row["digest"],
        )
        for text, row in zip(balancers, figures["rows"], strict=True)
    ]


def main(played: str) -> None:
    """Play all balancers on this rank; rank 0 prints the figures. `played` is the JSON built by `play`."""
    given = json.loads(played)
    game = workload(given["workload"], **given["sizes"])
    rows = [_played(game, text) for text in given["balancers"]]
    if rows[0] is not None:
        print(json.dumps({"rows": rows}), flush=True)


def _played(game: Workload, text: str) -> dict[str, Any] | None:
    """Run a world under one balancer; return the figures on rank 0, None elsewhere."""
    from mpi4py import MPI

    import motes

    comm = MPI.COMM_WORLD
    balancer = player(text, [1.0] * comm.size)
    world = motes.World(**game.world, balancer=balancer, roles="shared", progress="off", threads=1)
    system = world.system("particles")
    cuts, act_s = [], []
    with world:
        for frame in world.frames(game.frames):
            game.step(system, frame)
            if game.disturbed:
                slowness = 1 / game.slowdown(frame, comm.size)[comm.rank]
                system.callback(_work(PASSES * slowness))
            cuts.append(np.array(system.cuts))
            world.step()
            act_s.append(world.timings["t_act_s"])
        particles = system.gather()
        verified = game.verify(particles, game.frames) if particles else True
        digest = world.digest()
    every = comm.gather(act_s)
    if every is None:
        return None
    moved, processed = _moves(game, cuts, comm.size)
    return {
        "act_s": np.transpose(every).tolist(),
        "processed": processed,
        "moved": moved,
        "verified": verified,
        "digest": digest,
    }


def _work(passes: float) -> Callable[[Any], None]:
    """Return a callback that makes this many passes of synthetic work over all particles."""

    def work(particles: Any) -> None:
        x = np.array(particles.position[:, 0])
        for begun in range(math.ceil(passes)):
            some = x[: round(len(x) * min(passes - begun, 1.0))]
            np.sqrt(some * some + 1.0, out=some)

    return work


def _moves(game: Workload, cuts: Sequence[Any], ranks: int) -> tuple[int, list[int]]:
    """Return how many particles new cuts moved to other ranks, and how many each rank acted on."""
    history, moved, processed = Planned(game, np.ones(ranks)), 0, np.zeros(ranks, np.int64)
    before = None
    for frame, now in enumerate(cuts):
        density = history.moment(frame, 0).density
        if before is not None and isinstance(density, Density):
            source, to, n = density.overlaps(before, now)
            moved += round(float(n[source != to].sum()))
        ends = [
            0,
            *np.searchsorted(np.arange(game.cells) + 0.5, now if before is None else before),
            game.cells,
        ]
        below = np.concatenate([[0], np.cumsum(game.acting(frame))])
        processed += np.diff(below[ends])
        before = now
    return moved, processed.tolist()


if __name__ == "__main__":
    main(sys.argv[1])
