"""Run on a simulated cluster, reproduce the paper's tables, or measure how the engine scales with ranks.

  python -m motes cluster paper --table 1
  python -m motes cluster run --balancer mine.py:Mine cluster.py snow.motes

Needs SimGrid (apt-get install libsimgrid-dev) and `motes_replay` built for it: `cluster build`, once.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import Any

from motes import Run
from motes.cli.parser import add_commands, add_json, print_figures
from motes.errors import MotesError

from .._engine import extras
from ..cluster import growth
from ..cluster.build import build
from ..cluster.machines import Cluster, described
from ..cluster.simulate import record, simulate

__all__ = ["configure", "run"]

PLOTS = (".png", ".svg", ".pdf")
REPLAY = ("combine", "roles", "frames")
"""Options that are passed on to motes_replay unchanged."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the commands and their arguments."""
    commands = add_commands(parser, "COMMAND")
    _configure_run(
        commands.add_parser(
            "run",
            help="run a scene on a cluster described by a file",
            example="cluster.py snow.motes",
        )
    )
    paper = commands.add_parser(
        "paper", help="reproduce a table of the paper on a copy of its cluster", example="--table 1"
    )
    which = paper.add_mutually_exclusive_group(required=True)
    which.add_argument("--table", type=int, choices=(1, 2, 3), help="number of the paper's table")
    which.add_argument(
        "--text", action="store_true", help="the figures that only its text gives; takes minutes"
    )
    many = commands.add_parser(
        "growth",
        help="weak scaling: the same number of particles per rank on more and more ranks",
        example="--ranks 4,16,64",
    )
    many.add_argument(
        "--ranks",
        type=_numbers,
        default=list(growth.RANKS),
        metavar="N,...",
        help="numbers of ranks, each >= 3: one draws, one manages, the others calculate",
    )
    many.add_argument(
        "--births",
        type=_ways,
        default=["calculators"],
        metavar="WHO,...",
        help=f"who creates births: {', '.join(growth.WAYS)}",
    )
    many.add_argument(
        "--pictures", action="store_true", help="also draw pictures; with many ranks, all draw tiles"
    )
    for command in (paper, many):
        add_json(command)
        command.add_argument(
            "--plot", type=_plot, metavar="FILE", help="plot the result to a .png, .svg or .pdf file"
        )
    make = commands.add_parser(
        "build", help="compile motes_replay for the simulator from a clone of motes", example="--source ."
    )
    make.add_argument("--source", type=Path, required=True, metavar="DIR", help="the clone")
    make.add_argument(
        "--output",
        type=Path,
        metavar="FILE",
        help="where to put the program (next to this Python, where motes looks for it)",
    )


def run(args: argparse.Namespace) -> int:
    """Run one command."""
    return {"run": _run, "paper": _paper, "growth": _growth, "build": _build}[args.command](args)


def _configure_run(parser: argparse.ArgumentParser) -> None:
    parser.usage = (
        "python -m motes cluster run [options] CLUSTER.py (SCENE.motes | script.py [script's arguments])"
    )
    parser.add_argument("cluster", metavar="CLUSTER.py", help="a file that sets `cluster = Cluster(...)`")
    parser.add_argument("scene", metavar="SCENE", help="a recorded scene, or the script to record it from")
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help="the script's arguments")
    parser.add_argument("--log", metavar="DIR", help="keep the run's log in this directory")
    parser.add_argument(
        "--costs",
        metavar="FILE",
        help="what work costs: lines `name = nanoseconds` (measured on one core of a Xeon with AVX-512)",
    )
    parser.add_argument(
        "--scale",
        type=float,
        default=1.0,
        metavar="R",
        help="particles that each simulated particle represents (1)",
    )
    parser.add_argument("--blocking", action="store_true", help="calculators wait for the image generator")
    parser.add_argument(
        "--balancer",
        metavar="B",
        help="replaces the scene's: a name with or without options, or your own as file.py:Class",
    )
    for name in REPLAY:
        parser.add_argument(f"--{name}", help="passed on to motes_replay")
    add_json(parser)


