"""Measure grains against published values: `python docs/lab/scripts/make_grains.py [CASE ...] [--size N]`.

Writes the figures to docs/lab/scripts/grains.json, and the plots of docs/lab/grains.md from them. `--size 2`
doubles all lengths except the grains' diameter.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import motes
from motes import expressions as ex
from motes.shapes import Cylinder, Disc, Mesh, Plane, Shape

FILE = Path(__file__).with_name("grains.json")
PLOT = Path(__file__).resolve().parents[1] / "grains.png"
DIAMETER, DENSITY = 0.01, 2500.0  # m, kg/m^3: glass
MASS = DENSITY * math.pi / 6 * DIAMETER**3
LAW: dict[str, Any] = {"stiffness": 1000.0, "restitution": 0.5, "friction": 0.5}
STEP = 1.25e-4  # s: a 20th of a touch
SUBSTEPS = 40  # per frame of 5 ms
CHUTE_S = 6.0  # 190 sqrt(d / g)

Walls = Callable[[int], list[Shape]]


class Box:
    """Grains between walls, simulated frame by frame."""

    def __init__(self, walls: Walls | list[Shape], **law: Any) -> None:
        """Make an empty box. `walls`: the walls, or a function that returns them for a frame."""
        self._walls = walls if callable(walls) else lambda _: walls
        self._law = LAW | law
        self.world = motes.World(seed=1, dt=SUBSTEPS * STEP, substeps=SUBSTEPS, threads=1, progress="off")
        self.grains = self.world.system("grains")

    def emit(self, position: NDArray[np.float64]) -> None:
        """Add grains at rest, with diameters that differ by up to 5 %, so they do not form a lattice."""
        dice = np.random.default_rng(len(position))
        wide = DIAMETER * dice.uniform(0.95, 1.05, len(position))
        self.grains.emit(
            position=position,
            size=np.repeat(wide[:, None], 3, axis=1),
            mass=DENSITY * math.pi / 6 * wide**3,
        )

    def frames(self, seconds: float, first: int = 0) -> Iterator[int]:
        """Run frames for some seconds; yield the number of each before it runs."""
        for frame in range(first, first + round(seconds / (SUBSTEPS * STEP))):
            yield frame
            self.grains.gravity((0, -9.81, 0))
            self.grains.contact(**self._law, walls=self._walls(frame))
            self.grains.move()
            self.world.step()

    def state(self) -> motes.Particles:
        """Return all grains."""
        return self.grains.gather()


def _then(first: list[Shape], seconds: float, then: list[Shape]) -> Walls:
    """Return walls that are replaced by others after some seconds."""
    return lambda frame: first if frame * SUBSTEPS * STEP < seconds else then


def rain(radius: float, low: float, count: int, seed: int = 3) -> NDArray[np.float64]:
    """Return positions in loose layers in an upright cylinder, from a height upward."""
    pitch = 1.15 * DIAMETER
    row = np.arange(-radius, radius, pitch)
    x, z = (grid.ravel() for grid in np.meshgrid(row, row))
    inside = np.hypot(x, z) < radius - 0.6 * DIAMETER
    x, z = x[inside], z[inside]
    layers = -(-count // len(x))
    y = low + np.repeat(np.arange(layers), len(x)) * pitch
    place = np.stack([np.tile(x, layers), y, np.tile(z, layers)], axis=1)[:count]
    return place + np.random.default_rng(seed).uniform(-0.05, 0.05, place.shape) * DIAMETER


def silo(size: float) -> dict[str, Any]:
    """Janssen: measure the mass that the ground of a silo carries, by the mass poured into it."""
    radius = 5 * DIAMETER * size
    poured, carried, top = pour(radius, round(240 * size**2), 9, 0.7)
    full = saturation(poured, carried)
    filled = float(poured[-1]) / (math.pi * radius**2 * (top - 2 * DIAMETER))  # kg/m^3 of the bulk
    depth = full / (filled * math.pi * radius**2)
    return {
        "poured_kg": poured.tolist(),
        "carried_kg": carried.tolist(),
        "saturation_kg": full,
        "depth_per_radius": depth / radius,
        "redirection": radius / (2 * LAW["friction"] * depth),
    }


def pour(
    radius: float, portion: int, portions: int, seconds: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Return the kg poured into a tube and carried by its ground after each portion, and the final height."""
    tube = Cylinder((0, -1, 0), (0, 9, 0), radius, radius)
    poured, carried = [], []
    with (box := Box([tube, Plane((0, 0, 0), (0, 1, 0))])).world:
        frame, top = 0, DIAMETER
        for number in range(portions):
            box.emit(rain(radius, top, portion, seed=number * portion))
            forces = []
            for frame in box.frames(seconds, frame):  # noqa: B020
                if frame % 4 == 0:
                    forces.append(_on_ground(box.state()))
            frame += 1
            last = box.state()
            top = float(last.position[:, 1].max()) + 1.5 * DIAMETER
            poured.append(float(last.mass.astype(np.float64).sum()))
            carried.append(float(np.mean(forces[-10:])) / 9.81)
    return np.array(poured), np.array(carried), top


