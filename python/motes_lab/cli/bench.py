"""Measure this machine.

  python -m motes bench snow
  python -m motes bench render --size 1280x720 --json

Figures are the median or the minimum of several repeats, in CPU time of one thread, to reduce the effect of
other programs. Ratios compare figures of one run.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Mapping, Sequence
from typing import Any

from motes.cli.parser import add_json, positive, print_figures

from .parser import add_commands, size

__all__ = ["configure", "run"]

_OWN = (
    "checkpoint",
    "compare",
    "costs",
    "export",
    "live",
    "meetings",
    "paths",
    "peers",
    "recording",
    "recovery",
    "sums",
)
_MODULES = {"balance": "balancers", "overhead": "balancers", **dict(zip(_OWN, _OWN, strict=True))}
"""In which module of `bench` a benchmark is; the others are in `kernels`."""
_COMPARED = ("snow", "fountain", "render", "meetings", "births")


def add_busy(parser: argparse.ArgumentParser) -> None:
    """Add `--busy`."""
    parser.add_argument(
        "--busy", action="store_true", help="print ratios although other programs use this machine"
    )


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the benchmarks and their arguments."""
    names = add_commands(parser, "NAME")
    for scene in ("snow", "fountain"):
        act = names.add_parser(scene, help=f"the paper's {scene} on one core, compared with memory's speed")
        act.add_argument("--particles", type=positive, default=16_000_000, help="more than the caches hold")
        act.add_argument("--steps", type=positive, default=10)
    actions = names.add_parser("actions", help="what each action costs, alone and added to a list")
    actions.add_argument("--particles", type=positive, default=3_200_000)
    actions.add_argument("--repeats", type=positive, default=7)
    lists = names.add_parser("lists", help="lists of four to twelve actions, compared with memory's speed")
    lists.add_argument("--particles", type=positive, default=3_200_000)
    lists.add_argument("--steps", type=positive, default=30)
    meshes = names.add_parser("meshes", help="bounces off a mesh of 10,000 triangles, compared with a sphere")
    meshes.add_argument("--particles", type=positive, default=1_000_000)
    meshes.add_argument("--repeats", type=positive, default=7)
    scale = names.add_parser("scale", help="snow's cost per particle, from a million particles up")
    scale.add_argument("--particles", type=positive, default=100_000_000, help="the largest number")
    scale.add_argument("--steps", type=positive, default=7)
    recording = names.add_parser("recording", help="what Python costs per frame: 8 systems of 12 actions")
    recording.add_argument("--systems", type=positive, default=8)
    recording.add_argument("--frames", type=positive, default=200)
    sums = names.add_parser("sums", help="totals, histograms and tallies, compared with reading a column")
    sums.add_argument("--particles", type=positive, default=3_200_000)
    sums.add_argument("--repeats", type=positive, default=7)
    checkpoint = names.add_parser("checkpoint", help="checkpoints written to disk while frames continue")
    checkpoint.add_argument("--particles", type=positive, default=400_000, help="per system")
    checkpoint.add_argument("--systems", type=positive, default=8)
    checkpoint.add_argument("--every", type=positive, default=48, help="frames")
    checkpoint.add_argument("--repeats", type=positive, default=5)
    recovery = names.add_parser("recovery", help="replicas in memory, and the loss of a rank")
    recovery.add_argument("--particles", type=positive, default=400_000, help="per system")
    recovery.add_argument("--systems", type=positive, default=8)
    recovery.add_argument("--ranks", type=positive, default=2)
    recovery.add_argument("--repeats", type=positive, default=5)
    export = names.add_parser("export", help="particles to files, by format, compared with a plain write")
    export.add_argument("--particles", type=positive, default=1_000_000)
    export.add_argument("--repeats", type=positive, default=7)
    live = names.add_parser("live", help="from a viewer's order to the picture that shows it")
    live.add_argument("--particles", type=positive, default=50_000)
    live.add_argument("--size", type=size, default=(1280, 720), metavar="WxH")
    live.add_argument("--ranks", type=positive, default=2)
    live.add_argument("--orders", type=positive, default=60)
    leavers = names.add_parser("leavers", help="ways to find the particles that left a domain")
    leavers.add_argument("--particles", type=positive, default=3_200_000)
    leavers.add_argument("--steps", type=positive, default=10)
    leavers.add_argument("--bins", type=positive, default=64)
    births = names.add_parser(
        "births", help="what a birth costs the calculators that create it and pass it on"
    )
    births.add_argument("--calculators", type=positive, default=4094)
    births.add_argument("--births", type=positive, default=1389, help="per frame and calculator")
    births.add_argument("--repeats", type=positive, default=1000)
    render = names.add_parser(
        "render", help="a whole frame on one core: project, splat, tone map; all kinds and blends"
    )
    render.add_argument("--particles", type=positive, default=3_200_000)
    render.add_argument("--size", type=size, default=(1920, 1080), metavar="WxH")
    render.add_argument("--pixels", type=positive, default=5, help="diameter of the discs")
    render.add_argument("--frames", type=positive, default=9)
    render.add_argument("--fountain", action="store_true", help="eight fountains instead of snow")
    scenery = names.add_parser("scenery", help="external objects on one core: rays, shadows, lights")
    scenery.add_argument("--size", type=size, default=(1280, 720), metavar="WxH")
    scenery.add_argument("--frames", type=positive, default=9)
    costs = names.add_parser("costs", help="what parts of a picture cost: pixels, records, bytes, messages")
    costs.add_argument("--particles", type=positive, default=1_000_000)
    costs.add_argument("--size", type=size, default=(1920, 1080), metavar="WxH")
    costs.add_argument("--repeats", type=positive, default=7)
    paths = names.add_parser("paths", help="whole frames with pictures on several ranks, by who draws")
    paths.add_argument("--particles", type=positive, default=3_200_000)
    paths.add_argument("--size", type=size, default=(1920, 1080), metavar="WxH")
    paths.add_argument("--path", choices=("auto", "gather", "tiles", "composite"), default="auto")
    paths.add_argument("--far", action="store_true", help="all particles in a few pixels")
    paths.add_argument("--blend", choices=("add", "alpha", "opaque"), default="add")
    paths.add_argument("--objects", action="store_true", help="solids in view")
    paths.add_argument("--parts", action="store_true", help="also the processor time of each part, by rank")
    paths.add_argument(
        "--layouts",
        nargs="+",
        choices=("1", "2 apart", "2 threads", "2 shared", "2 paper", "3 paper", "4 paper"),
        default=("1", "2 apart", "2 threads", "2 shared", "3 paper", "4 paper"),
        help="ranks, roles and threads; the others are compared with the first, and with two separate jobs",
    )
    paths.add_argument("--rounds", type=positive, default=5, help="jobs per layout")
    paths.add_argument("--frames", type=positive, default=16, help="per job")
    balance = names.add_parser("balance", help="balancers compared on synthetic and recorded loads")
    balance.add_argument("--calculators", type=positive, default=16)
    balance.add_argument("--particles", type=positive, default=3_200_000)
    balance.add_argument("--frames", type=positive, default=200)
    balance.add_argument("--run", metavar="DIR", help="the log of a run, instead of synthetic loads")
    overhead = names.add_parser("overhead", help="what balancers cost per frame with nothing to balance")
    overhead.add_argument("--ranks", type=positive, default=4)
    overhead.add_argument("--systems", type=positive, default=8)
    overhead.add_argument("--particles", type=positive, default=400_000, help="per system")
    overhead.add_argument("--rounds", type=positive, default=40, help="turns per balancer")
    overhead.add_argument("--frames", type=positive, default=4, help="per turn")
    meetings = names.add_parser("meetings", help="what actions between particles cost")
    meetings.add_argument("--particles", type=positive, default=400_000)
    meetings.add_argument("--repeats", type=positive, default=7)
    compare = names.add_parser(
        "compare",
        example=".venv-old/bin/python",
        help="this install and another one in turn: what became slower",
    )
    compare.add_argument("old_python", metavar="OLD_PYTHON", help="the Python of the other install")
    compare.add_argument("--rounds", type=positive, default=7, help="turns of each install")
    compare.add_argument("--only", nargs="+", choices=_COMPARED, help="only these benchmarks")
    add_busy(compare)
    peers = names.add_parser(
        "peers", help="compare the engine with LAMMPS (grains, spheres), NumPy, Numba, Taichi and Warp (snow)"
    )
    peers.add_argument("--particles", type=positive, default=12_800_000)
    peers.add_argument("--steps", type=positive, default=9)
    peers.add_argument(
        "--threads", type=positive, default=1, help="if more than one: a second run on that many threads"
    )
    peers.add_argument("--collide", type=positive, default=400_000, help="spheres to compare with LAMMPS")
    peers.add_argument(
        "--grains",
        type=positive,
        default=37_000,
        help="grains in a bed, and on a chute, to compare with LAMMPS",
    )
    peers.add_argument(
        "--lammps",
        metavar="PYTHON",
        nargs="?",
        const=sys.executable,
        help="only the comparison with LAMMPS, run by this Python (the current one)",
    )
    add_busy(peers)
    for command in names.choices.values():
        add_json(command)


