"""Run a script many times with different values, and compare the runs in one table.

  python -m motes sweep snow.py --set wind=0:5:6 --set seed=0..4 --ranks 1,2,4 --balancer all -o out
  python -m motes sweep --jobs 4 snow.py --set flakes=1000,2000 -o out -- --size 320x180
  python -m motes sweep --slurm snow.py --set seed=0..99 --ranks 16 -o out

--set names a control of the script (world.control), or `seed`: NAME=a:b:n are n numbers from a to b,
NAME=a..b whole numbers, NAME=a,b,c a list. All combinations run, each in a folder of its own, which is also
its working directory. Runs that are complete are not repeated, so the same command continues a sweep that was
killed. At the end there are sweep.csv, sweep.parquet if pyarrow is installed, and sheet.png with the last
pictures. Exit code 1 if runs have failed; their rows say why. Arguments after `--` go to the script.

--slurm writes a job array of what is missing, and says how to submit it; afterwards the same command without
--slurm writes the table.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from .. import balance
from .._io.output import tell
from .._run.sweeping import STILL
from .._sweep import grid, slurm, table
from .._sweep.grid import Case
from .._sweep.runs import Row, Sweep, stopping
from .._values.space import in_a_row
from ..errors import ArgumentError
from .parser import Parser, positive

__all__ = ["configure", "run"]


def configure(parser: Parser) -> None:
    """Add the arguments of `sweep`."""
    parser.intermixed = True
    parser.add_argument("script", help="the script; its arguments after `--`")
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUES", help="values of a control, or of seed"
    )
    parser.add_argument("--ranks", default="1", metavar="N,N", help="numbers of ranks, default 1")
    parser.add_argument("--balancer", metavar="NAME,NAME", help="balancers, or all; default: the script's")
    parser.add_argument("--jobs", type=positive, default=1, metavar="J", help="runs at the same time")
    parser.add_argument("--slurm", action="store_true", help="write a job array instead of running")
    parser.add_argument("--only", type=int, metavar="K", help="run only number K, without a table")
    parser.add_argument("--fresh", action="store_true", help="repeat runs that are complete")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="where the runs go")
    parser.add_argument("arguments", nargs="*", help="arguments of the script")


def run(args: argparse.Namespace) -> int:
    """Run what is missing, and write the table."""
    if not Path(args.script).is_file():
        raise ArgumentError("script", args.script, "an existing file")
    ranks = grid.whole_numbers("--ranks", args.ranks)
    first = grid.cases(args.set, ranks)
    sweep = Sweep([args.script, *args.arguments], Path(args.output), table.figures)
    has = sweep.probe(ranks[0])
    _check_controls(first[0], has["controls"])
    cases = grid.cases(args.set, ranks, _balancers(args.balancer, has["axis"]))
    if args.only is not None:
        return _only(sweep, cases, args.only)
    if args.fresh:
        sweep.forget(cases)
    rows = {number: row for number, case in enumerate(cases) if (row := sweep.row(case)) is not None}
    missing = [number for number in range(len(cases)) if number not in rows]
    sweep.directory.mkdir(parents=True, exist_ok=True)
    if args.slurm and missing:
        return _for_slurm(sweep, args, missing, max(ranks))
    if rows:
        tell(f"motes sweep: {len(rows)} of {len(cases)} runs are complete")
    with stopping(sweep):
        rows |= _run(sweep, cases, missing, args.jobs)
    if sweep.stopped:
        tell("motes sweep: stopped; the same command continues")
        return 128 + sweep.stopped
    return _finish(sweep, cases, [rows[number] for number in range(len(cases))])


def _run(sweep: Sweep, cases: Sequence[Case], missing: Sequence[int], jobs: int) -> dict[int, Row]:
    rows: dict[str, Row] = {}

    def note(count: int, row: Row) -> None:
        name = ", ".join(f"{name}={row[name]}" for name in cases[0].values)
        rows[name] = row
        how = f"failed: {row['error']}" if row["error"] else f"{row['seconds']:.1f} s"
        tell(f"motes sweep: {count} of {len(missing)}: {name}: {how}")

    sweep.run([cases[number] for number in missing], jobs, note)
    return {number: rows[cases[number].name] for number in missing if cases[number].name in rows}


def _finish(sweep: Sweep, cases: Sequence[Case], rows: Sequence[Row]) -> int:
    paths = table.write_table(sweep.directory, cases, rows)
    sheet = table.write_sheet(sweep.directory, rows, STILL)
    failed = sum(bool(row["error"]) for row in rows)
    written = ", ".join(os.fspath(path) for path in [*paths, *([sheet] if sheet else [])])
    tell(f"motes sweep: {len(rows) - failed} runs, {failed} failed; {written}")
    return 1 if failed else 0


def _only(sweep: Sweep, cases: Sequence[Case], number: int) -> int:
    if not 0 <= number < len(cases):
        raise ArgumentError("--only", number, f"the number of a run, 0..{len(cases) - 1}")
    with stopping(sweep):
        row = sweep.run_one(cases[number])
    if row["error"]:
        tell(f"motes sweep: {cases[number].name} failed: {row['error']}")
    return 1 if row["error"] else 0


def _for_slurm(sweep: Sweep, args: argparse.Namespace, missing: Sequence[int], ranks: int) -> int:
    command = [args.script, *(word for text in args.set for word in ("--set", text)), "--ranks", args.ranks]
    command += ["--balancer", args.balancer] if args.balancer else []
    command += ["-o", args.output, *(["--", *args.arguments] if args.arguments else [])]
    path = slurm.write_script(sweep.directory, command, missing, ranks)
    print(f"sbatch {path}", file=sys.stdout, flush=True)
    tell(f"motes sweep: {len(missing)} runs are missing; the same command without --slurm writes the table")
    return 0


def _balancers(text: str | None, axis: str) -> list[str | None]:
    if text is None:
        return [None]
    known = {type(one).__name__: one for one in balance.without_options()}
    if text == "all":
        return [name for name, one in known.items() if not one.slabs_only or in_a_row(axis)]
    chosen: list[str | None] = []
    for name in text.split(","):
        if name not in known or name in chosen:
            raise ArgumentError("--balancer", name, f"all, or some of {', '.join(known)}", known=known)
        chosen.append(name)
    return chosen


def _check_controls(case: Case, known: Sequence[str]) -> None:
    for name, _ in case.controls:
        if name in table.COLUMNS:
            raise ArgumentError("--set", name, "a control that is not named like a column of the table")
        if name not in known:
            listed = ", ".join(known) if known else "it has none: world.control(name, value) makes one"
            allowed = f"seed, or a control of the script ({listed})"
            raise ArgumentError("--set", name, allowed, known=[*known, "seed"])
