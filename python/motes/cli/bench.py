"""Benchmarks of this machine: `python -m motes bench NAME`.

Figures are medians, or the least of some repeats, of this thread's CPU time: what else runs on the machine
counts as little as can be. Ratios compare one run with itself.
"""

from __future__ import annotations

import argparse
import json
import platform
import statistics
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .. import _core, launch
from ..errors import MotesError

__all__ = ["main"]


def main(words: Sequence[str]) -> int:
    """Run a benchmark and print its figures, with --json as one object."""
    arguments = _parser().parse_args(words)
    figures = _RUNS[arguments.name](arguments)
    if arguments.json:
        print(json.dumps(figures))
        return 0
    if arguments.name in ("balance", "overhead"):
        print(_table(figures))
        return 0
    if arguments.name == "actions":
        print(_costs(figures))
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
        act.add_argument("--particles", type=_positive, default=16_000_000, help="more than caches hold")
        act.add_argument("--steps", type=_positive, default=10)
    actions = names.add_parser("actions", help="what each action costs, alone and added to a list")
    actions.add_argument("--particles", type=_positive, default=3_200_000)
    actions.add_argument("--repeats", type=_positive, default=7)
    lists = names.add_parser("lists", help="a list of twelve actions against one of five")
    lists.add_argument("--particles", type=_positive, default=3_200_000)
    lists.add_argument("--steps", type=_positive, default=30)
    scale = names.add_parser("scale", help="snow's cost a particle from a million particles on")
    scale.add_argument("--particles", type=_positive, default=100_000_000, help="how far")
    scale.add_argument("--steps", type=_positive, default=7)
    recording = names.add_parser("recording", help="what Python costs a frame: 8 systems of 12 actions")
    recording.add_argument("--systems", type=_positive, default=8)
    recording.add_argument("--frames", type=_positive, default=200)
    leavers = names.add_parser("leavers", help="ways to find the particles that left a domain")
    leavers.add_argument("--particles", type=_positive, default=3_200_000)
    leavers.add_argument("--steps", type=_positive, default=10)
    leavers.add_argument("--bins", type=_positive, default=64)
    births = names.add_parser("births", help="what a birth costs the calculators that make and pass it on")
    births.add_argument("--calculators", type=_positive, default=4094)
    births.add_argument("--births", type=_positive, default=1389, help="a frame, of one calculator")
    births.add_argument("--repeats", type=_positive, default=1000)
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
    overhead = names.add_parser("overhead", help="what balancers cost a frame with nothing to balance")
    overhead.add_argument("--ranks", type=_positive, default=4)
    overhead.add_argument("--systems", type=_positive, default=8)
    overhead.add_argument("--particles", type=_positive, default=400_000, help="of each system")
    overhead.add_argument("--rounds", type=_positive, default=40, help="turns of each balancer")
    overhead.add_argument("--frames", type=_positive, default=4, help="of a turn")
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


def _actions(arguments: argparse.Namespace) -> dict[str, Any]:
    return {
        "machine": _machine(),
        "particles": arguments.particles,
        "repeats": arguments.repeats,
        "cores": 1,
        "simd": _core.simd(),
        "actions": _core.action_bench(arguments.particles, arguments.repeats),
    }


def _births(arguments: argparse.Namespace) -> dict[str, Any]:
    return {
        "calculators": arguments.calculators,
        "births": arguments.births,
        "repeats": arguments.repeats,
        "cores": 1,
        "simd": _core.simd(),
        **_core.birth_bench(arguments.calculators, arguments.births, arguments.repeats),
    }