def run(args: argparse.Namespace) -> int:
    """Run a benchmark and print its figures."""
    sizes = {name: value for name, value in vars(args).items() if name not in ("name", "json")}
    figures = _measure(args.name, sizes)
    print_figures(args, figures, _SHOWN.get(args.name, _listed)(figures))
    return 1 if figures.get("slower") else 0


def _measure(name: str, sizes: dict[str, Any]) -> dict[str, Any]:
    """Call the function of a benchmark; only its module is imported."""
    if name in ("snow", "fountain"):
        return _measure("scene", {"name": name, **sizes})
    module = importlib.import_module(f"..bench.{_MODULES.get(name, 'kernels')}", __package__)
    measured: dict[str, Any] = getattr(module, name)(**sizes)
    return measured


def _listed(figures: Mapping[str, Any]) -> str:
    """Show one figure per line."""
    width = max(map(len, figures))
    return "\n".join(f"{name:<{width}}  {_shown(value)}" for name, value in figures.items())


def _costs(figures: Mapping[str, Any]) -> str:
    """Show the costs of actions as a table, nanoseconds per particle."""
    actions: dict[str, dict[str, float]] = figures["actions"]
    names = list(next(iter(actions.values())))
    heads = [name.removesuffix("_ns").replace("_", " ") for name in names]
    lines = [f"{'ns per particle and step':<28}" + "".join(f"{head:>17}" for head in heads)]
    lines += [
        f"{action:<28}" + "".join(f"{cost[name]:>17.3g}" for name in names)
        for action, cost in actions.items()
    ]
    about = ", ".join(f"{k} {v}" for k, v in figures.items() if k != "actions")
    return "\n".join([*lines, "", about])


