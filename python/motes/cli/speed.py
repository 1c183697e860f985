"""Measures how fast a host's ranks act on particles, all at the same time, for `doctor --hosts`.

`python -m motes.cli.speed RANKS` prints one JSON object.
"""

from __future__ import annotations

import contextlib
import importlib.metadata
import json
import os
import platform
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import MotesError

if TYPE_CHECKING:
    import motes

__all__ = ["main", "version"]

_PARTICLES = 1 << 17
_MEASURE_S = 2.0
_RANK = "rank"


def main() -> None:
    """Print the speeds of this host; as a rank, measure one."""
    try:
        told = _of_this_rank() if sys.argv[1:] == [_RANK] else _of_this_host(int(sys.argv[1]))
    except MotesError as error:
        sys.exit(str(error))
    print(json.dumps(told), flush=True)


def version() -> str | None:
    """Return the version of motes, or None where it is not installed as a package."""
    with contextlib.suppress(importlib.metadata.PackageNotFoundError):
        return importlib.metadata.version("motes")
    return None


def _processor() -> str:
    """Return the processor's name, or the architecture where the system does not tell."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, platform.machine())


def _of_this_host(ranks: int) -> dict[str, Any]:
    from motes._launch.starting import library
    from motes._run.threads import Place, most_threads, processors, threads_of
    from motes._values import environment

    place = Place("", processors(), environment.threads(None) or 0, most_threads())
    threads = threads_of([place] * ranks)[0]
    speeds, simd = _speeds(ranks, threads)
    return {
        "motes": version(),
        "mpi": str(library()),
        "processor": _processor(),
        "simd": simd,
        "threads": threads,
        "particles_per_s": sum(speeds) / ranks,
    }


def _speeds(ranks: int, threads: int) -> tuple[list[float], str]:
    """Measure as many processes as ranks, all at once; return their speeds and the instruction set."""
    variables = {
        "MOTES_THREADS": str(threads),
        "MOTES_ALONE": "1",
        "MOTES_PROGRESS": "off",
        "MOTES_LIVE": "off",
    }
    children = [
        subprocess.Popen(
            [sys.executable, "-m", "motes.cli.speed", _RANK],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, **variables},
        )
        for _ in range(ranks)
    ]
    for child in children:
        assert child.stdout is not None
        child.stdout.readline()  # it is ready, or has failed
    for child in children:
        assert child.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            child.stdin.write("go\n")
            child.stdin.flush()
    told = [child.communicate()[0] for child in children]
    if any(child.returncode for child in children):
        sys.exit(1)  # its error has been printed
    found = [json.loads(text) for text in told]
    return [one["speed"] for one in found], found[0]["simd"]


def _of_this_rank() -> dict[str, Any]:
    """Time frames of falling particles, from a line on standard input on."""
    import motes
    from motes import _core, shapes

    world = motes.World(seed=1)
    snow = world.system("snow")
    with world:
        snow.burst(shapes.Box((-9, 1, -9), (9, 9, 9)), count=_PARTICLES)
        for _ in range(3):  # the first frames also reserve memory
            _fall(world, snow)
        print("ready", flush=True)
        sys.stdin.readline()
        frames, start, seconds = 0, time.perf_counter(), 0.0
        while seconds < _MEASURE_S:
            _fall(world, snow)
            frames += 1
            seconds = time.perf_counter() - start
    return {"speed": _PARTICLES * frames / seconds, "simd": _core.simd()}


def _fall(world: motes.World, snow: motes.System) -> None:
    from motes import shapes

    snow.gravity((0, -1, 0))
    snow.random_acceleration(shapes.Box((-1, -1, -1), (1, 1, 1)))
    snow.curl_noise(0.5, 2.0)
    snow.bounce(shapes.Plane((0, 0, 0), (0, 1, 0)), restitution=0.9)
    snow.bounce(shapes.Sphere((0, 1, 0), 1))
    snow.move()
    world.step()


if __name__ == "__main__":
    main()