def _on_ground(p: motes.Particles) -> float:
    """Return the force, N, of the springs between grains and ground."""
    deep = 0.5 * p.size[:, 0].astype(np.float64) - p.position[:, 1]
    return float(LAW["stiffness"] * deep[deep > 0].sum())


def saturation(poured: NDArray[np.float64], carried: NDArray[np.float64]) -> float:
    """Fit full (1 - exp(-poured / full)) by least squares."""
    tries = np.geomspace(0.2 * poured[0], 5 * poured[-1], 4000)[:, None]
    return float(tries[((tries * (1 - np.exp(-poured / tries)) - carried) ** 2).sum(axis=1).argmin(), 0])


def hopper(size: float) -> dict[str, Any]:
    """Beverloo: measure the flow out of a silo with a flat ground, by the width of its hole."""
    narrow, wide = [4.5, 5.5, 6.5, 8.0], [12.0, 16.0]
    out = flows(8 * size, round(4500 * size**3), narrow, 1.0)
    out += flows(20 * size, round(28000 * size**3), wide, 0.7)
    return _beverloo(narrow + wide, out)


def flows(
    radius: float,
    count: int,
    holes: list[float],
    seconds: float,
    *,
    filling: float = 0.55,
    after: float = 0.3,
) -> list[float]:
    """Return kg/s through each hole of a silo; widths are in diameters, `filling` and `after` in s."""
    tube = Cylinder((0, -0.001, 0), (0, 9, 0), radius * DIAMETER, radius * DIAMETER)
    with (box := Box([tube, Disc((0, 0, 0), (0, 1, 0), radius * DIAMETER)])).world:
        box.emit(rain(radius * DIAMETER, DIAMETER, count))
        for _ in box.frames(filling):
            pass
        filled = box.state()
    found = []
    for hole in holes:
        ring = Disc((0, 0, 0), (0, 1, 0), radius * DIAMETER, 0.5 * hole * DIAMETER)
        out, times = [], []
        with (box := Box([tube, ring])).world:
            box.grains.emit(
                position=filled.position,
                velocity=filled.velocity,
                rotational_velocity=filled.rotational_velocity,
                size=filled.size,
                mass=filled.mass,
            )
            for frame in box.frames(seconds):
                if frame % 4 == 0:
                    out.append(int((box.state().position[:, 1] < -DIAMETER).sum()))
                    times.append(frame * SUBSTEPS * STEP)
        time, gone = np.array(times), np.array(out)
        steady = (time > after) & (gone < 0.6 * count)
        found.append(float(np.polyfit(time[steady], gone[steady] * MASS, 1)[0]))
        print(hole, found[-1], flush=True)
    return found


def _beverloo(holes: list[float], flows: list[float]) -> dict[str, Any]:
    """Fit flow = factor bulk sqrt(g) (hole - k grain)^2.5 by a line through flow^0.4, and exponents."""
    slope, start = np.polyfit(holes, np.array(flows) ** 0.4, 1)
    k = -start / slope
    wide = np.array(holes) > 7

    def exponent(k: float, chosen: NDArray[np.bool_]) -> float:
        return float(np.polyfit(np.log(np.array(holes)[chosen] - k), np.log(flows)[chosen], 1)[0])

    return {
        "holes_diameters": holes,
        "flows_kg_s": flows,
        "k": float(k),
        "factor": float((slope / DIAMETER) ** 2.5 / (0.6 * DENSITY * math.sqrt(9.81))),
        "exponent": exponent(1.4, wide | True),
        "exponent_of_wide_holes": exponent(1.4, wide),
        "exponent_with_k": exponent(float(k), wide | True),
    }


