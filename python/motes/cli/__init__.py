"""The command line: `python -m motes COMMAND ...`, one module per command.

Each module has `configure(parser)`, which adds the command's arguments, and `run(args)`, which does the work
and returns the exit code. Only the module of the given command is imported.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Sequence
from types import ModuleType

from .. import _extras
from .._io.text import printable
from ..errors import MotesError, near
from .parser import Parser

__all__ = ["COMMANDS", "LAB", "command", "main"]

PROGRAM = "python -m motes"
COMMANDS = {
    "run": "start a script on N ranks with the right mpirun",
    "frame": "draw one frame of a script and save it",
    "live": "the same, shown in a browser, where it can be steered",
    "doctor": "examine this installation; exit code 1 if something is wrong",
    "watch": "show a run in progress, from its log",
    "report": "write a run's summary and plots as one HTML file",
    "demo": "run one of the example animations, or list them",
    "movie": "join numbered pictures into a film",
    "resize": "continue a run with another number of ranks, or on other hosts",
    "sweep": "run a script with many values, and compare the runs in one table",
    "record": "write what a script records to a file that replays without Python",
    "pack": "join the particle files that the ranks of a run have exported",
}
LAB = {
    "bench": "measure this machine",
    "soak": "test the engine's promises under thousands of simulated disasters",
    "cluster": "run on a simulated cluster; reproduce the paper's tables",
    "arena": "compare balancers on loads whose best cuts are known",
    "course": "write a course about load balancing: six evenings as notebooks",
    "grade": "grade a submission for an evening of the course",
}
"""The commands of the laboratory."""
_DESCRIPTION = "Particle animations on clusters."
for _title, _table in (("commands", COMMANDS), ("laboratory", LAB)):
    _DESCRIPTION += f"\n\n{_title}:\n" + "\n".join(f"  {name:<9} {about}" for name, about in _table.items())


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; return the exit code, 2 for usage errors and for errors of motes."""
    _open_standard_streams()
    given = list(sys.argv[1:] if argv is None else argv)
    if not given or given[0] not in {**COMMANDS, **LAB}:
        return _without_command(given)
    try:
        module = command(given[0])
        parser = Parser(prog=f"{PROGRAM} {given[0]}", description=module.__doc__)
        module.configure(parser)
        args = parser.parse_args(given[1:])
        code: int = module.run(args)
        return code
    except MotesError as error:
        return _failed(str(error))
    except BrokenPipeError:
        # The reader of the output, such as a pager or `head`, has exited; Python must not flush again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        if error.filename is None:
            raise
        return _failed(f"{os.fspath(error.filename)}: {error.strerror}")


def command(name: str) -> ModuleType:
    """Import a command's module. Raises MissingExtraError if that needs the laboratory, which is not here."""
    if name in LAB:
        return _extras.laboratory(f"cli.{name}", f"`motes {name}`")
    return importlib.import_module(f".{name}", __name__)


def _open_standard_streams() -> None:
    """Open standard streams that `2>&-` or the like has closed: else other files would get their numbers."""
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # gets the lowest free number
    for number, name in ((1, "stdout"), (2, "stderr")):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, "w", closefd=False))


def _without_command(argv: list[str]) -> int:
    parser = Parser(prog=PROGRAM, usage=f"{PROGRAM} COMMAND ...", description=_DESCRIPTION)
    parser.epilog = f"`{PROGRAM} COMMAND --help` describes a command."
    parser.add_argument("--version", action="store_true", help="print the version and exit")
    if not argv:
        parser.print_help(sys.stderr)
        return 2
    if not argv[0].startswith("-"):
        parser.error(f"unknown command {argv[0]!r}{near(argv[0], [*COMMANDS, *LAB])}")
    if parser.parse_args(argv).version:
        from .. import __version__

        print(__version__)
    return 0


def _failed(text: str) -> int:
    print("motes: " + "\n".join(map(printable, text.split("\n"))), file=sys.stderr, flush=True)
    return 2
