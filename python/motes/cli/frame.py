"""Draw one frame of a script, save it, and stop.

  python -m motes frame script.py 731 -o still.png
  python -m motes frame script.py 731 -o still.png -n 4 --preview
  python -m motes frame script.py 731 -o still.png -- --particles 100000

The frames before it are computed without pictures, from the newest checkpoint that is not later. The picture
is the one that the whole run makes, on any number of ranks; it is compared with the digest in the run's log.
Nothing else is written: no film, log, export or checkpoint. Arguments after `--` go to the script.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from .._launch import starting
from .._picture.formats import format_of
from ..errors import ArgumentError, MotesError
from .parser import Parser, positive
from .run import add_wishes, tell_ranks

__all__ = ["configure", "run"]

_USAGE = "python -m motes frame script.py NUMBER -o FILE [-n N] [options] [-- script's arguments]"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `frame`."""
    parser.usage = _USAGE
    _add_own(parser)
    parser.add_argument(
        "program",
        nargs=argparse.REMAINDER,
        metavar="script.py NUMBER",
        help="the script and the frame's number, from 0",
    )


def run(args: argparse.Namespace) -> int:
    """Start the job and wait for it; one rank on this host replaces this process."""
    given = args.program[args.program[:1] == ["--"] :]
    end = given.index("--") if "--" in given else len(given)
    own = Parser(prog="python -m motes frame", usage=_USAGE)
    _add_own(own)
    own.add_argument("script")
    own.add_argument("number", type=int, metavar="NUMBER")
    own.set_defaults(**{name: one for name, one in vars(args).items() if name != "program"})
    args = own.parse_args(given[:end])
    if args.output is None:
        raise MotesError("frame: no file given for the picture: add `-o still.png`")
    if args.number < 0:
        raise ArgumentError("NUMBER", args.number, "a frame's number: frames count from 0")
    format_of("--output", args.output)
    tell_ranks(args)
    still = str(Path(args.output).absolute())
    os.environ.update(MOTES_FRAMES=f"{args.number}:{args.number + 1}", MOTES_STILL=still)
    return starting.run(args.ranks, [args.script, *given[end + 1 :]], hosts=args.hosts)


def _add_own(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", metavar="FILE", help="the picture: .png, .jpg, .webp, .exr or .npy")
    parser.add_argument("-n", "--ranks", type=positive, default=1, metavar="N", help="number of ranks (1)")
    parser.add_argument("--hosts", help="hosts, each with the number of ranks it takes: h1,h2:2")
    add_wishes(parser)
