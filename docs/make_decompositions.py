"""Make the plot of docs/decompositions.md: `python docs/make_decompositions.py`.

Snow and the fountains of examples/ under slabs, bricks and by id, on real ranks. Cuts are those of the first
births and stay; what then crosses them, and how even the shares are, does not depend on the machine.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from matplotlib.figure import Figure

import motes

TARGET = Path(__file__).with_name("decompositions.png")
EXAMPLES = Path(__file__).parents[1] / "examples"
SCENES = {"snow": "-30,30", "fountain": "-30,30"}
WAYS = {"slabs": "x", "bricks": "xz", "by id": "none"}
RANKS = (2, 4, 8, 16)
FRAMES = 24
PARTICLES = 100_000
"""Of each of two systems."""


def measure(scene: str, way: str, ranks: int) -> tuple[float, float]:
    """Kilobytes exchanged per frame, and the largest share over the mean, as means over the second half."""
    with tempfile.TemporaryDirectory(prefix="motes-decompositions-") as folder:
        log = Path(folder) / "log"
        command = [sys.executable, "-m", "motes", "run", "-n", str(ranks), EXAMPLES / f"{scene}.py"]
        command += ["--no-images", f"--axis={WAYS[way]}", "--space=fit", "--balancer=static", f"--log={log}"]
        command += [f"--frames={FRAMES}", f"--particles={PARTICLES}", "--systems=2", f"--out={folder}"]
        subprocess.run(command, check=True, capture_output=True)
        run = motes.open_run(log)
        half = run.frames["frame"] >= FRAMES // 2
        sums = run.load.groupby(["frame", "rank"])["n_end"].sum().unstack()
        uneven = (sums.max(axis=1) / sums.mean(axis=1))[sums.index >= FRAMES // 2]
        return float(run.frames.loc[half, "exchanged_bytes"].mean()) / 1e3, float(uneven.mean())


Found = dict[tuple[str, str, int], tuple[float, float]]


def plot(found: Found, target: Path = TARGET) -> None:
    """Draw what is exchanged and how even the shares are, over the number of calculators."""
    figure = Figure(figsize=(9.2, 5.2), layout="constrained")
    for row, scene in zip(figure.subplots(2, 2, sharex=True), SCENES, strict=True):
        calculators = [ranks - 2 if ranks > 2 else 1 for ranks in RANKS]
        for way, marker in zip(WAYS, "osv", strict=True):
            values = [found[scene, way, ranks] for ranks in RANKS]
            row[0].plot(calculators, [kb for kb, _ in values], marker + "-", label=way, ms=5)
            row[1].plot(calculators, [uneven for _, uneven in values], marker + "-", label=way, ms=5)
        row[0].set(title=f"{scene}: exchanged", ylabel="kB per frame")
        row[1].set(title=f"{scene}: largest share", ylabel="of the mean")
        for ax in row:
            ax.grid(alpha=0.3)
    for ax in figure.axes[2:]:
        ax.set_xlabel("calculators")
    figure.axes[0].legend()
    figure.savefig(target, dpi=130)


def main() -> None:
    """Measure, print the table of the page, draw the plot."""
    found: Found = {}
    for scene in SCENES:
        for way in WAYS:
            for ranks in RANKS:
                found[scene, way, ranks] = measure(scene, way, ranks)
            cells = (f"{kb:.0f} kB, {uneven:.2f}" for kb, uneven in (found[scene, way, n] for n in RANKS))
            print(f"| {scene} | {way} | {' | '.join(cells)} |", flush=True)
    plot(found)


if __name__ == "__main__":
    main()
