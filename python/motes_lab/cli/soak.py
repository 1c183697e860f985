"""Test the engine's promises under thousands of failures, each repeatable from its seed.

  python -m motes soak disasters --seeds 10000
  python -m motes soak disasters --from 4711 --seeds 1        the same disaster once more
  bash .ci/asan python -m motes soak files --seeds 100000     in a checkout, with AddressSanitizer

disasters: small animations on simulated ranks (threads of one process; a scheduler draws which one runs next
and how long a message takes). Ranks die one by one or together, even while others recover; whole jobs are
killed and continue from checkpoints, some of them damaged, on other ranks. The promises: each frame has the
particles and the picture of an undisturbed run; a run that ends early gives a reason, and never because of a
single rank; no rank waits forever; damaged checkpoints are not used.

files: scenes, checkpoints and tables of a log, with bits flipped and bytes lost, doubled or exchanged.
Reading one must give an error or the original content.

Prints the seeds that broke a promise; exit code 1 if there are any.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from multiprocessing import get_context
from typing import Any

from motes.cli.parser import add_json, print_figures

__all__ = ["configure", "run"]

_CHUNK = 20  # seeds that a process takes at once
_TELL_S = 10.0

Case = Callable[[int], tuple[int, dict[str, Any]]]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `soak`."""
    parser.add_argument("what", metavar="WHAT", choices=["disasters", "files"], help="disasters or files")
    parser.add_argument("--seeds", type=int, default=1000, metavar="N", help="number of seeds (1000)")
    parser.add_argument(
        "--from", type=int, default=0, metavar="SEED", dest="first", help="the first seed (0)"
    )
    parser.add_argument("--jobs", type=int, default=None, metavar="N", help="processes (one per processor)")
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    """Run all seeds, and print which broke a promise."""
    with tempfile.TemporaryDirectory(prefix="motes-soak-") as directory:
        case = _disaster if args.what == "disasters" else partial(_damaged_file, directory)
        figures = _soak(args, case)
    print_figures(args, figures, _text(args.what, figures))
    return 1 if figures["broken"] else 0


def _soak(args: argparse.Namespace, case: Case) -> dict[str, Any]:
    start = last = time.monotonic()
    counts = Counter[str]()
    broken: dict[int, str] = {}
    jobs = args.jobs or len(os.sched_getaffinity(0))
    for done, (seed, happened) in enumerate(_all(case, range(args.first, args.first + args.seeds), jobs), 1):
        counts[happened.pop("kind")] += 1
        reason = happened.pop("broken")
        counts.update(happened)
        if reason:
            broken[seed] = reason
            print(f"seed {seed}: {reason}", file=sys.stderr, flush=True)
        if time.monotonic() - last > _TELL_S:
            last = time.monotonic()
            print(f"{done} of {args.seeds}, {len(broken)} broken", file=sys.stderr, flush=True)
    return {
        "seeds": args.seeds,
        "first": args.first,
        "broken": len(broken),
        "seeds_broken": sorted(broken),
        **dict(sorted(counts.items())),
        "seconds": round(time.monotonic() - start, 1),
    }


def _all(case: Case, seeds: range, jobs: int) -> Iterator[tuple[int, dict[str, Any]]]:
    if jobs == 1 or len(seeds) <= _CHUNK:
        yield from map(case, seeds)
        return
    # Not with fork, since the simulated ranks are threads.
    with get_context("spawn").Pool(jobs) as pool:
        yield from pool.imap(case, seeds, chunksize=_CHUNK)


def _disaster(seed: int) -> tuple[int, dict[str, Any]]:
    from .. import compiled

    happened = compiled.disaster(seed)
    del happened["ranks"]
    return seed, happened


def _damaged_file(directory: str, seed: int) -> tuple[int, dict[str, Any]]:
    from .. import compiled

    own = os.path.join(directory, str(os.getpid()))
    os.makedirs(own, exist_ok=True)
    return seed, compiled.damaged_file(seed, own)


def _text(what: str, figures: dict[str, Any]) -> str:
    counts = Counter({name: count for name, count in figures.items() if isinstance(count, int)})
    if what == "files":
        parts = [
            f"{counts['scenes']} scenes, {counts['parts']} parts and {counts['states']} states "
            f"of checkpoints, {counts['tables']} tables of logs",
            f"{counts['read']} were read without an error",
        ]
    else:
        parts = [
            f"{counts['losses']} with losses of ranks, {counts['restarts']} with restarts, "
            f"{counts['orders']} with neither",
            f"{counts['died']} ranks and jobs died; the run continued after {counts['survived']} of these",
            f"{counts['reported']} runs ended early and gave a reason",
        ]
    head = f"{figures['seeds']} {'damaged ' * (what == 'files')}{what} in {figures['seconds']:g} s"
    return f"{head}: " + "; ".join([*parts, f"{figures['broken']} broke a promise"])