def _run(args: argparse.Namespace) -> int:
    extras.pandas()  # before minutes of work
    cluster = described(Path(args.cluster))
    balancer = None
    if args.balancer is not None:
        from ..arena.players import player  # needs the compiled core

        balancer = player(args.balancer)
    options = ["--blocking"] if args.blocking else []
    for name in REPLAY:
        if getattr(args, name) is not None:
            options += [f"--{name}", getattr(args, name)]
    with tempfile.TemporaryDirectory(prefix="motes-scene-") as folder:
        scene = Path(args.scene)
        if scene.suffix == ".py":
            scene = Path(folder) / "scene.motes"
            record(scene, Path(args.scene), args.arguments)
        elif args.arguments:
            raise MotesError(f"a recorded scene takes no arguments, got {' '.join(args.arguments)}")
        elif not scene.is_file():
            raise MotesError(f"scene {scene} does not exist")
        log = Path(args.log) if args.log else Path(folder) / "log"
        sizes = {"costs": args.costs, "scale": args.scale}
        found = simulate(scene, cluster, log=log, balancer=balancer, options=options, **sizes)
        facts = {**_facts(found, cluster), "costs": args.costs or "measured on one core of a Xeon"}
    text = (
        "{ranks} ranks on {hosts} machines: {frames} frames in {simulated_s:.3f} simulated seconds, "
        "{frame_s:.4f} per frame, imbalance {imbalance:.2f}; costs of work: {costs}"
    ).format(**facts)
    print_figures(args, facts, text)
    return 0


def _facts(run: Run, cluster: Cluster) -> dict[str, Any]:
    seconds = run.frames["t_frame_s"]
    return {
        "ranks": cluster.ranks,
        "hosts": sum(node.count for node in cluster.nodes),
        "frames": len(seconds),
        "simulated_s": float(seconds.sum()),
        "frame_s": float(seconds.mean()),
        "imbalance": float(run.frames["imbalance"].iloc[-1]),
    }


def _paper(args: argparse.Namespace) -> int:
    from ..cluster.paper import experiment, in_text, show

    if args.text:
        if args.plot:
            raise MotesError("--plot draws a table: use it with --table")
        found = in_text.reproduce()
        print_figures(args, in_text.facts(found), in_text.text(found))
        return 0
    _require_plot(args)
    rows = experiment.reproduce(args.table)
    print_figures(args, show.facts(rows), show.text(rows))
    if args.plot:
        show.plot(rows, args.plot)
    return 0


def _growth(args: argparse.Namespace) -> int:
    _require_plot(args)
    rows = [row for way in args.births for row in growth.grow(args.ranks, way, pictures=args.pictures)]
    print_figures(args, growth.facts(rows), growth.text(rows))
    if args.plot:
        growth.plot(rows, args.plot)
    return 0


def _require_plot(args: argparse.Namespace) -> None:
    """Raise MissingExtraError before minutes of work, not after."""
    if args.plot:
        extras.matplotlib("matplotlib.figure")


def _build(args: argparse.Namespace) -> int:
    print(build(args.source, args.output))
    return 0


def _numbers(text: str) -> list[int]:
    try:
        found = [int(part) for part in text.split(",")]
    except ValueError:
        found = []
    if not found or min(found) < 3:
        raise argparse.ArgumentTypeError(f"must be whole numbers >= 3, got {text!r}")
    return found


def _plot(text: str) -> str:
    path = Path(text)
    if path.suffix not in PLOTS or not path.parent.is_dir():
        raise argparse.ArgumentTypeError(
            f"must be a file ending in {', '.join(PLOTS)} in an existing folder, got {text!r}"
        )
    return text


def _ways(text: str) -> list[str]:
    found = text.split(",")
    if not set(found) <= set(growth.WAYS):
        raise argparse.ArgumentTypeError(f"must be one or more of {', '.join(growth.WAYS)}, got {text!r}")
    return found