def _table(figures: Mapping[str, Any]) -> str:
    """Show a comparison of balancers as aligned columns."""
    names = list(figures["rows"][0])
    lines = [[name.replace("_", " ") for name in names]]
    lines += [["-" if row[n] is None else _shown(row[n]) for n in names] for row in figures["rows"]]
    widths = [max(len(line[i]) for line in lines) for i in range(len(names))]
    text = [
        "  ".join(
            cell.ljust(w) if isinstance(value, str) else cell.rjust(w)
            for cell, w, value in zip(line, widths, figures["rows"][0].values(), strict=True)
        ).rstrip()
        for line in lines
    ]
    if "planning_ms" not in figures:
        about = ", ".join(f"{k} {v}" for k, v in figures.items() if k not in ("rows", "parts"))
        return "\n".join([*text, "", about, *_parts(figures.get("parts", {}))])
    planning = ", ".join(f"{name} {ms:.3f} ms" for name, ms in figures["planning_ms"].items())
    return "\n".join([*text, "", f"planning for {figures['planning_calculators']} calculators: {planning}"])


def _parts(parts: Mapping[str, Mapping[str, list[float]]]) -> list[str]:
    """Show the time of each part on each rank, one table per layout; omit parts below 0.01 ms."""
    lines = []
    for layout, spent in parts.items():
        lines += ["", f"{layout}: processor time per frame, ms: each rank, then the sum"]
        for name, each in spent.items():
            if max(each) >= 0.01:
                lines.append(f"{name:<24}" + "".join(f"{ms:>8.2f}" for ms in (*each, sum(each))))
    return lines


def _meetings(figures: Mapping[str, Any]) -> str:
    """Show the costs of interactions as a table."""
    seen = f"{figures['neighbours']:.1f} neighbours each"
    lines = [f"{figures['particles']} particles, {seen}, one core, {figures['simd']}"]
    lines += [f"{row['action']:24} {row['ns']:8.1f} ns per particle and sub-step" for row in figures["rows"]]
    return "\n".join(lines)


def _checkpoint(figures: Mapping[str, Any]) -> str:
    """Show how long a frame waits, and how long the thread writes."""
    return "\n".join(
        [
            f"{figures['particles']} particles, {figures['megabytes']:.0f} MB "
            f"every {figures['every']} frames",
            f"a frame                      {figures['frame_ms']:8.1f} ms",
            f"waits for a checkpoint       {figures['wait_ms']:8.1f} ms  "
            f"{figures['percent_of_frames']:.1f} % of the frames' time",
            f"written in the background in {figures['write_ms']:8.1f} ms  "
            f"{figures['percent_with_writing']:.1f} % including the slowdown",
            f"a plain write of these bytes {figures['plain_write_ms']:8.1f} ms",
        ]
    )


def _recovery(figures: Mapping[str, Any]) -> str:
    """Show the costs of replicas and of a loss."""
    return "\n".join(
        [
            f"{figures['particles']} particles on {figures['ranks']} ranks, "
            f"replicas every {figures['every']} frames",
            f"a frame                      {figures['frame_ms']:8.1f} ms",
            f"extra time with replicas     {figures['replicas_ms']:8.1f} ms  "
            f"{figures['percent_of_frames']:.1f} % of the frames' time",
            f"the loss of a rank           {figures['recovery_ms']:8.1f} ms  "
            "until its frame is complete without it",
        ]
    )


