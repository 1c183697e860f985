"""Write a run's summary and plots as one self-contained HTML file.

  python -m motes report runs/today -o today.html

It opens in any browser, on any machine.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from ..analysis import open_run
from ..analysis.report import write_report
from .parser import add_json, print_figures

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `report`."""
    parser.add_argument("run", metavar="RUN", help="the run's log: the directory of World(log=...)")
    parser.add_argument("-o", "--output", metavar="FILE", help="the file to write (RUN/report.html)")
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    """Write the report and print where it is."""
    log = open_run(args.run)
    target = write_report(log, args.output or Path(args.run) / "report.html")
    figures = {"report": str(target), **log.summary(), "warnings": log.warnings()}
    print_figures(args, figures, str(target))
    return 0
