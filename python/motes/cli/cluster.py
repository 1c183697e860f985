"""`python -m motes cluster run | paper | growth`: virtual machines, the paper's tables, many ranks."""

from __future__ import annotations

import argparse
import json
import runpy
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..analysis.run import Run
from ..cluster.machines import Cluster
from ..cluster.simulate import record, simulate
from ..errors import MotesError

__all__ = ["USAGE", "main"]

USAGE = """python -m motes cluster run [options] CLUSTER.py (SCENE.motes | script.py [arguments])
       python -m motes cluster paper --table 1|2|3 [--json] [--plot FILE]
       python -m motes cluster growth [--ranks 8,64,...] [--births WHO,...] [--pictures]
           [--json] [--plot FILE]"""
REPLAY = ("balancer", "combine", "roles", "frames")
"""Options that go to motes_replay as they are."""


def main(words: Sequence[str]) -> int:
    """Run one command; the exit code."""
    command = words[0] if words else ""
    if command == "run":
        return _run(list(words[1:]))
    if command == "paper":
        return _paper(list(words[1:]))
    if command == "growth":
        return _growth(list(words[1:]))
    print(f"usage: {USAGE}")
    return 0 if command in ("-h", "--help") else 2


def _run(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m motes cluster run", usage=USAGE, description=__doc__)
    parser.add_argument("cluster", metavar="CLUSTER.py", help="a file that says `cluster = Cluster(...)`")
    parser.add_argument("scene", metavar="SCENE", help="a recorded scene, or the script to record it from")
    parser.add_argument("words", nargs=argparse.REMAINDER, help="the script's arguments")
    parser.add_argument("--log", metavar="DIR", help="keep the run's log there")
    parser.add_argument("--costs", metavar="FILE", help="what work costs: lines name = nanoseconds")
    parser.add_argument(
        "--scale", type=float, default=1.0, metavar="R", help="particles that each stands for"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--blocking", action="store_true", help="calculators wait for the image generator")
    for name in REPLAY:
        parser.add_argument(f"--{name}", help="as motes_replay takes it")
    args = parser.parse_args(words)
    cluster = _described(Path(args.cluster))
    options = ["--blocking"] if args.blocking else []
    for name in REPLAY:
        if getattr(args, name) is not None:
            options += [f"--{name}", getattr(args, name)]
    with tempfile.TemporaryDirectory(prefix="motes-scene-") as folder:
        scene = Path(args.scene)
        if scene.suffix == ".py":
            scene = Path(folder) / "scene.motes"
            record(scene, Path(args.scene), args.words)
        elif args.words:
            raise MotesError(f"a recorded scene takes no arguments, got {' '.join(args.words)}")
        elif not scene.is_file():
            raise MotesError(f"scene {scene} does not exist")
        log = Path(args.log) if args.log else Path(folder) / "log"
        facts = _facts(
            simulate(scene, cluster, log=log, costs=args.costs, scale=args.scale, options=options), cluster
        )
    if args.json:
        print(json.dumps(facts))
    else:
        print(
            "{ranks} ranks on {hosts} machines: {frames} frames in {simulated_s:.3f} simulated seconds, "
            "{frame_s:.4f} a frame, imbalance {imbalance:.2f}".format(**facts)
        )
    return 0


def _described(path: Path) -> Cluster:
    if not path.is_file():
        raise MotesError(f"cluster file {path} does not exist")
    found = runpy.run_path(str(path)).get("cluster")
    if not isinstance(found, Cluster):
        raise MotesError(f"{path} must say `cluster = motes.cluster.Cluster(...)`")
    return found


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


def _paper(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m motes cluster paper", usage=USAGE)
    parser.add_argument("--table", type=int, choices=(1, 2, 3), required=True, help="which of the paper's")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--plot", metavar="FILE", help="draw the table, by its suffix .png, .svg or .pdf")
    args = parser.parse_args(words)
    from ..cluster.paper import experiment, show  # needs more than a plain run does

    rows = experiment.reproduce(args.table)
    print(json.dumps(show.facts(rows)) if args.json else show.text(rows))
    if args.plot:
        show.plot(rows, args.plot)
    return 0


def _growth(words: list[str]) -> int:
    from ..cluster import growth

    parser = argparse.ArgumentParser(prog="python -m motes cluster growth", usage=USAGE)
    parser.add_argument(
        "--ranks", default=",".join(map(str, growth.RANKS)), help="numbers of ranks, from 3 on"
    )
    parser.add_argument("--births", default="calculators", help=f"of {', '.join(growth.WAYS)}")
    parser.add_argument("--pictures", action="store_true", help="draw them too: one image generator for all")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--plot", metavar="FILE", help="draw it, by its suffix .png, .svg or .pdf")
    args = parser.parse_args(words)
    try:
        ranks = [int(text) for text in args.ranks.split(",")]
    except ValueError:
        parser.error(f"--ranks takes whole numbers, got {args.ranks}")
    if min(ranks) < 3:
        parser.error("--ranks takes numbers from 3 on: one draws, one manages, the others calculate")
    ways = args.births.split(",")
    rows = [row for way in ways for row in growth.grow(ranks, way, pictures=args.pictures)]
    print(json.dumps(growth.facts(rows)) if args.json else growth.text(rows))
    if args.plot:
        growth.plot(rows, args.plot)
    return 0
