"""Measure heaps of grains and write the table of docs/lab/heaps.md: `python docs/lab/scripts/make_heaps.py`.

Processor time depends on the machine; all other figures are the same everywhere.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import motes
from motes.shapes import Box, Plane, Shape

PAGE = Path(__file__).resolve().parents[1] / "heaps.md"
MARK = "<!-- written by make_heaps.py -->\n"
RADIUS, SECONDS = 0.02, 8
STIFFNESS = 2e5  # N/m, for grains of 1 kg: each touch takes 24 sub-steps of 1/4800 s
CASES = [
    ("heap", 4000, 20, "stops"),
    ("heap", 4000, 20, "slows"),
    ("heap", 4000, 40, "stops"),
    ("heap", 20_000, 20, "stops"),
    ("heap", 20_000, 20, "slows"),
    ("heap", 20_000, 40, "stops"),
    ("box", 20_000, 20, "slows"),
    ("box", 20_000, 40, "slows"),
    ("contact", 4000, 200, "stops"),
    ("contact, rolling", 4000, 200, "stops"),
]
GROUND: dict[str, dict[str, Any]] = {
    "stops": {"friction": 1, "exact_hit": False},
    "slows": {"friction": 0.5},
}
SOLIDS: dict[str, list[Shape]] = {
    "heap": [Plane((0, RADIUS, 0), (0, 1, 0))],
    "contact": [Plane((0, RADIUS, 0), (0, 1, 0))],
    "contact, rolling": [Plane((0, RADIUS, 0), (0, 1, 0))],
    "box": [Box((RADIUS - 0.6, RADIUS, RADIUS - 0.6), (0.6 - RADIUS, 99, 0.6 - RADIUS))],
}


def stack(grains: int) -> NDArray[np.float64]:
    """Return a column of grains 1.6 times as high as wide, each layer over the gaps of the one below."""
    wide = round((grains * 0.53) ** (1 / 3))
    y, x, z = (grid.ravel() for grid in np.mgrid[: grains // wide**2, :wide, :wide])
    place = np.stack([x - wide / 2, y, z - wide / 2], axis=1) * (0.046, 0.04, 0.046)
    place += (y % 2 * 0.023)[:, None] * (1, 0, 1) + (0, RADIUS + 0.005, 0)
    jitter = np.random.default_rng(5).uniform(-0.003, 0.003, place.shape) * (1, 0, 1)
    return (place + jitter).round(5)


def overlaps(place: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the overlap of each touching pair, as a fraction of the diameter."""
    place = place[np.argsort(place[:, 0])]
    found = []
    for ahead in range(1, len(place)):
        close = place[ahead:, 0] - place[:-ahead, 0] < 2 * RADIUS
        if not close.any():
            break
        gaps = np.linalg.norm((place[ahead:] - place[:-ahead])[close], axis=1)
        found.append(1 - gaps[gaps < 2 * RADIUS] / (2 * RADIUS))
    return np.concatenate(found)


def slope(place: NDArray[np.float64]) -> float:
    """Return the slope, degrees, through the highest grains in rings of 4 cm, at 20 to 80 % of the height."""
    ring = (np.hypot(place[:, 0], place[:, 2]) / 0.04).astype(int)
    high = np.array([place[ring == r, 1].max(initial=0) for r in range(ring.max() + 1)])
    flank = np.flatnonzero((high > 0.2 * high.max()) & (high < 0.8 * high.max()))
    return float(np.degrees(np.arctan(-np.polyfit(flank * 0.04, high[flank], 1)[0])))


def measure(scene: str, grains: int, substeps: int, ground: str) -> str:
    """Let a column collapse and come to rest; return a row of the table."""
    world = motes.World(seed=1, substeps=substeps, threads=1, progress="off")
    sand = world.system("sand")
    spent = 0.0
    with world:
        for frame in world.frames(24 * SECONDS):
            if frame == 0:
                sand.emit(position=stack(grains))
            if frame == 24 * (SECONDS - 1):
                before = sand.gather().position.astype(np.float64)
            start = time.process_time()
            sand.gravity((0, -9.81, 0))
            if scene.startswith("contact"):
                rolling = 0.2 if "rolling" in scene else 0
                sand.contact(STIFFNESS, restitution=0.2, rolling_friction=rolling, radius=RADIUS)
            else:
                sand.collide(RADIUS, friction=0.5)
            for solid in SOLIDS[scene]:
                sand.bounce(solid, restitution=0, **GROUND[ground])
            sand.move()
            world.step()
            spent += time.process_time() - start
        place = sand.gather().position.astype(np.float64)
    deep = 100 * overlaps(place)
    way = 1000 * np.linalg.norm(place - before, axis=1)
    row = [
        f"{len(place)}",
        f"{substeps}",
        scene if scene == "box" else f"{scene}, {slope(place):.0f}°",
        ground,
        f"{deep.mean():.1f} / {np.quantile(deep, 0.99):.1f} / {deep.max():.1f} %",
        f"{way.mean():.4f}",
        f"{np.count_nonzero(way)}",
        f"{1e9 * spent / len(place) / substeps / 24 / SECONDS:.0f}",
    ]
    return f"| {' | '.join(row)} |"


def main() -> None:
    """Write the page with a new table."""
    before, _, rest = PAGE.read_text().partition(MARK)
    _, _, after = rest.partition(MARK)
    head = "| grains | sub-steps | scene | ground | overlap: mean / 99 % / largest "
    head += "| mm in the last second | of them moved | ns |\n"
    rows = []
    for case in CASES:
        rows.append(measure(*case))
        print(rows[-1], flush=True)
    PAGE.write_text(before + MARK + head + "|---" * 8 + "|\n" + "\n".join(rows) + "\n" + MARK + after)


if __name__ == "__main__":
    main()
