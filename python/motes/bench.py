"""Benchmarks of this machine: `python -m motes bench NAME`.

Figures are medians; ratios compare one run with itself.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from typing import Any

from . import _core

__all__ = ["main"]


def main(words: Sequence[str]) -> int:
    """Run a benchmark and print its figures, with --json as one object."""
    arguments = _parser().parse_args(words)
    figures = _RUNS[arguments.name](arguments)
    if arguments.json:
        print(json.dumps(figures))
        return 0
    if arguments.name == "balance":
        print(_table(figures))
        return 0
    width = max(map(len, figures))
    for name, value in figures.items():
        print(f"{name:<{width}}  {_shown(value)}")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m motes bench", description=__doc__)
    names = parser.add_subparsers(dest="name", required=True, metavar="NAME")
    for scene in ("snow", "fountain"):
        act = names.add_parser(
            scene, help=f"the paper's {scene} list on one core, against the memory's speed"
        )
        act.add_argument("--particles", type=_positive, default=3_200_000)
        act.add_argument("--steps", type=_positive, default=10)
    leavers = names.add_parser("leavers", help="ways to find the particles that left a domain")
    leavers.add_argument("--particles", type=_positive, default=3_200_000)
    leavers.add_argument("--steps", type=_positive, default=10)
    leavers.add_argument("--bins", type=_positive, default=64)
    render = names.add_parser("render", help="a whole frame on one core: project, splat, tone map")
    render.add_argument("--particles", type=_positive, default=3_200_000)
    render.add_argument("--size", type=_size, default=(1920, 1080), metavar="WxH")
    render.add_argument("--pixels", type=_positive, default=5, help="diameter of the discs")
    render.add_argument("--frames", type=_positive, default=9)
    render.add_argument("--fountain", action="store_true", help="eight fountains instead of snow")
    balance = names.add_parser("balance", help="balancers compared on made-up and recorded loads")
    balance.add_argument("--calculators", type=_positive, default=16)
    balance.add_argument("--particles", type=_positive, default=3_200_000)
    balance.add_argument("--frames", type=_positive, default=200)
    balance.add_argument("--run", metavar="DIR", help="the log of a run, instead of made-up loads")
    for command in names.choices.values():
        command.add_argument("--json", action="store_true", help="print one JSON object")
    return parser


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"must be 1 or more, got {text}")
    return value


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    return _positive(width), _positive(height)


def _act(arguments: argparse.Namespace) -> dict[str, Any]:
    figures = _core.act_bench(arguments.name, arguments.particles, arguments.steps)
    return {
        "scene": arguments.name,
        "particles": arguments.particles,
        "steps": arguments.steps,
        "cores": 1,
        "simd": _core.simd(),
        **figures,
    }


def _leavers(arguments: argparse.Namespace) -> dict[str, Any]:
    seconds = _core.leaver_bench(arguments.particles, arguments.bins, arguments.steps)
    n = arguments.particles
    return {
        "particles": n,
        "bins": arguments.bins,
        "simd": _core.simd(),
        **{f"{way.removesuffix('_s')}_ns_per_particle": 1e9 * s / n for way, s in seconds.items()},
    }


def _render(arguments: argparse.Namespace) -> dict[str, Any]:
    width, height = arguments.size
    return _core.render_bench(
        arguments.particles, width, height, arguments.pixels, arguments.frames, arguments.fountain
    )


def _balance(arguments: argparse.Namespace) -> dict[str, Any]:
    """Compare balancers; --run needs pandas, made-up loads need nothing."""
    from .replay.compare import candidates, compare, planning_ms
    from .replay.history import History, Recorded
    from .replay.synthetic import LOADS, synthetic

    histories: dict[str, History] = {}
    if arguments.run is not None:
        from .analysis import open_run

        histories[arguments.run] = Recorded(open_run(arguments.run))
    else:
        size = {"calculators": arguments.calculators, "particles": arguments.particles}
        histories = {load: synthetic(load, **size, frames=arguments.frames) for load in LOADS}
    rows = []
    for load, history in histories.items():
        speeds = history.moment(0, 0).speeds
        rows += [{"load": load, **row} for row in compare(history, candidates(speeds))]
    many = 4096
    planning = {type(b).__name__: planning_ms(b, many) for b in candidates([1.0] * many)}
    return {"rows": rows, "planning_calculators": many, "planning_ms": planning}


def _table(figures: dict[str, Any]) -> str:
    """Show a comparison as aligned columns."""
    names = list(figures["rows"][0])
    lines = [[name.replace("_", " ") for name in names]]
    lines += [["-" if row[n] is None else _shown(row[n]) for n in names] for row in figures["rows"]]
    widths = [max(len(line[i]) for line in lines) for i in range(len(names))]
    text = [
        "  ".join(
            cell.ljust(w) if i < 2 else cell.rjust(w)
            for i, (cell, w) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in lines
    ]
    planning = ", ".join(f"{name} {ms:.3f} ms" for name, ms in figures["planning_ms"].items())
    return "\n".join([*text, "", f"planning for {figures['planning_calculators']} calculators: {planning}"])


def _shown(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:,.0f}" if value >= 1e5 else f"{value:.4g}"
    return str(value)


_RUNS = {"snow": _act, "fountain": _act, "leavers": _leavers, "render": _render, "balance": _balance}
