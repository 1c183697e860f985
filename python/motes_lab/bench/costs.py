"""Measures the constants of cpp/engine/render/render_costs.h: `python -m motes bench costs`.

One core projects, draws, tone-maps and merges; two ranks exchange messages with the engine's MPI calls. From
the constants in that file the manager estimates the cost of a picture on each path.
"""

from __future__ import annotations

import json
import statistics
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from .. import compiled
from .jobs import figures_of

__all__ = ["costs", "main"]

SMALL, LARGE = 64, 8_000_000
"""Bytes of messages: small ones measure the cost per message, large ones the cost per byte."""
MESSAGES = {SMALL: 500, LARGE: 8}


def costs(*, particles: int, size: tuple[int, int], repeats: int) -> dict[str, Any]:
    """Measure all constants, in nanoseconds of processor time."""
    picture = compiled.picture_bench(particles, *size, repeats)
    rounds = [figures_of("motes_lab.bench.costs", 2, []) for _ in range(repeats)]
    small, large = (statistics.median(one[str(length)] for one in rounds) for length in (SMALL, LARGE))
    return {
        "particles": particles,
        "width": size[0],
        "height": size[1],
        "repeats": repeats,
        "kProject": picture["project_ns"],
        "record of 5 pixels": picture["record_ns"],
        "kPixel": picture["pixel_ns"],
        "kBloomPixel": picture["bloom_pixel_ns"],
        "kSpreadPixel": picture["spread_pixel_ns"],
        "kPartialPixel": picture["partial_pixel_ns"],
        "kByte": max(0.0, large - small) / (LARGE - SMALL),
        "kMessage": small,
    }


def _talk(length: int, count: int) -> float:
    """Return the seconds of processor time per message on each side: pack, send, receive into new memory.

    Waits do not count: a rank sleeps between polls, and only successful polls are timed.
    """
    from mpi4py import MPI

    world = MPI.COMM_WORLD
    other = 1 - world.Get_rank()
    content = bytearray(length)
    spent = 0.0
    for _ in range(count):
        world.Barrier()
        start = time.process_time()
        packed = bytearray(content)
        sending = world.Isend([packed, MPI.BYTE], dest=other)
        spent += time.process_time() - start
        status = MPI.Status()
        message, took = _answer(partial(world.Improbe, source=other, status=status))
        spent += took
        start = time.process_time()
        into = bytearray(status.Get_count(MPI.BYTE))
        receiving = message.Irecv([into, MPI.BYTE])
        spent += time.process_time() - start
        spent += _answer(receiving.Test)[1] + _answer(sending.Test)[1]
    return spent / count / 2  # each rank was at both ends


def _answer(ask: Callable[[], Any]) -> tuple[Any, float]:
    """Poll until `ask` returns neither None nor False; return its answer and the seconds of the last poll."""
    while True:
        start = time.process_time()
        answer = ask()
        took = time.process_time() - start
        if answer:
            return answer, took
        time.sleep(0.0002)


def main() -> None:
    """Run one rank of a job."""
    from mpi4py import MPI

    figures = {}
    for length, count in MESSAGES.items():
        _talk(length, 5)
        everyone = MPI.COMM_WORLD.gather(_talk(length, count), root=0)
        figures[length] = 1e9 * statistics.mean(everyone or [0.0])
    if MPI.COMM_WORLD.Get_rank() == 0:
        print(json.dumps(figures), flush=True)


if __name__ == "__main__":
    main()
