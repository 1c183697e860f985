"""Write what a script records, frame by frame, to a file that replays without Python.

  python -m motes record script.py [script's arguments] -o scene.motes
  python -m motes record -o scene.motes [--full] [--json] script.py [script's arguments]

If -o comes before the script, everything after the script belongs to the script. Otherwise -o, --full and
--json are read from the end of the line.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from ..errors import MotesError
from .parser import Parser, add_json, print_figures

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `record`."""
    parser.usage = "python -m motes record [-o scene.motes] [--full] [--json] script.py [arguments]"
    _add_own(parser)
    parser.add_argument(
        "program", nargs=argparse.REMAINDER, metavar="script.py ...", help="a script and its arguments"
    )


def run(args: argparse.Namespace) -> int:
    """Run the script in this process and write its scene."""
    program = list(args.program)
    if args.output is None:
        program = _take_from_the_end(program, args)
    if not program:
        raise MotesError("no script given: python -m motes record script.py [arguments] -o scene.motes")
    if not Path(program[0]).is_file():
        raise MotesError(f"script {program[0]} does not exist")
    if args.output is None:
        raise MotesError("record: no output file given: add `-o scene.motes`")
    from .._run import scenefile  # needs the core

    recording = scenefile.record(program, Path(args.output), full=args.full)
    if recording is None:
        return 1
    if recording.here:
        facts = {"scene": str(recording.path), **recording.facts}
        text = "{scene}: {frames} frames, {systems} systems, {bytes} bytes".format(**facts)
        print_figures(args, facts, text)
    return 0


def _add_own(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", metavar="FILE", help="the scene file to write")
    parser.add_argument("--full", action="store_true", help="compute and draw as an ordinary run does")
    add_json(parser)


def _take_from_the_end(program: list[str], args: argparse.Namespace) -> list[str]:
    """Parse our options, including -o, at the end of the script's arguments; return the rest."""
    end = len(program)
    found = False
    while end > 1:
        if program[end - 1] in ("--full", "--json"):
            end -= 1
        elif program[end - 1].startswith("--output="):
            end, found = end - 1, True
        elif end > 2 and program[end - 2] in ("-o", "--output"):
            end, found = end - 2, True
        else:
            break
    if not found:
        return program
    own = Parser(prog="python -m motes record")
    _add_own(own)
    own.parse_args(program[end:], args)
    return program[:end]
