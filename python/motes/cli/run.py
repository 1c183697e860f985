"""Start a script on N ranks with the mpirun that belongs to Python's MPI.

  python -m motes run -n 4 script.py [arguments]
  python -m motes run -n 4 -m package.module [arguments]
  python -m motes run -n 16 --hosts node1:8,node2:8 script.py
  python -m motes run -n 5 --survive script.py
  python -m motes run -n 4 -- --bind-to core script.py [arguments]
  python -m motes run -n 4 --restarts 3 script.py
  python -m motes run -n 2 --steering log/steer.jsonl script.py
  python -m motes run -n 4 --frames 400:500 script.py

A script with checkpoints continues from its newest complete one when the same command is run again; with
--restarts it does so automatically.

--frames 400:500 draws frames 400 to 499. The frames before are computed without pictures, from the newest
checkpoint. Films, logs and exports get names such as film.000400-000500.mp4; `movie film.mp4` joins the films
of all ranges. --preview draws at half the size.

With --survive (Open MPI 5) the other ranks outlive one that is killed: worlds with on_loss="recover" continue
without it.
Arguments between `--` and the script go to mpirun. The script begins at the first of them that ends in .py or
names a file, or at -m or -c; a second `--` ends mpirun's options explicitly.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from .._launch import starting
from .._values.environment import FRAMES, frames
from ..errors import ArgumentError

__all__ = ["add_wishes", "configure", "run", "tell_ranks"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `run`."""
    parser.usage = (
        "python -m motes run -n N [--hosts h1,h2:2 | --hostfile FILE] [--survive] [--restarts K] "
        "[--fresh] [--anyway] [--steering FILE] [--frames FIRST:END] [--preview] [-- mpirun options] "
        "script.py [arguments]"
    )
    parser.add_argument("-n", "-np", "--ranks", type=int, required=True, metavar="N", help="number of ranks")
    parser.add_argument("--hosts", help="hosts, each with the number of ranks it takes: h1,h2:2")
    parser.add_argument("--hostfile", metavar="FILE", help="a file of hosts in mpirun's own format")
    parser.add_argument("--survive", action="store_true", help="continue when a rank is lost (Open MPI 5)")
    parser.add_argument(
        "--restarts", type=int, default=0, metavar="K", help="restart up to K times after a rank is lost"
    )
    add_wishes(parser)
    parser.add_argument(
        "--frames",
        metavar="FIRST:END",
        help="draw only these frames, END not included; `movie` joins the films of several ranges",
    )
    rest = argparse.REMAINDER
    parser.add_argument("-m", nargs=rest, dest="module", metavar="...", help="a module and its arguments")
    parser.add_argument("-c", nargs=rest, dest="code", metavar="...", help="Python code and its arguments")
    parser.add_argument("program", nargs=rest, metavar="script.py ...", help="a script and its arguments")


def run(args: argparse.Namespace) -> int:
    """Start the job and wait for it; one rank on this host replaces this process."""
    options, program = split_program(args)
    tell_ranks(args)
    if args.frames is not None:
        check_frames("--frames", args.frames)
        os.environ.update(MOTES_FRAMES=args.frames)
    return starting.run(
        args.ranks,
        program,
        hosts=args.hosts,
        hostfile=args.hostfile,
        options=options,
        survive=args.survive,
        restarts=args.restarts,
    )


def add_wishes(parser: argparse.ArgumentParser) -> None:
    """Add options that both `run` and `frame` have."""
    parser.add_argument(
        "--fresh",
        action="store_true",
        help="start from the first frame even if there are checkpoints, and replace earlier exports",
    )
    parser.add_argument(
        "--anyway", action="store_true", help="continue or repeat a run even if the script has changed"
    )
    parser.add_argument(
        "--steering",
        metavar="FILE",
        help="repeat what viewers did in an earlier run: the steer.jsonl of its log",
    )
    parser.add_argument(
        "--preview", action="store_true", help="draw at half the size, with sprites sized in pixels along"
    )


def tell_ranks(args: argparse.Namespace) -> None:
    """Set the variables that tell the ranks about the options of `add_wishes`."""
    for name in ("fresh", "anyway", "preview"):
        if getattr(args, name):
            os.environ[f"MOTES_{name.upper()}"] = "1"
    if args.steering is not None:
        if not Path(args.steering).is_file():
            raise ArgumentError("--steering", args.steering, "the steer.jsonl of an earlier run")
        os.environ.update(MOTES_STEERING=str(Path(args.steering).absolute()))


def check_frames(argument: str, text: str) -> None:
    """Raise ArgumentError unless the text is a range of frames."""
    try:
        frames(text)
    except ValueError:
        raise ArgumentError(argument, text, FRAMES) from None


def split_program(args: argparse.Namespace) -> tuple[list[str], list[str]]:
    """Return mpirun's options and the program with its arguments."""
    for name, argv in (("-m", args.module), ("-c", args.code)):
        if argv is not None:
            return [], [name, *argv, *args.program]  # argparse ends an option's arguments at "--"
    argv = list(args.program)
    if argv[:1] != ["--"]:
        return [], argv
    argv = argv[1:]
    scripts = [i for i, argument in enumerate(argv) if argument in ("-m", "-c") or argument.endswith(".py")]
    start = min(scripts, default=len(argv))
    if "--" in argv[:start]:
        start = argv.index("--")
        return argv[:start], argv[start + 1 :]
    if start == len(argv):  # a script without .py, or an option's value that is a file
        start = next((i for i, argument in enumerate(argv) if Path(argument).is_file()), start)
    return argv[:start], argv[start:]
