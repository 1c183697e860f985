"""Make the tables and plot of docs/lab/decompositions.md.

Run `python docs/lab/scripts/make_decompositions.py [real] [virtual]`.

real: snow, fountain, heap and flock of examples/ with slabs, bricks and domains by id, on real ranks.
virtual: snow and the fountains again, and crowds that interact (decompositions_crowds.py), on up to 1024
virtual ranks; needs SimGrid. The named parts are measured again; decompositions.json keeps the figures for
tables and plot.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

import motes
from motes.analysis.run import Run

DOCS = Path(__file__).resolve().parents[2]
TARGET = DOCS / "lab" / "decompositions.png"
FIGURES = Path(__file__).with_name("decompositions.json")
EXAMPLES = DOCS.parent / "examples"

SCENES = ("snow", "fountain", "heap", "flock")
BALANCED = "balanced fountain"
"""The fountains again on virtual ranks, with cuts that follow the drops."""
BALLS = ("ball", "ball in equal blocks")
"""The flock as a ball, with cuts at quantiles like the others, and with domains of equal size."""
CROWDS = ("heap", "flock", *BALLS)
WAYS = ("slabs", "bricks", "by id")
REAL = {
    # Fixed cuts from the first births. Heap and flock leave their birthplace, so their cuts follow them.
    "snow": ("--space=fit", "--balancer=static", "--systems=2", "--particles=100000", "--frames=24"),
    "fountain": ("--space=fit", "--balancer=static", "--systems=2", "--particles=100000", "--frames=24"),
    "heap": ("--balancer=prefix", "--frames=120"),
    "flock": ("--balancer=prefix", "--frames=96"),
}
RANKS = (2, 4, 8, 16)
VIRTUAL = (16, 64, 256, 1024)
FULL = 400_000
"""Particles of a virtual calculator."""
FRAMES = {"snow": 8, "fountain": 8, BALANCED: 8, **dict.fromkeys(CROWDS, 3)}
"""Frames of a virtual run; the first half, with the births, is not measured."""

Figures = dict[str, dict[str, float]]


def axis_of(way: str, scene: str, virtual: bool) -> str:
    """Return the axes to cut: for bricks, those along which particles spread."""
    crowd = dict.fromkeys(CROWDS, "xyz") if virtual else {"heap": "xy"}
    return {"slabs": "x", "bricks": crowd.get(scene, "xz"), "by id": "none"}[way]


def figures_of(run: Run, first: int, scale: float) -> dict[str, float]:
    """Return means over the frames from `first` on, for all calculators together."""
    frames = run.frames[run.frames["frame"] >= first]
    load = run.load[run.load["frame"] >= first]
    count = len(frames)
    shares = load.groupby(["frame", "rank"])["n_end"].sum().unstack()
    interactions = max(float(load.groupby("frame")["interactions"].max().fillna(0).mean()), 1.0)
    particles = float(shares.sum(axis=1).mean())
    moved = float(frames["exchanged_bytes"].sum())
    return {
        "calculators": shares.shape[1],
        "bytes": scale * moved / count,
        "ghosts": float(load["ghosts"].fillna(0).sum()) / count / interactions / particles,
        "share": float((shares.max(axis=1) / shares.mean(axis=1)).mean()),
        "frame_s": float(frames["t_frame_s"].mean()),
    }


def real(scene: str, way: str, ranks: int) -> dict[str, float]:
    """Run an example; the second half of its frames counts."""
    with tempfile.TemporaryDirectory(prefix="motes-decompositions-") as folder:
        log = Path(folder) / "log"
        command = [sys.executable, "-m", "motes", "run", "-n", str(ranks), EXAMPLES / f"{scene}.py"]
        command += [*REAL[scene], f"--axis={axis_of(way, scene, False)}"]
        command += ["--no-images", f"--log={log}", f"--out={folder}"]
        subprocess.run(command, check=True, capture_output=True)
        run = motes.open_run(log)
        return figures_of(run, len(run.frames) // 2, 1)


def virtual(scene: str, way: str, ranks: int) -> dict[str, float]:
    """Simulate a scene of 400 000 particles per calculator, of which a sample is computed."""
    from motes_lab.cluster import Cluster, Node, simulate
    from motes_lab.cluster.growth import network
    from motes_lab.cluster.simulate import record

    calculators = ranks - 2
    computed = min(1000, 500_000 // calculators)
    if scene in CROWDS and way == "by id":  # every calculator has ghosts of all others
        computed = min(computed, 13_000_000 // calculators**2)
    balancer = "prefix" if scene == BALANCED else "static"
    radius = (3 / (4 * math.pi) * FULL * calculators) ** (1 / 3)
    space = f"{-radius},{radius}" if scene == BALLS[1] else "fit"
    options = [f"--axis={axis_of(way, scene, True)}", f"--space={space}", f"--balancer={balancer}"]
    options += [f"--frames={FRAMES[scene]}"]
    if scene in CROWDS:
        script = Path(__file__).with_name("decompositions_crowds.py")
        options += [
            f"--crowd={scene.partition(' ')[0]}",
            f"--calculators={calculators}",
            f"--particles={computed}",
        ]
    else:
        script = EXAMPLES / f"{scene.removeprefix('balanced ')}.py"
        options += ["--systems=2", f"--particles={computed * calculators // 2}"]
    with tempfile.TemporaryDirectory(prefix="motes-decompositions-") as folder:
        file, log = Path(folder) / "scene.motes", Path(folder) / "log"
        record(file, script, ["--no-images", *options])
        cluster = Cluster([Node("node", count=ranks)], network())
        asked = ["--no-images", "--births", "calculators"]
        run = simulate(file, cluster, log=log, scale=FULL / computed, options=asked)
        return figures_of(run, FRAMES[scene] // 2, FULL / computed) | {"computed": computed}


def measure(parts: list[str]) -> dict[str, Figures]:
    """Measure these parts, small runs first; write the figures after each run."""
    known: dict[str, Figures] = json.loads(FIGURES.read_text()) if FIGURES.exists() else {}
    for part in parts:
        for scene, way, ranks in runs(part):
            start = time.monotonic()
            found = (virtual if part == "virtual" else real)(scene, way, ranks)
            known.setdefault(part, {})[f"{scene}, {way}, {ranks}"] = found
            FIGURES.write_text(json.dumps(known, indent=1) + "\n")
            print(part, scene, way, ranks, found, f"{time.monotonic() - start:.0f} s", flush=True)
    return known


def runs(part: str) -> list[tuple[str, str, int]]:
    """Return the runs: with 1022 calculators none by id (a million messages each time) and none balanced."""
    if part == "real":
        return [(scene, way, ranks) for ranks in RANKS for scene in SCENES for way in WAYS]
    every = [
        (scene, way, ranks) for ranks in VIRTUAL for scene in (*SCENES, BALANCED, *BALLS) for way in WAYS
    ]
    few = [(scene, way, n) for scene, way, n in every if n <= 256 or (way != "by id" and scene != BALANCED)]
    return [(scene, way, n) for scene, way, n in few if way != "by id" or scene in SCENES]


def table(part: str, known: Figures) -> str:
    """Return a table of the page."""
    ranks = VIRTUAL if part == "virtual" else RANKS
    heads = [str(max(n - 2, 1)) for n in ranks]
    lines = [f"| scene | | {' | '.join(heads)} |", "|---" * (2 + len(ranks)) + "|"]
    for scene in (*SCENES, BALANCED, *BALLS):
        for way in WAYS:
            if not any(name.startswith(f"{scene}, {way}, ") for name in known):
                continue
            cells = [cell(part, scene, known.get(f"{scene}, {way}, {n}")) for n in ranks]
            lines.append(f"| {scene} | {way} | {' | '.join(cells)} |")
    return "\n".join(lines)


def cell(part: str, scene: str, found: dict[str, Any] | None) -> str:
    """Return the figures of one run as shown on the page."""
    if found is None:
        return ""
    ghosts = f", {short(100 * found['ghosts'])} %" if scene in CROWDS else ""
    if part == "real":
        return f"{found['bytes'] / 1e3:,.0f} kB{ghosts}, {found['share']:.2f}"
    each = found["bytes"] / found["calculators"] / 1e6
    share = f", {found['share']:.2f}" if scene in ("fountain", BALANCED, *BALLS) else ""
    return f"{short(each)} MB{ghosts}{share}, {short(1e3 * found['frame_s'])} ms"


def short(value: float) -> str:
    """Return a number with three digits, or all digits before the point."""
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def plot(known: dict[str, Figures], target: Path = TARGET) -> None:
    """Draw real ranks in the upper two rows, virtual ones below."""
    figure = Figure(figsize=(13, 12), layout="constrained")
    rows = figure.subplots(4, len(SCENES))
    for column, scene in enumerate(SCENES):
        for row, (part, _, value) in zip(rows, PANELS, strict=True):
            ax = row[column]
            curves(ax, scene, known.get(part, {}), value)
            if part == "virtual":
                if scene == "fountain":
                    curves(ax, BALANCED, known[part], value, "--")
                ax.set(xscale="log", yscale="log", xlabel="virtual calculators")
                plain_ticks(ax)
            else:
                ax.set_xlabel("calculators")
            ax.set_xticks([max(n - 2, 1) for n in (VIRTUAL if part == "virtual" else RANKS)])
        rows[0][column].set(title=scene, ylim=(0, None))
        rows[1][column].set_ylim(0.95, max(1.5, rows[1][column].get_ylim()[1]))
    for row, (_, label, _) in zip(rows, PANELS, strict=True):
        row[0].set_ylabel(label)
    rows[0][0].legend()
    rows[2][1].legend(loc="lower right", fontsize="small")
    figure.savefig(target, dpi=110)


PANELS: tuple[tuple[str, str, Callable[[dict[str, float]], float]], ...] = (
    ("real", "kB per frame", lambda found: found["bytes"] / 1e3),
    ("real", "largest share / mean", lambda found: found["share"]),
    ("virtual", "MB per calculator and frame", lambda found: found["bytes"] / found["calculators"] / 1e6),
    ("virtual", "ms per frame", lambda found: 1e3 * found["frame_s"]),
)
"""Rows of the plot: the part, the label, and the value to draw from one run's figures."""


def curves(
    ax: Axes, scene: str, known: Figures, value: Callable[[dict[str, float]], float], line: str = "-"
) -> None:
    """Draw one curve for each way."""
    for number, way in enumerate(WAYS):
        rows = [found for name, found in known.items() if name.startswith(f"{scene}, {way}, ")]
        rows.sort(key=lambda found: found["calculators"])
        if rows:
            label = way if scene != BALANCED else f"{way}, balanced"
            style = {"color": f"C{number}", "marker": "osv"[number], "ms": 5, "label": label}
            ax.plot([f["calculators"] for f in rows], [value(f) for f in rows], line, **style)
    ax.grid(alpha=0.3)


def plain_ticks(ax: Axes) -> None:
    """Label a logarithmic y axis with 1, 2, 5, 10, ..., and the x axis with plain numbers."""
    ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    ax.yaxis.set_minor_locator(NullLocator())
    ax.xaxis.set_minor_locator(NullLocator())
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter(FuncFormatter(lambda at, _: f"{at:g}"))


def main() -> None:
    """Measure, print the tables of the page, draw the plot."""
    known = measure(sys.argv[1:])
    for part, found in known.items():
        print(table(part, found), end="\n\n")
    plot(known)


if __name__ == "__main__":
    main()
