"""Weak scaling of the engine, by phase: a fixed number of particles per rank on many virtual ranks."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from motes import Run

from .._engine import arguments, extras
from .build import find_replay, find_smpirun
from .machines import Cluster, Network, Node
from .simulate import record, simulate

__all__ = ["PHASES", "RANKS", "WAYS", "Row", "facts", "grow", "plot", "text"]

PARTICLES = 400_000
"""Particles per rank."""
COMPUTED = 131_000_000
"""Most particles computed on all ranks; each one stands for several, to make up the full number."""
EACH = 32_000
"""Most particles computed per rank; with much fewer, random differences between ranks would grow."""
PICTURE = (1920, 1080)
"""Pixels."""
METRES = 4.0
"""Width of a rank's domain in metres."""
FRAMES, MEASURED = 5, 3
UNKNOWN = 3
"""Extra frames with pictures: the first ones are divided among ranks by a guess, which delays the next."""
RANKS = (8, 16, 32, 64, 128)
WAYS = {
    "calculators": ("--births", "calculators"),
    "manager": ("--births", "manager", "--fan-out", "1000000"),
}
"""Calculators create births, and messages follow a tree; or the manager creates births and sends them all."""
PHASES = {
    "create": ("create", "wait for births"),
    "act": ("act", "order"),
    "agree": ("report", "judge", "wait for verdict"),
    "exchange": ("send migrants", "receive"),
    "balance": ("plan", "wait for plan", "balance", "compare loads"),
    "render": (
        *("project", "send records", "wait for records", "open tiles", "draw"),
        *("wait for tiles", "assemble"),
    ),
}
"""Phases of a frame, each with its spans (docs/analysis.md)."""
FOLDER = Path(__file__).parent


def network() -> Network:
    """Describe InfiniBand HDR100: 100 Gb/s per node, 1.5 us, 0.3 us of a processor per message.

    The bandwidth is the vendor's; latency and overhead are those of MPI benchmarks on such networks (OSU
    microbenchmarks: 1 to 2 us between nodes, of which each processor takes about 0.3 us). All pairs have the
    full bandwidth, as in a non-blocking fat tree.
    """
    return Network("HDR100", 100e9 / 8, 1.5e-6, overhead_s=0.3e-6, shared=False)


@dataclass(frozen=True)
class Row:
    """The result for one number of ranks."""

    ranks: int
    way: str
    pictures: bool
    computed: int
    """Particles computed per rank."""
    frame_s: float
    """Simulated seconds per frame."""
    phases: dict[str, float]
    """Seconds of each phase, including waits; the mean over all calculators."""
    ideal_s: float
    """Seconds of a frame without waits or messages: a calculator's mean time to act (and project)."""

    @property
    def efficiency(self) -> float:
        """Fraction of the frame that is spent on particles."""
        return self.ideal_s / self.frame_s

    @property
    def talk(self) -> float:
        """Fraction of the frame that create, exchange and balance take."""
        return sum(self.phases[name] for name in ("create", "exchange", "balance")) / self.frame_s


def grow(ranks: Sequence[int] = RANKS, way: str = "calculators", *, pictures: bool = False) -> list[Row]:
    """Run snow on each number of calculators, with one more rank for pictures and one more to manage."""
    find_smpirun(), find_replay(), extras.pandas()  # raise before minutes of work
    arguments.choice("way", way, tuple(WAYS))
    with tempfile.TemporaryDirectory(prefix="motes-growth-") as folder:
        return [_row(Path(folder), count, way, pictures) for count in ranks]