def heap(size: float) -> dict[str, Any]:
    """Repose: measure the slope of a heap on a disc, by rolling friction."""
    rolling = [0.0, 0.05, 0.1, 0.2]
    slopes = []
    for friction in rolling:
        slopes.append(repose(9 * DIAMETER * size, round(2000 * size**3), 2.0, rolling_friction=friction))
        print(friction, slopes[-1], flush=True)
    return {"rolling_friction": rolling, "slopes_deg": slopes}


def repose(radius: float, count: int, seconds: float, **law: float) -> float:
    """Return the slope, degrees, of the heap on a disc whose wall is removed after 0.5 s."""
    plate, tube = Disc((0, 0, 0), (0, 1, 0), radius), Cylinder((0, 0, 0), (0, 9, 0), radius, radius)
    with (box := Box(_then([plate, tube], 0.5, [plate]), **law)).world:
        box.emit(rain(radius, DIAMETER, count))
        for _ in box.frames(seconds):
            pass
        p = box.state()
    return _slope(p.position[p.position[:, 1] > 0].astype(np.float64), radius)


def _slope(place: NDArray[np.float64], radius: float) -> float:
    """Return the slope, degrees, through the highest grain of each ring as wide as a grain."""
    ring = (np.hypot(place[:, 0], place[:, 2]) / DIAMETER).astype(int)
    rings = np.arange(1, int(radius / DIAMETER))
    high = np.array([place[ring == r, 1].max(initial=0) for r in rings])
    return float(np.degrees(np.arctan(-np.polyfit(rings * DIAMETER, high, 1)[0])))


def drum(size: float) -> dict[str, Any]:
    """Drum: measure the slope in a rotating drum, by its speed: rolling, then cascading."""
    slopes = []
    froudes = [1e-3, 5e-3, 2e-2]  # omega^2 R / g
    for froude in froudes:
        angles = turned(10 * DIAMETER * size, 6 * DIAMETER, froude, 2.5)
        slopes.append(float(np.mean(angles)))
        print(froude, slopes[-1], float(np.std(angles)), flush=True)
    return {"froude": froudes, "slopes_deg": slopes}


def turned(radius: float, length: float, froude: float, seconds: float) -> list[float]:
    """Return slopes in a rotating drum, degrees, every 50 ms after the first 1.2 s."""
    mesh = _drum(radius, length)
    turn = math.degrees(math.sqrt(froude * 9.81 / radius)) * SUBSTEPS * STEP

    def walls(frame: int) -> list[Shape]:
        before = mesh.at(axis=(0, 0, 1), angle_deg=frame * turn)
        return [mesh.at(axis=(0, 0, 1), angle_deg=(frame + 1) * turn, moving_from=before)]

    row = np.arange(-0.85, 0.86, 1.1 * DIAMETER / radius) * radius
    x, y, z = (
        g.ravel() for g in np.meshgrid(row, row, np.arange(-0.4, 0.41, 1.1 * DIAMETER / length) * length)
    )
    inside = (np.hypot(x, y) < radius - 0.7 * DIAMETER) & (y < 0.2 * radius)
    angles = []
    with (box := Box(walls, rolling_friction=0.05)).world:
        box.emit(np.stack([x, y, z], axis=1)[inside])
        for frame in box.frames(seconds):
            if frame * SUBSTEPS * STEP > 1.2 and frame % 10 == 0:
                angles.append(_surface(box.state().position.astype(np.float64), radius))
    return angles