def _export(figures: Mapping[str, Any]) -> str:
    """Show the formats as a table, and those whose package is not installed."""
    lines = [f"{'processor time per million particles':<38}{'ms':>8}{'MB':>8}{'/ plain write':>16}"]
    lines += [
        f"{row['format']:<38}{row['ms']:>8.1f}{row['megabytes']:>8.1f}{row['by_plain']:>16.2f}"
        for row in figures["rows"]
    ]
    lines += [f"{name}: not installed" for name in figures["not_installed"]]
    return "\n".join(
        [*lines, f"copying them first: {figures['copy_ms']:.1f} ms, during which the frame waits"]
    )


def _compare(figures: Mapping[str, Any]) -> str:
    """Show the ratios with their spread, and the rows that became slower."""
    width = max(len(row["row"]) for row in figures["rows"])
    lines = [f"{'':<{width}}{'before':>10}{'now':>10}{'ratio':>8}   quartiles"]
    for row in figures["rows"]:
        times = f"{row['before']:>10.4g}{row['now']:>10.4g}{row['ratio']:>8.3f}"
        lines.append(f"{row['row']:<{width}}{times}   {row['low']:.3f} .. {row['high']:.3f}")
    about = f"{figures['rounds']} rounds; other programs used {figures['others']:.2f} processors"
    if not figures["judged"]:
        return "\n".join([*lines, "", f"{about}: not judged"])
    return "\n".join([*lines, "", about, *(f"slower: {name}" for name in figures["slower"])])


def _peers(figures: Mapping[str, Any]) -> str:
    """Show the peers as tables, the work that each leaves out, and those that are not installed."""
    lines = [line for name, what in _BEDS.items() if figures[name] for line in _bed(figures[name], what)]
    lines += _snow(figures["rows"]) if figures["rows"] else ()
    lines += _colliding(figures["collide"]) if figures["collide"] else ()
    lines += [f"{name:<8}{why}" for name, why in figures["not_installed"].items()]
    about = ", ".join(f"{name} {figures[name]}" for name in ("particles", "steps", "simd") if name in figures)
    machine = f"{figures['processor']}, {figures['cores']} cores, {figures['date']}"
    return "\n".join([*lines, about, f"{machine}; others used {figures['others']:.2f} processors"])


def _snow(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Show snow's steps of each peer."""
    lines = [f"{'':<8}{'threads':>8}{'M updates/s':>13}{'engine / peer':>13}"]
    lines += [
        f"{row['peer']:<8}{row['threads']:>8}{row['million_per_s']:>13.0f}{row['engine_by_peer']:>13.2f}"
        for row in rows
    ]
    out = {row["peer"]: row["leaves_out"] for row in rows if row["leaves_out"]}
    return [*lines, "", "left out:", *(f"{name:<8}{what}" for name, what in out.items()), ""]


def _colliding(figures: Mapping[str, Any]) -> list[str]:
    """Show `collide` compared with LAMMPS."""
    lines = [f"{row['peer']:<32}{row['ns']:>9.1f}{row['engine_by_peer']:>13.2f}" for row in figures["rows"]]
    seen = f"{figures['neighbours']:.1f} neighbours each"
    about = f"{figures['spheres']} spheres, {seen}, LAMMPS {figures['lammps']}"
    return [about, f"{'':<32}{'ns':>9}{'engine / peer':>13}", *lines, ""]


_BEDS = {"bed": "at rest in a box", "chute": "flowing down a chute"}


def _bed(figures: Mapping[str, Any], what: str) -> list[str]:
    """Show grains compared with LAMMPS."""
    lines = []
    for row in figures["rows"]:
        timed = f"{row['ns']:>9.1f}{row['engine_by_peer']:>13.2f}"
        lines.append(f"{row['peer']:<8}{row['ranks']:>6}{timed}   {row['leaves_out']}")
    about = f"{figures['grains']} grains {what}, {figures['touching']:.2f} contacts each"
    about += f", LAMMPS {figures['lammps']}"
    return [about, f"{'':<8}{'ranks':>6}{'ns':>9}{'engine / peer':>13}   left out", *lines, ""]


def _shown(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:,.0f}" if value >= 1e5 else f"{value:.4g}"
    return str(value)


_SHOWN = {
    "actions": _costs,
    "balance": _table,
    "checkpoint": _checkpoint,
    "compare": _compare,
    "export": _export,
    "recovery": _recovery,
    "overhead": _table,
    "paths": _table,
    "meetings": _meetings,
    "peers": _peers,
    "render": _table,
}
