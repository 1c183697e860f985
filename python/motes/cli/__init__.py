"""The command line: `python -m motes run | record | cluster | doctor | bench | watch | report`."""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path

from .. import launch, scenefile
from ..analysis import watch
from ..analysis.export import report
from ..errors import MotesError
from . import doctor

__all__ = ["main"]

_RUN_USAGE = (
    "python -m motes run -n N [--hosts h1,h2:2 | --hostfile FILE] [-- mpirun options] script.py [arguments]"
)
_RUN_OPTIONS = ("-n", "-np", "--ranks", "--hosts", "--hostfile")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; the exit code."""
    words = list(sys.argv[1:] if argv is None else argv)
    try:
        # These hand words on to others, which argparse would take for its own.
        if words[:1] == ["run"]:
            return _run(words[1:])
        if words[:1] == ["record"]:
            return scenefile.main(words[1:])
        if words[:1] == ["cluster"]:
            from . import cluster as command

            return command.main(words[1:])
        if words[:1] == ["bench"] and _has("bench"):
            return int(importlib.import_module("motes.cli.bench").main(words[1:]) or 0)
        arguments = _parser().parse_args(words)
        if arguments.command == "doctor":
            return doctor.main(as_json=arguments.json)
        if arguments.command == "watch":
            return watch.main(
                arguments.run, once=arguments.once, as_json=arguments.json, wait_s=arguments.wait
            )
        if arguments.command == "report":
            return report.main(arguments.run, output=arguments.output, as_json=arguments.json)
        _parser().print_help()
        return 2
    except MotesError as error:
        print(f"motes: {error}", file=sys.stderr)
        return 2


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m motes", description="Particle animations on clusters.")
    commands = parser.add_subparsers(dest="command", metavar="command")
    commands.add_parser("run", help="start a script on N ranks with the right mpirun", usage=_RUN_USAGE)
    commands.add_parser("record", help="write what a script says to a file", usage=scenefile.USAGE)
    commands.add_parser("cluster", help="run on a simulated cluster; reproduce the paper's tables")
    check = commands.add_parser("doctor", help="examine this installation; exit code 1 if something is wrong")
    check.add_argument("--json", action="store_true", help="print one JSON object")
    if _has("bench"):
        commands.add_parser("bench", help="measure this machine")
    live = commands.add_parser("watch", help="show a run while it goes on, from its log")
    live.add_argument("run", metavar="RUN", help="the run's log: the directory of World(log=...)")
    live.add_argument("--once", action="store_true", help="show what there is now, and end")
    live.add_argument("--json", action="store_true", help="show it as one JSON object, and end")
    live.add_argument(
        "--wait", type=float, default=10.0, metavar="S", help="seconds to wait for the log (10)"
    )
    page = commands.add_parser("report", help="write a run's summary and plots as one HTML file")
    page.add_argument("run", metavar="RUN", help="the run's log: the directory of World(log=...)")
    page.add_argument("-o", "--output", metavar="FILE", help="where to (RUN/report.html)")
    page.add_argument("--json", action="store_true", help="print the figures as one JSON object")
    return parser


def _run(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m motes run", usage=_RUN_USAGE)
    parser.add_argument("-n", "-np", "--ranks", type=int, required=True, metavar="N", help="number of ranks")
    parser.add_argument("--hosts", help="hosts, each with the number of ranks it takes: h1,h2:2")
    parser.add_argument("--hostfile", help="a file of hosts in mpirun's own form")
    own, options, program = _split(words)
    arguments = parser.parse_args(own)
    return launch.run(
        arguments.ranks, program, hosts=arguments.hosts, hostfile=arguments.hostfile, options=options
    )


def _split(words: list[str]) -> tuple[list[str], list[str], list[str]]:
    """Part the words into our own options, mpirun's (between `--` and the script) and the program.

    A second `--` says where mpirun's options end; without one it is the first word that looks like a script.
    """
    end = 0
    while end < len(words) and words[end].startswith("-") and words[end] not in ("--", "-m", "-c"):
        end += 2 if words[end] in _RUN_OPTIONS else 1
    own, rest = words[:end], words[end:]
    if rest[:1] != ["--"]:
        return own, [], rest
    rest = rest[1:]
    scripts = [i for i, word in enumerate(rest) if word in ("-m", "-c") or word.endswith(".py")]
    start = min(scripts, default=len(rest))
    if "--" in rest[:start]:
        start = rest.index("--")
        return own, rest[:start], rest[start + 1 :]
    if start == len(rest):  # a script by another name, or a value of an option that is a file
        start = next((i for i, word in enumerate(rest) if Path(word).is_file()), start)
    return own, rest[:start], rest[start:]


def _has(name: str) -> bool:
    return importlib.util.find_spec(f"motes.{name}") is not None