def _machine() -> str:
    """Name the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def _lists(arguments: argparse.Namespace) -> dict[str, Any]:
    return {
        "particles": arguments.particles,
        "steps": arguments.steps,
        "cores": 1,
        "simd": _core.simd(),
        **_core.list_bench(arguments.particles, arguments.steps),
    }


def _scale(arguments: argparse.Namespace) -> dict[str, Any]:
    """Time snow on 1, 3, 10, 30.. million particles, in turn: a slow moment does not hit one size alone.

    With what memory allows: loads and stores alone are faster where a cache holds the particles.
    """
    most = arguments.particles
    sizes = sorted({min(n * 10**k, most) for n in (1, 3) for k in range(6, 9)})
    cost: dict[int, list[float]] = {n: [] for n in sizes}
    limit: dict[int, list[float]] = {n: [] for n in sizes}
    for _ in range(3):
        for n in sizes:
            steps = max(arguments.steps, 10_000_000 // n)
            figures = _core.act_bench("snow", n, steps)
            cost[n].append(1e9 / figures["updates_per_s"])
            limit[n].append(1e9 / figures["memory_limit_updates_per_s"])
    least = {n: min(ns) for n, ns in cost.items()}
    return {
        "scene": "snow",
        "cores": 1,
        "simd": _core.simd(),
        **{f"ns_per_particle_{n}": ns for n, ns in least.items()},
        **{f"memory_limit_ns_{n}": min(ns) for n, ns in limit.items()},
        "largest_by_least": max(least.values()) / min(least.values()),
    }


def _recording(arguments: argparse.Namespace) -> dict[str, Any]:
    """Time the calls of a frame, and the frame without particles, in CPU time of this thread."""
    from ..shapes import Box, Plane
    from ..world import World

    world = World(seed=1, dt=1 / 24, progress="off")
    systems = [world.system(f"system {i}") for i in range(arguments.systems)]
    gust, ground, far = (
        Box((-2, -1, -2), (2, 1, 2)),
        Plane((0, 0, 0), (0, 1, 0)),
        Box((90, 90, 90), (91, 91, 91)),
    )
    calls, steps = [], []
    with world:
        for _ in world.frames(arguments.frames):
            start = time.thread_time()
            for s in systems:
                s.gravity((0, -9.81, 0))
                s.random_acceleration(gust)
                s.damping((0.9, 0.9, 0.9))
                s.wind((1, 0, 0), drag=0.5)
                s.orbit_point((0, 5, 0), magnitude=1, epsilon=0.1)
                s.target_color((1, 0.5, 0.2), alpha=1, scale=0.5)
                s.speed_clamp(max_speed=10)
                s.bounce(ground, restitution=0.5)
                s.sink(far)
                s.sink_velocity(far)
                s.kill_old(10)
                s.move()
            called = time.thread_time()
            world.step()
            calls.append(called - start)
            steps.append(time.thread_time() - called)
    return {
        "systems": arguments.systems,
        "actions": 12 * arguments.systems,
        "frames": arguments.frames,
        "calls_ms": 1e3 * statistics.median(calls),
        "empty_step_ms": 1e3 * statistics.median(steps),
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
    from ..replay.compare import candidates, compare, planning_ms
    from ..replay.history import History, Recorded
    from ..replay.synthetic import LOADS, synthetic

    histories: dict[str, History] = {}
    if arguments.run is not None:
        from ..analysis import open_run

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


def _overhead(arguments: argparse.Namespace) -> dict[str, Any]:
    """Start a job in which worlds with each balancer take turns, and return what its first rank says."""
    sizes = [f"--{name}={getattr(arguments, name)}" for name in ("systems", "particles", "rounds", "frames")]
    words = launch.command(arguments.ranks, [sys.executable, "-m", "motes.bench.overhead", *sizes])
    job = subprocess.run(words, check=False, capture_output=True, text=True)
    lines = [line for line in job.stdout.splitlines() if line.startswith("{")]
    if job.returncode != 0 or not lines:
        raise MotesError(f"the job on {arguments.ranks} ranks failed:\n{job.stderr}")
    figures: dict[str, Any] = json.loads(lines[-1])
    return figures


def _costs(figures: dict[str, Any]) -> str:
    """Show the costs of actions as a table, nanoseconds a particle."""
    actions: dict[str, dict[str, float]] = figures["actions"]
    names = list(next(iter(actions.values())))
    heads = [name.removesuffix("_ns").replace("_", " ") for name in names]
    lines = [f"{'ns a particle and step':<28}" + "".join(f"{head:>17}" for head in heads)]
    lines += [
        f"{action:<28}" + "".join(f"{cost[name]:>17.3g}" for name in names)
        for action, cost in actions.items()
    ]
    about = ", ".join(f"{k} {v}" for k, v in figures.items() if k != "actions")
    return "\n".join([*lines, "", about])


def _table(figures: dict[str, Any]) -> str:
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
        return "\n".join([*text, "", ", ".join(f"{k} {v}" for k, v in figures.items() if k != "rows")])
    planning = ", ".join(f"{name} {ms:.3f} ms" for name, ms in figures["planning_ms"].items())
    return "\n".join([*text, "", f"planning for {figures['planning_calculators']} calculators: {planning}"])


def _shown(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:,.0f}" if value >= 1e5 else f"{value:.4g}"
    return str(value)


_RUNS = {
    "snow": _act,
    "fountain": _act,
    "actions": _actions,
    "lists": _lists,
    "scale": _scale,
    "recording": _recording,
    "births": _births,
    "leavers": _leavers,
    "render": _render,
    "balance": _balance,
    "overhead": _overhead,
}
