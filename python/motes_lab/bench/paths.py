"""Times whole frames with pictures on several ranks: `python -m motes bench paths`.

Each layout is a separate job. Layouts take turns, round after round, and ratios compare jobs of one round, so
other programs affect all of them. Besides wall time there is the processor time of the busiest rank: the
least time per frame on a machine with a free processor for each rank.

"2 apart" is the machine's limit for two processors: two independent jobs at the same time, each with half of
the systems and its own picture. They share memory, caches and the host's other load as two ranks or threads
do, but never wait for each other.
"""

from __future__ import annotations

import argparse
import json
import statistics
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

from .jobs import figures_of

__all__ = ["LAYOUTS", "main", "paths"]


class Layout(NamedTuple):
    """The ranks of a job, their roles, threads per rank, and how many such jobs share the systems."""

    ranks: int
    roles: str = "auto"
    threads: int = 1
    jobs: int = 1


APART = "2 apart"
LAYOUTS = {
    "1": Layout(1),
    APART: Layout(1, jobs=2),
    "2 threads": Layout(1, threads=2),
    "2 shared": Layout(2, "shared"),
    "2 paper": Layout(2),
    "3 paper": Layout(3),
    "4 paper": Layout(4),
}
"""In "paper" layouts, which use the roles "auto", manager and image generator have no particles."""
SYSTEMS = 8
WARM = 4  # frames that do not count


def paths(
    *,
    particles: int,
    size: tuple[int, int],
    path: str,
    far: bool,
    blend: str,
    objects: bool,
    parts: bool,
    layouts: Sequence[str],
    rounds: int,
    frames: int,
) -> dict[str, Any]:
    """Time layouts of ranks, and compare them with the first."""
    options = [f"--size={size[0]}x{size[1]}", f"--path={path}", f"--frames={frames}", f"--blend={blend}"]
    for name, wanted in (("far", far), ("objects", objects)):
        options += [f"--{name}"] if wanted else []
    found: dict[str, list[dict[str, Any]]] = {name: [] for name in layouts}
    for number in range(rounds):
        for name in layouts if number % 2 == 0 else reversed(layouts):
            found[name].append(_run(LAYOUTS[name], particles, options, parts))
    rows = [_row(name, found, layouts[0]) for name in layouts]
    facts = {"particles": particles, "width": size[0], "height": size[1], "far": far, "blend": blend}
    facts |= {"objects": objects, "rounds": rounds, "frames": frames, "rows": rows}
    if parts:
        facts["parts"] = {name: found[name][-1]["parts"] for name in layouts}
    return facts


def _row(name: str, found: dict[str, list[dict[str, Any]]], first: str) -> dict[str, Any]:
    """Compare a layout with the first one and with the independent jobs of "2 apart"."""

    def middle(figure: str, of: str) -> float:
        value: float = statistics.median(one[figure] for one in found[of])
        return value

    def faster(figure: str, than: str) -> float:
        pairs = zip(found[than], found[name], strict=True)
        ratio: float = statistics.median(other[figure] / one[figure] for other, one in pairs)
        return ratio

    medians = {
        figure: middle(figure, name) for figure in ("frame_ms", "act_ms", "busiest_cpu_ms", "all_cpu_ms")
    }
    cpu = middle("busiest_cpu_ms", first) / medians["busiest_cpu_ms"]
    row = {"layout": name, "path": found[name][-1]["path"], **medians}
    row |= {"speedup": faster("frame_ms", first), "act_speedup": faster("act_ms", first), "cpu_speedup": cpu}
    return row | ({"of_apart": faster("frame_ms", APART)} if APART in found else {})


def _run(layout: Layout, particles: int, options: Sequence[str], parts: bool) -> dict[str, Any]:
    """Run a layout once; its times are those of its slowest job."""
    share = [f"--particles={particles // layout.jobs}", f"--systems={SYSTEMS // layout.jobs}"]
    with ThreadPoolExecutor(layout.jobs) as pool:
        jobs = list(pool.map(lambda _: _job(layout, [*share, *options], parts), range(layout.jobs)))
    slowest = {name: max(job[name] for job in jobs) for name in ("frame_ms", "act_ms", "busiest_cpu_ms")}
    figures = {"path": jobs[0]["path"], **slowest, "all_cpu_ms": sum(job["all_cpu_ms"] for job in jobs)}
    if parts:
        figures["parts"] = {
            name: [ms for job in jobs for ms in job["parts"][name]] for name in jobs[0]["parts"]
        }
    return figures