def _row(folder: Path, ranks: int, way: str, pictures: bool) -> Row:
    calculators = ranks - 2
    computed = min(EACH, COMPUTED // calculators)
    half = METRES * calculators / 2
    sizes = [f"--particles={computed * calculators}", f"--space={-half},{half}", f"--width={2 * half}"]
    if pictures:  # from far enough to see all
        sizes += [f"--size={PICTURE[0]}x{PICTURE[1]}", f"--distance={half}"]
    scene, log = folder / f"{ranks}.motes", folder / f"{ranks}"
    frames = FRAMES + (UNKNOWN if pictures else 0)
    record(scene, FOLDER / "paper" / "snow.py", ["--systems=1", f"--frames={frames}", *sizes])
    options = [*WAYS[way], "--balancer", "PrefixCuts", "--spans"]
    options += ["--path", "auto"] if pictures else ["--no-images"]
    run = simulate(
        scene,
        Cluster([Node("node", count=ranks)], network()),
        log=log,
        scale=PARTICLES / computed,
        options=options,
    )
    found = {name: _seconds(run, spans) for name, spans in PHASES.items()}
    found["agree"] -= _seconds(run, ("send migrants",))  # part of the wait for the verdict
    frame_s = float(run.frames["t_frame_s"].iloc[-MEASURED:].mean())
    ideal_s = found["act"] + (_seconds(run, ("project",)) if pictures else 0.0)
    return Row(ranks, way, pictures, computed, frame_s, found, ideal_s)


def _seconds(run: Run, spans: Sequence[str]) -> float:
    """Return the seconds of spans per measured frame, the mean over calculators."""
    calculators = run.facts["calculators"]
    rows = run.spans
    first = rows["frame"].max() + 1 - MEASURED
    wanted = rows["phase"].isin(spans) & rows["rank"].isin(calculators) & (rows["frame"] >= first)
    chosen = rows[wanted]
    return float((chosen["end_s"] - chosen["start_s"]).sum()) / (MEASURED * len(calculators))


def facts(rows: Sequence[Row]) -> dict[str, Any]:
    """Return all figures as plain values."""
    return {
        "particles_a_rank": PARTICLES,
        "rows": [
            {
                "ranks": row.ranks,
                "way": row.way,
                "pictures": row.pictures,
                "computed_a_rank": row.computed,
                "frame_s": row.frame_s,
                "efficiency": row.efficiency,
                "create_exchange_balance": row.talk,
                **{f"{name}_s": seconds for name, seconds in row.phases.items()},
            }
            for row in rows
        ],
    }


def text(rows: Sequence[Row]) -> str:
    """Return a table, one line per number of ranks; phases in percent of the frame."""
    title = (
        f"Weak scaling: snow, {PARTICLES} particles per rank; phases in % of the frame, mean over calculators"
    )
    lines = [title, f"{'ranks':>6} {'births':12}{'frame ms':>10}{'efficiency':>12}"]
    lines[1] += "".join(f"{name:>10}" for name in PHASES) + f"{'c + e + b':>11}"
    for row in rows:
        shares = "".join(f"{100 * row.phases[name] / row.frame_s:10.1f}" for name in PHASES)
        figures = f"{1e3 * row.frame_s:10.3f}{row.efficiency:12.3f}{shares}{100 * row.talk:11.1f}"
        lines.append(f"{row.ranks:6} {row.way:12}{figures}")
    return "\n".join(lines)


def plot(rows: Sequence[Row], path: str | os.PathLike[str]) -> None:
    """Draw each phase's share over the number of ranks, one panel per way."""
    Figure = extras.matplotlib("matplotlib.figure").Figure

    ways = list(dict.fromkeys(row.way for row in rows))
    figure = Figure(figsize=(4.6 * len(ways) + 1, 3.8), layout="constrained")
    panels = figure.subplots(1, len(ways), sharey=True, squeeze=False)[0]
    for panel, way in zip(panels, ways, strict=True):
        chosen = [row for row in rows if row.way == way]
        bottom = [0.0] * len(chosen)
        for number, name in enumerate(PHASES):
            heights = [1e3 * row.phases[name] for row in chosen]
            names = [str(row.ranks) for row in chosen]
            panel.bar(names, heights, bottom=bottom, label=name, color=f"C{number}", width=0.7)
            bottom = [low + more for low, more in zip(bottom, heights, strict=True)]
        panel.set_title(
            f"births by {'calculators, messages along a tree' if way == 'calculators' else 'the manager'}"
        )
        panel.set_xlabel("ranks")
        panel.grid(alpha=0.3, axis="y")
    panels[0].set_ylabel("ms per frame, mean over calculators")
    panels[0].legend()
    figure.savefig(os.fspath(path), dpi=120)