def _drum(radius: float, length: float, corners: int = 72) -> Mesh:
    """Make a closed cylinder along z, for grains inside."""
    turn = np.arange(corners) * 2 * np.pi / corners
    ring = radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    ends = [np.column_stack([ring, np.full(corners, side * length / 2)]) for side in (-1, 1)]
    vertices = np.concatenate([*ends, [(0, 0, -length / 2), (0, 0, length / 2)]])
    near = np.arange(corners)
    after = (near + 1) % corners
    far, far_after = near + corners, after + corners
    low, high = np.full(corners, 2 * corners), np.full(corners, 2 * corners + 1)
    sides = [(near, after, far_after), (near, far_after, far), (low, after, near), (high, far, far_after)]
    return Mesh(vertices, np.concatenate([np.stack(side, axis=1) for side in sides]), resolution=96)


def _surface(place: NDArray[np.float64], radius: float) -> float:
    """Return the slope, degrees, of a line through the highest grains in the middle half of the drum."""
    column = np.round(place[:, 0] / DIAMETER).astype(int)
    middle = np.arange(-int(0.5 * radius / DIAMETER), int(0.5 * radius / DIAMETER) + 1)
    high = np.array([place[column == c, 1].max(initial=-radius) for c in middle])
    return float(np.degrees(np.arctan(np.polyfit(middle * DIAMETER, high, 1)[0])))


def chute(size: float) -> dict[str, Any]:
    """Bagnold: measure speed and profile of a layer on an endless rough slope, by its angle."""
    wide, deep, layers = round(10 * size), round(6 * size), 13
    periodic = {"x": (0, wide * DIAMETER), "z": (0, deep * DIAMETER)}
    dice = np.random.default_rng(2)
    x, y, z = (g.ravel() for g in np.mgrid[0:wide, 0 : layers + 1, 0:deep])
    place = np.stack([x, y * 1.05, z], axis=1) + dice.uniform(-0.12, 0.12, (len(x), 3)) * (y > 0)[:, None]
    place[y == 0, 1] += dice.uniform(-0.35, 0.35, (y == 0).sum())
    moves = ex.column("still") == 0
    found: dict[str, Any] = {
        "angles_deg": [19.0, 22.0, 24.0, 26.0],
        "speeds": [],
        "drifts": [],
        "misfits": [],
    }
    for angle in np.radians(found["angles_deg"]):
        world = motes.World(seed=1, dt=STEP * SUBSTEPS, substeps=SUBSTEPS, periodic=periodic, progress="off")
        grains = world.system("grains", attributes={"still": 1})
        speeds, states = [], []
        with world:
            for frame in world.frames(round(CHUTE_S / (STEP * SUBSTEPS))):
                if frame == 0:
                    grains.configure(size=DIAMETER, mass=MASS)
                    grains.emit(position=(place + (0.5, 0, 0.5)) * DIAMETER, still=(y == 0))
                grains.gravity((9.81 * np.sin(angle), -9.81 * np.cos(angle), 0), where=moves)
                grains.contact(**LAW, where=moves)
                grains.move()
                world.step()
                if frame % 10 == 0:
                    p = grains.gather()
                    speeds.append(float(p.velocity[p.still == 0, 0].mean()))
                    if frame * STEP * SUBSTEPS > 0.7 * CHUTE_S:
                        states.append(np.stack([p.position[p.still == 0, 1], p.velocity[p.still == 0, 0]], 1))
        part = len(speeds) * 3 // 20
        last, before = float(np.mean(speeds[-part:])), float(np.mean(speeds[-2 * part : -part]))
        found["speeds"].append(last / math.sqrt(9.81 * DIAMETER))
        found["drifts"].append(last / max(before, 1e-9) - 1)
        height, profile = _profile(np.concatenate(states))
        left = _bagnold(height, profile) - profile
        found["misfits"].append(float(np.sqrt((left**2).mean()) / max(np.ptp(profile), 1e-9)))
        if round(math.degrees(angle)) == 24:
            found["height_diameters"], found["profile"] = height.tolist(), profile.tolist()
        print(
            math.degrees(angle),
            {name: found[name][-1] for name in ("speeds", "drifts", "misfits")},
            flush=True,
        )
    return found