def _job(layout: Layout, options: Sequence[str], parts: bool) -> dict[str, Any]:
    """Run one job; with `parts`, log the processor time of each phase on each rank."""
    with tempfile.TemporaryDirectory(prefix="motes-paths-") as folder:
        log = [f"--log={folder}/log"] if parts else []
        how = [f"--roles={layout.roles}", f"--threads={layout.threads}"]
        figures = figures_of("motes_lab.bench.paths", layout.ranks, [*how, *options, *log])
        return figures | ({"parts": _parts(Path(folder) / "log", layout.ranks)} if parts else {})


def _parts(log: Path, ranks: int) -> dict[str, list[float]]:
    """Read a log's spans; return the ms of processor time per phase and rank, medians over frames."""
    found: dict[str, list[float]] = {}
    for rank in range(ranks):
        spent: dict[str, dict[int, float]] = {}
        frames = set()
        for line in (log / f"spans.r{rank:04d}.jsonl").read_text().splitlines():
            span = json.loads(line)
            if span["frame"] < WARM or span["cpu_s"] is None:
                continue
            frames.add(span["frame"])
            part = spent.setdefault(span["phase"], dict.fromkeys(frames, 0.0))
            part[span["frame"]] = part.get(span["frame"], 0.0) + span["cpu_s"]
        for name, seconds in spent.items():
            each = sorted(seconds.get(frame, 0.0) for frame in frames)
            found.setdefault(name, [0.0] * ranks)[rank] = 1e3 * statistics.median(each)
    return found


def _film(arguments: argparse.Namespace) -> dict[str, Any] | None:
    """Run the frames on this rank; rank 0 returns the times."""
    from mpi4py import MPI

    from motes import Camera, Renderer, Sprite, World
    from motes.shapes import Plane, Sphere

    from .._engine import session_of
    from .snow import Snow

    snow = Snow(width=24, top=14, depth=16)
    width, height = map(int, arguments.size.split("x"))
    camera = Camera((0, 7, 2000 if arguments.far else 26), (0, 7, 0))
    background = (0.004, 0.006, 0.014)
    objects = [Plane((0, 0, 0), (0, 1, 0)), Sphere((0, 3, 0), 2)] if arguments.objects else []
    log = {"log": arguments.log, "spans": True} if arguments.log else {}
    world = World(
        seed=1,
        space=(-12, 12),
        roles=arguments.roles,
        threads=arguments.threads,
        renderer=Renderer(
            width, height, camera=camera, path=arguments.path, background=background, objects=objects
        ),
        progress="off",
        **log,
    )
    each = arguments.particles // arguments.systems
    sprite = Sprite(blend=arguments.blend)
    layers = [world.system(f"snow {i}", capacity=2 * each, sprite=sprite) for i in range(arguments.systems)]
    wall, act, cpu = [], [], []
    with world:
        for frame in world.frames(WARM + arguments.frames):
            start, cpu_start = time.perf_counter(), time.process_time()
            for layer in layers:
                snow.record(layer, frame, each)
            world.render()
            wall.append(time.perf_counter() - start)
            cpu.append(time.process_time() - cpu_start)
            act.append(world.timings["t_act_s"])
        path = session_of(world).engine_for("bench").render_path
    everyone = MPI.COMM_WORLD.gather([sum(each[WARM:]) for each in (wall, act, cpu)], root=0)
    if everyone is None:
        return None
    to_ms = 1e3 / arguments.frames
    return {
        "path": path,
        "frame_ms": to_ms * max(one[0] for one in everyone),
        "act_ms": to_ms * max(one[1] for one in everyone),
        "busiest_cpu_ms": to_ms * max(one[2] for one in everyone),
        "all_cpu_ms": to_ms * sum(one[2] for one in everyone),
    }


def main(argv: Sequence[str] | None = None) -> None:
    """Run one rank of a job."""
    parser = argparse.ArgumentParser(prog="python -m motes_lab.bench.paths")
    for name in ("particles", "systems", "frames", "threads"):
        parser.add_argument(f"--{name}", type=int, required=True)
    for name in ("size", "path", "roles", "blend"):
        parser.add_argument(f"--{name}", required=True)
    parser.add_argument("--log", default="")
    for name in ("far", "objects"):
        parser.add_argument(f"--{name}", action="store_true")
    figures = _film(parser.parse_args(argv))
    if figures is not None:
        print(json.dumps(figures), flush=True)


if __name__ == "__main__":
    main()
