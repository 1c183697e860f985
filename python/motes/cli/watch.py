"""Show a run in progress in another terminal, from its log.

  python -m motes watch runs/today

Exit code 0 if the run finished, 1 if it was killed. Ctrl-C ends this command, not the run.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import time
from pathlib import Path
from typing import Any, TextIO

from .._io.text import printable
from ..analysis._tables.tables import read_facts
from ..analysis.view import SPARKS, View
from ..errors import LogError
from .parser import add_json, print_figures

__all__ = ["configure", "run", "watch"]

EVERY_S = 0.5
LINE_EVERY_S = 1.0
SILENT_S = 120.0
"""A run whose log has not grown for this many seconds counts as dead."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `watch`."""
    parser.add_argument("run", metavar="RUN", help="the run's log: the directory of World(log=...)")
    parser.add_argument("--once", action="store_true", help="show the current state and exit")
    parser.add_argument("--wait", type=float, default=10.0, metavar="S", help="seconds to wait for it (10)")
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    """Show the run until it ends."""
    path = Path(args.run)
    try:
        if args.json:
            view = View(path, read_facts(path))
            view.read()
            print_figures(args, view.figures(), "")
            return 0
        return watch(path, once=args.once, wait_s=args.wait)
    except KeyboardInterrupt:
        return 0


def watch(path: Path, *, once: bool = False, wait_s: float = 10.0, out: TextIO | None = None) -> int:
    """Show the run on `out` (None: standard output) until it ends; return the exit code.

    `once`: show only the current state. `wait_s`: seconds to wait for the log.
    """
    view = View(path, _facts_when_there(path, 0.0 if once else wait_s))
    screen = _Screen(sys.stdout if out is None else out)
    if once:
        view.read()
        screen.print_whole(view)
        return 0
    while True:
        dead = view.process_is_gone()  # before reading, so that its last lines are read below
        view.read()
        over = view.ended or dead or view.silent_s > SILENT_S
        screen.show(view, last=over)
        if view.ended:
            return 0
        if dead or view.silent_s > SILENT_S:
            why = "its process is gone" if dead else f"nothing was written for {view.silent_s:.0f} s"
            print(f"motes: {printable(str(path))}: the run did not finish: {why}", file=sys.stderr)
            return 1
        time.sleep(EVERY_S)


def _facts_when_there(path: Path, wait_s: float) -> dict[str, Any]:
    limit = time.monotonic() + wait_s
    while True:
        try:
            return read_facts(path)
        except LogError:
            if time.monotonic() >= limit:
                raise
            time.sleep(EVERY_S / 2)


class _Screen:
    """Redraws in place on a terminal; elsewhere prints at most one line per second."""

    def __init__(self, out: TextIO) -> None:
        self._out = out
        self._live = out.isatty() and os.environ.get("TERM", "") not in ("", "dumb")
        self._drawn = 0
        self._said = -LINE_EVERY_S
        self._frame: int | None = None
        try:
            SPARKS.encode(out.encoding or "ascii")
            self._plain = False
        except (UnicodeEncodeError, LookupError):
            self._plain = True

    def show(self, view: View, *, last: bool) -> None:
        if self._live:
            self._redraw(view)
        else:
            self._tell(view, last=last)

    def print_whole(self, view: View) -> None:
        """Print the view once, without moving the cursor, for files and notebooks."""
        width = shutil.get_terminal_size().columns - 1
        print("\n".join(view.lines(width, plain=self._plain)), file=self._out, flush=True)

    def _redraw(self, view: View) -> None:
        size = shutil.get_terminal_size()
        lines = view.lines(size.columns - 1, plain=self._plain)[: max(size.lines - 1, 3)]
        up = f"\x1b[{self._drawn}F" if self._drawn else ""
        self._out.write(up + "".join(f"{line}\x1b[K\n" for line in lines) + "\x1b[J")
        self._out.flush()
        self._drawn = len(lines)

    def _tell(self, view: View, *, last: bool) -> None:
        now = time.monotonic()
        number = None if view.frame is None else view.frame.get("frame")
        if number is None or number == self._frame or (not last and now - self._said < LINE_EVERY_S):
            return
        self._said, self._frame = now, number
        print(view.line(), file=self._out, flush=True)