def _profile(seen: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return heights in diameters, and mean velocities per sqrt(g d) of slices a diameter thick."""
    slices = np.round(seen[:, 0] / DIAMETER).astype(int)
    full = np.bincount(slices[slices >= 0])
    numbers = np.flatnonzero(full > 0.5 * np.median(full[full > 0]))
    means = [seen[slices == n, 1].mean() / math.sqrt(9.81 * DIAMETER) for n in numbers]
    return numbers.astype(float), np.array(means)


def _bagnold(height: NDArray[np.float64], speed: NDArray[np.float64]) -> NDArray[np.float64]:
    """Fit speeds a + b (1 - (1 - y / top)^1.5), and return them."""
    top = height.max() + 0.5
    rows = np.stack([np.ones_like(height), 1 - (1 - height / top) ** 1.5], axis=1)
    fitted: NDArray[np.float64] = rows @ np.linalg.lstsq(rows, speed, rcond=None)[0]
    return fitted


CASES: dict[str, Callable[[float], dict[str, Any]]] = {
    "silo": silo,
    "hopper": hopper,
    "heap": heap,
    "drum": drum,
    "chute": chute,
}


def plot(figures: dict[str, Any]) -> None:
    """Draw measured and published values."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    shown, axes = plt.subplots(1, 5, figsize=(18, 3.6), layout="constrained")
    if "silo" in figures:
        of = figures["silo"]
        line = np.linspace(0, max(of["poured_kg"]), 100)
        axes[0].plot(of["poured_kg"], of["carried_kg"], "o", label="measured")
        full = of["saturation_kg"]
        axes[0].plot(line, full * (1 - np.exp(-line / full)), label=f"Janssen, K = {of['redirection']:.2f}")
        axes[0].plot(line, line, ":", color="grey", label="all of it")
        axes[0].set(title="Silo", xlabel="poured (kg)", ylabel="carried by the ground (kg)")
    if "hopper" in figures:
        of = figures["hopper"]
        wide = np.array(of["holes_diameters"])
        line = np.linspace(2, wide.max(), 50)
        axes[1].plot(wide, np.array(of["flows_kg_s"]) ** 0.4, "o", label=f"measured: k = {of['k']:.2f}")
        ideal = 0.58 * 0.6 * DENSITY * math.sqrt(9.81) * ((line - 1.4) * DIAMETER) ** 2.5
        axes[1].plot(line, ideal**0.4, label="Beverloo: k = 1.4, C = 0.58")
        axes[1].set(title="Hopper", xlabel="hole / diameter", ylabel="flow^0.4 (kg/s)^0.4")
    if "heap" in figures:
        of = figures["heap"]
        axes[2].plot(of["rolling_friction"], of["slopes_deg"], "o-", label="measured")
        axes[2].set(title="Repose", xlabel="rolling friction", ylabel="slope (degrees)", ylim=(0, 40))
    if "drum" in figures:
        of = figures["drum"]
        axes[3].semilogx(of["froude"], of["slopes_deg"], "o-", label="measured")
        axes[3].set(title="Drum", xlabel="omega^2 R / g", ylabel="slope (degrees)", ylim=(0, 50))
    if "chute" in figures:
        of = figures["chute"]
        high, speed = np.array(of["height_diameters"]), np.array(of["profile"])
        axes[4].plot(speed, high, "o", label="measured, 24 degrees")
        axes[4].plot(_bagnold(high, speed), high, label="Bagnold")
        axes[4].set(title="Chute", xlabel="speed / sqrt(g d)", ylabel="height / diameter")
    for one in (one for one in axes if one.get_legend_handles_labels()[0]):
        one.legend(fontsize=8)
        one.grid(alpha=0.3)
    shown.savefig(PLOT, dpi=110)


def main() -> None:
    """Measure the named cases, or all, and draw all known figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", choices=[*CASES, []], metavar="CASE")
    parser.add_argument("--size", type=float, default=1)
    args = parser.parse_args()
    figures = json.loads(FILE.read_text()) if FILE.is_file() else {}
    for name in args.cases or CASES:
        figures[name] = CASES[name](args.size) | {"size": args.size}
        print(name, figures[name], flush=True)
        FILE.write_text(json.dumps(figures, indent=1) + "\n")
    plot(figures)


if __name__ == "__main__":
    main()
