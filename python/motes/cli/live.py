"""Start a script on N ranks, and show it in a browser, where it can be steered.

  python -m motes live -n 4 examples/flame.py
  python -m motes live -n 4 --paused script.py [arguments]
  python -m motes live -n 16 --hosts node1:8,node2:8 --port 9000 script.py

The line "motes: live at http://127.0.0.1:8080/?k=..." shows the address, and how to reach it from another
machine. If the run has a log, steer.jsonl there records what viewers do; `run --steering` repeats it.
A live view needs the extra: pip install "motes[live]". Other options are those of `run`.
"""

from __future__ import annotations

import argparse
import os

from .._values.live import Live
from . import run as run_command

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
    run_command.configure(parser)
    parser.usage = (
        "python -m motes live -n N [--port P] [--host ADDRESS] [--wait] [--paused] [options of run] "
        "[-- mpirun options] script.py [arguments]"
    )


def run(args: argparse.Namespace) -> int:
    """Start the job as `run` does, with viewers."""
    live = Live(args.port, host=args.host, wait=args.wait, paused=args.paused)
    words = [str(live.port), f"host={live.host}"]
    words += [word for word, wanted in (("wait", live.wait), ("paused", live.paused)) if wanted]
    os.environ.update(MOTES_LIVE=",".join(words))
    return run_command.run(args)
