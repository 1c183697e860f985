"""Continue a run with another number of ranks, or on other hosts.

  python -m motes resize out/run -n 8
  python -m motes resize out/run -n 16 --hosts node1:8,node3:8

RUN is the directory of its log. The run must have been started by `motes run`, and its world needs
World(checkpoint=...). It ends at the next border between two frames, with a checkpoint, and goes on from
there in the same log, film and export, with the same particles and pictures. Call this on the host of
`motes run`.

SIGUSR2 to `motes run` does the same with as many ranks as before, for example on a host file that has
changed.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from .._io.output import tell
from .._launch.hosts import check_names
from .._launch.resizing import Size, request
from .parser import positive

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `resize`."""
    parser.add_argument("run", metavar="RUN", help="the directory of the run's log")
    parser.add_argument(
        "-n", "-np", "--ranks", type=positive, required=True, metavar="N", help="the new number of ranks"
    )
    parser.add_argument("--hosts", help="other hosts, each with the number of ranks it takes: h1,h2:2")


def run(args: argparse.Namespace) -> int:
    """Ask the run's launcher, and return once it has agreed."""
    if args.hosts is not None:
        check_names("hosts", (host.partition(":")[0] for host in args.hosts.split(",")))
    size = Size(args.ranks, args.hosts)
    request(Path(args.run), size)
    tell(f"motes resize: {args.run} goes on with {size} when its frame is done")
    return 0
