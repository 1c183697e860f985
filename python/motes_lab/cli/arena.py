"""Compare balancers on loads whose best cuts are known, on virtual machines or on real ranks.

  python -m motes arena
  python -m motes arena --workload step wave --balancer PrefixCuts mine.py:Mine --cluster thousand
  python -m motes arena --workload pic_geometric --ranks 4
  python -m motes arena --league league.jsonl
  python -m motes arena --workload DIRECTORY

A directory has load files of vt or LBAF, one per rank: their tasks play on as many equal machines. --frames
beyond their phases repeat the last one.

Scores on virtual machines are the same in each repeat. A league alone is only read and ranked.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

from motes.cli.parser import add_json, positive, print_figures
from motes.errors import ArgumentError, MotesError
from motes.replay import load_files

from .._engine import extras
from ..arena import players, table
from ..arena.machines import MACHINES, Machine, machine
from ..arena.score import Score, Track
from ..workloads import WORKLOADS, Tasks, workload

__all__ = ["configure", "run"]

EACH = 200_000
"""Particles per virtual rank."""
EACH_REAL = 20_000
"""Particles per real rank."""
CELLS, CELLS_EACH = 1000, 16
"""Fewest cells in the row, and fewest per rank."""
FRAMES, FRAMES_OF_MANY, MANY = 60, 24, 256
"""Frames by default; frames on more than `MANY` ranks; that number of ranks."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        *("--workload", "-w"),
        nargs="+",
        action="extend",
        metavar="W",
        help=f"workloads: {', '.join(WORKLOADS)} (all of them), or load files of another code",
    )
    parser.add_argument(
        *("--balancer", "-b"),
        nargs="+",
        action="extend",
        metavar="B",
        help="balancers: names with or without options, or file.py:Class (all of them)",
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--ranks", type=positive, metavar="N", help="use N real ranks, all of which calculate")
    where.add_argument(
        "--cluster",
        nargs="+",
        action="extend",
        metavar="FILE",
        help=f"virtual machines: {', '.join(MACHINES)}, or a file for `cluster run` (paper, two_kinds)",
    )
    parser.add_argument(
        "--frames", type=positive, help=f"per workload ({FRAMES}, on many ranks {FRAMES_OF_MANY})"
    )
    parser.add_argument("--particles", type=positive, help=f"per rank ({EACH}, on real ranks {EACH_REAL})")
    parser.add_argument(
        "--plot", type=Path, metavar="FILE", help="draw each frame's distance from the best cuts"
    )
    parser.add_argument(
        "--league",
        type=Path,
        metavar="FILE",
        help="add the results to a .parquet or .jsonl file; alone: rank what it holds",
    )
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    """Play, and print the scores; return 1 if particles were lost or results differ."""
    if args.plot:
        extras.matplotlib("matplotlib.figure")  # before minutes of work
    if args.league and args.league.suffix not in (".parquet", ".jsonl"):
        raise ArgumentError("league", str(args.league), "a file that ends in .parquet or .jsonl")
    if args.league:
        table.require_parquet(args.league)
        if not (args.workload or args.balancer or args.ranks or args.cluster):
            return _ranked(args)
    games = {name: _tasks(args, name) for name in args.workload or WORKLOADS}
    scores: list[Score] = []
    for name, tasks in games.items():
        if tasks is not None:
            scores += _on_tasks(args, tasks)
        elif args.ranks:
            scores += _on_ranks(args, name)
        else:
            for one in args.cluster or ("paper", "two_kinds"):
                scores += _on_machine(args, name, machine(one))
    rows = table.rows(scores)
    figures = {"rows": rows, "league": table.league(rows)}
    print_figures(args, figures, table.text(scores))
    if args.plot:
        table.plot(scores, args.plot)
    if args.league:
        table.keep(scores, args.league)
        print(f"{args.league}: {len(table.stored(args.league))} results", file=sys.stderr)
    return 0 if _right(scores) else 1


def _ranked(args: argparse.Namespace) -> int:
    """Print what a league has stored; return 1 if some particles were lost."""
    for name in ("frames", "particles", "plot"):
        if getattr(args, name):
            raise MotesError(f"--{name} is for playing, but a league alone is only ranked: name a --workload")
    if not args.league.is_file():
        raise MotesError(f"there is no league {args.league} yet: play with --workload to begin it")
    rows = table.stored(args.league)
    if not rows:
        raise MotesError(f"{args.league} is empty: play with --workload to fill it")
    print_figures(args, {"rows": rows, "league": table.league(rows)}, table.league_text(rows))
    return 0 if all(row["verified"] for row in rows) else 1


def _tasks(args: argparse.Namespace, name: str) -> Tasks | None:
    """Return the tasks of load files; None if this is the name of a made load."""
    if name in WORKLOADS:
        return None
    if not load_files(Path(name)):
        allowed = f"{', '.join(WORKLOADS)}, or a directory of load files"
        raise ArgumentError("workload", name, allowed, known=WORKLOADS)
    for option in ("ranks", "particles"):
        if getattr(args, option):
            raise MotesError(f"--{option} is for made loads, but {name} has load files of another code")
    return Tasks(name, frames=args.frames)


def _on_tasks(args: argparse.Namespace, tasks: Tasks) -> list[Score]:
    """Play tasks on equal machines, as many as there are files, or on those of clusters; moving is free."""
    equal = Machine("equal ranks", (1.0,) * tasks.ranks, tasks.particle_s, 0.0, 0.0, 0.0, 0.0)
    machines = [
        replace(machine(one), particle_s=tasks.particle_s, leave_s=0.0, arrive_s=0.0, byte_s=0.0)
        for one in args.cluster or ()
    ] or [equal]
    return [score for one in machines for score in _played(args, Track(tasks, one))]


def _on_machine(args: argparse.Namespace, name: str, where: Machine) -> list[Score]:
    ranks = len(where.speeds)
    game = workload(
        name,
        frames=args.frames or (FRAMES if ranks <= MANY else FRAMES_OF_MANY),
        cells=max(CELLS, CELLS_EACH * ranks),
        particles=(args.particles or EACH) * ranks,
    )
    return _played(args, Track(game, where))


def _played(args: argparse.Namespace, track: Track) -> list[Score]:
    speeds, move_cost = track.machine.speeds, track.machine.move_cost
    named = args.balancer or players.FIELD
    return [track.play(players.player(text, speeds, move_cost), text) for text in named]


def _on_ranks(args: argparse.Namespace, name: str) -> list[Score]:
    from ..arena import on_ranks

    cells = max(CELLS, CELLS_EACH * args.ranks)
    return on_ranks.play(
        name,
        args.balancer or players.FIELD,
        args.ranks,
        frames=args.frames or FRAMES,
        cells=cells + cells % 2,
        particles=(args.particles or EACH_REAL) * args.ranks,
    )


def _right(scores: list[Score]) -> bool:
    """Return whether all scores were verified, and each workload has one digest."""
    digests = {(score.machine, score.workload): set[str]() for score in scores}
    for score in scores:
        digests[score.machine, score.workload].add(score.digest)
    return all(score.verified for score in scores) and all(len(found) == 1 for found in digests.values())
