"""Make the plot of paths in docs/pictures.md: `python docs/lab/scripts/make_paths.py`.

Snow fills a picture of 1920x1080 pixels, on virtual clusters (see docs/lab/growth.md). One panel shows
numbers of particles on 16 ranks, the other numbers of ranks with 3.2 million particles. Has the requirements
of `motes cluster`.
"""

from __future__ import annotations

import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from matplotlib.figure import Figure

from motes_lab.cluster import Cluster, Node
from motes_lab.cluster.growth import FOLDER, network
from motes_lab.cluster.simulate import record, simulate

TARGET = Path(__file__).resolve().parents[2] / "plots" / "paths.png"
PATHS = ("gather", "tiles", "composite")
PARTICLES = (50_000, 200_000, 800_000, 3_200_000, 12_800_000)
RANKS = (2, 4, 8, 16, 32)
COMPUTED = 32_000
"""Number of computed particles, each of which stands for several."""
FRAMES, MEASURED = 8, 3


def frame_ms(scene: Path, ranks: int, particles: int, path: str) -> float:
    """Return the simulated milliseconds of a frame on ranks that all calculate and draw."""
    options = ["--roles", "shared", "--births", "calculators", "--path", path]
    log = scene.with_name(f"{ranks}-{particles}-{path}")
    cluster = Cluster([Node("node", count=ranks)], network())
    run = simulate(scene, cluster, log=log, scale=particles / COMPUTED, options=options)
    assert set(run.frames["render_path"].iloc[-MEASURED:]) == {path}
    return float(run.frames["t_frame_s"].iloc[-MEASURED:].mean()) * 1e3


def measure() -> dict[tuple[int, int, str], float]:
    """Run all cases; return ms per frame by (ranks, particles, path)."""
    cases = [(16, particles, path) for particles in PARTICLES for path in PATHS]
    cases += [(ranks, 3_200_000, path) for ranks in RANKS for path in PATHS if ranks != 16]
    with tempfile.TemporaryDirectory(prefix="motes-paths-") as folder, ThreadPoolExecutor(2) as pool:
        scene = Path(folder) / "snow.motes"
        sizes = [f"--particles={COMPUTED}", "--systems=1", f"--frames={FRAMES}", "--size=1920x1080"]
        record(scene, FOLDER / "paper" / "snow.py", [*sizes, "--space=-12,12", "--width=24", "--distance=14"])
        found = pool.map(lambda case: frame_ms(scene, *case), cases)
        return dict(zip(cases, found, strict=True))


def plot(found: dict[tuple[int, int, str], float], target: Path = TARGET) -> None:
    """Draw both panels."""
    figure = Figure(figsize=(9.2, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    for path, marker in zip(PATHS, "osv", strict=True):
        left.loglog(PARTICLES, [found[16, n, path] for n in PARTICLES], marker + "-", label=path, ms=5)
        right.loglog(RANKS, [found[n, 3_200_000, path] for n in RANKS], marker + "-", label=path, ms=5)
    left.set(xlabel="particles, on 16 ranks", ylabel="ms per frame")
    right.set(xlabel="ranks, with 3.2 million particles", xticks=RANKS, xticklabels=[str(n) for n in RANKS])
    right.minorticks_off()
    for panel in (left, right):
        panel.grid(alpha=0.3)
        panel.spines[["top", "right"]].set_visible(False)
    left.legend(frameon=False)
    figure.savefig(target, dpi=80, metadata={"Software": None})


if __name__ == "__main__":
    plot(measure())
