"""Start a script on N ranks, and show it in a browser, where it can be steered.

  python -m motes live -n 4 examples/flame.py
  python -m motes live -n 4 --paused script.py [arguments]
  python -m motes live -n 16 --hosts node1:8,node2:8 --port 9000 script.py

The line "motes: live at http://127.0.0.1:8080/?k=..." shows the address, and how to reach it from another
machine. The page outlives the run: it keeps the pictures, starts the run again, and reloads the script when
it is saved (docs/live.md). With --hosts, --hostfile or nodes allocated by a scheduler the run itself serves
the page, which ends with it. If the run has a log, steer.jsonl there records what viewers do; `run
--steering` repeats it. A live view needs the extra: pip install "motes[live]". Other options are those of
`run`.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import sys
from pathlib import Path

from .. import _extras
from .._launch import starting
from .._values.live import Live
from . import run as run_command
from .parser import Parser, positive

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `live`: its own, and those of `run`."""
    default = Live()
    parser.add_argument("--port", type=int, default=default.port, help="8080, or the next free port")
    parser.add_argument(
        "--host",
        default=default.host,
        help="the address to listen on; the default is reachable only from this machine",
    )
    parser.add_argument(
        "--wait", action="store_true", help="start the first frame when the first viewer connects"
    )
    parser.add_argument("--paused", action="store_true", help="start paused")
    parser.add_argument(
        "--cache",
        type=positive,
        default=512,
        metavar="MB",
        help="memory for pictures of earlier frames (512)",
    )
    parser.add_argument(
        "--no-reload", action="store_true", help="do not reload the script when it is saved; the page can"
    )
    run_command.configure(parser)
    parser.usage = (
        "python -m motes live -n N [--port P] [--host ADDRESS] [--wait] [--paused] [--cache MB] "
        "[--no-reload] [options of run] [-- mpirun options] script.py [arguments]"
    )


def run(args: argparse.Namespace) -> int:
    """Start the job as `run` does, with viewers."""
    live = Live(args.port, host=args.host, wait=args.wait, paused=args.paused)
    if args.hosts is None and args.hostfile is None and starting.allocated() is None:
        return asyncio.run(_desk(args, live))
    words = [str(live.port), f"host={live.host}"]
    words += [word for word, wanted in (("wait", live.wait), ("paused", live.paused)) if wanted]
    os.environ.update(MOTES_LIVE=",".join(words))
    return run_command.run(args)


async def _desk(args: argparse.Namespace, live: Live) -> int:
    """Serve a page whose jobs are those of `motes run`."""
    from .._desk.desk import Desk, Start

    _extras.require_live()
    options, program = run_command.split_program(args)
    starting.check_program(program)
    is_script = not program[0].startswith("-")
    start = Start(
        argv=[
            sys.executable,
            "-m",
            "motes",
            "run",
            *_words(args),
            *(["--", *options, "--"] if options else []),
            *program,
        ],
        script=Path(program[0]) if is_script else None,
        arguments=program[1:],
        live=live,
        budget=args.cache << 20,
        reload=is_script and not args.no_reload,
    )
    return await Desk(start).serve()


def _words(args: argparse.Namespace) -> list[str]:
    """Return the options of `run` that were given, as words of a command line."""
    own = Parser(prog="run")
    run_command.configure(own)
    words = []
    for name, default in vars(own.parse_args(["-n", "0"])).items():
        given = getattr(args, name, None)
        if name in ("module", "code", "program") or given in (None, default):
            continue
        words += [f"--{name.replace('_', '-')}", *([] if given is True else [str(given)])]
    return words
