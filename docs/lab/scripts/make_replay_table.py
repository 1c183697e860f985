"""Compare replays, and what `explain` says of balancers, with exact runs on virtual clusters.

`python docs/lab/scripts/make_replay_table.py` writes the tables of docs/lab/balancing.md, with the same
figures each time. Four loads run under six policies on three clusters; each log under `Static` and under
`PrefixCuts` is replayed under all six. Needs SimGrid and `python -m motes cluster build`; takes some minutes.
`--keep DIR` keeps scenes and logs, and uses those that are already there.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import motes
from motes.balance import Balancer, CostAware, Diffusive, Pairwise, PrefixCuts, Proportional, Static
from motes_lab.cluster import Cluster, FastEthernet, Modern, Node, simulate
from motes_lab.cluster.simulate import record

HERE = Path(__file__).parent
PAGE = HERE.parent / "balancing.md"
LOADS = ("step", "wave", "drift", "jet")
NODES = [Node("fast", cores=2, count=2), Node("slow", 0.6, cores=2, count=1)]
HEAVY = "action = 400\nbirth = 300\nleave = 300\narrive = 300\nrecord = 50\n"
"""Costs with which computing matters more than messages, even on Fast Ethernet, ns."""
SKIP = 10
"""First frames, in which speeds are learned, are ignored."""
POLICIES: list[Balancer] = [
    *(Static(), Pairwise(), Diffusive(), PrefixCuts()),
    *(Proportional([1, 1, 0.6, 0.6]), CostAware(move_cost=1.0)),
]
FROM = ("Static", "PrefixCuts")


@dataclass(frozen=True)
class Machine:
    """A cluster, what work costs on it, and whether pictures are drawn."""

    title: str
    cluster: Cluster
    scale: float
    costs: str = ""
    pictures: bool = False


MACHINES = {
    "ethernet": Machine("Fast Ethernet, heavy actions", Cluster(NODES, FastEthernet()), 20.0, HEAVY),
    "modern": Machine("200 Gb/s, light actions", Cluster(NODES, Modern()), 1000.0),
    "pictures": Machine("200 Gb/s, light actions, pictures", Cluster(NODES, Modern()), 1000.0, pictures=True),
}


class Grid:
    """All runs, each simulated when it is first asked for."""

    def __init__(self, folder: Path) -> None:
        """Keep scenes and logs in a folder."""
        self._folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def run(self, machine: str, load: str, policy: Balancer) -> motes.Run:
        """Return the run of a load under a policy."""
        where = MACHINES[machine]
        log = self._folder / f"{machine}-{load}-{type(policy).__name__}"
        if not (log / "run.json").exists():
            costs = self._folder / f"{machine}.costs"
            costs.write_text(where.costs)
            simulate(
                self._scene(load, where.pictures),
                where.cluster,
                log=log,
                costs=costs if where.costs else None,
                scale=where.scale,
                balancer=policy,
            )
        return motes.open_run(log)

    def _scene(self, load: str, pictures: bool) -> Path:
        scene = self._folder / f"{load}{'-pictures' * pictures}.motes"
        if not scene.exists():
            record(scene, HERE / "replay_loads.py", [load, *["pictures"] * pictures])
        return scene


def frame_s(run: motes.Run) -> float:
    """Return the mean seconds of a frame, from the latest rank's end to the latest rank's end."""
    walls = run.times.pivot(index="frame", columns="rank", values="wall_s").cumsum().max(axis=1)
    return float((walls.iloc[-1] - walls.loc[SKIP - 1]) / (len(walls) - SKIP))


def later(run: motes.Run, column: str) -> float:
    """Return a column's mean over the frames that count."""
    return float(run.frames.loc[run.frames["frame"] >= SKIP, column].mean())


def replays(grid: Grid, machine: str) -> Iterator[tuple[str, str, str, float, float, bool]]:
    """Yield load, policy of the log, policy, predicted / true seconds and migrants, whether within bounds."""
    for load in LOADS:
        real = {type(policy).__name__: grid.run(machine, load, policy) for policy in POLICIES}
        for source in FROM:
            for policy in POLICIES:
                name = type(policy).__name__
                guess, true_s = real[source].replay(policy), frame_s(real[name])
                low, best, high = (later(guess, f"t_frame{bound}_s") for bound in ("_low", "", "_high"))
                moved = later(real[name], "exchanged")
                exchanged = later(guess, "exchanged") / moved if moved else math.nan
                yield load, source, name, best / true_s, exchanged, low <= true_s <= high


def tables(grid: Grid) -> str:
    """Return the tables of all clusters, and the sentences about them."""
    parts, rows = [], []
    for machine, where in MACHINES.items():
        found = list(replays(grid, machine))
        rows += found
        cells = {(load, source, name): (seconds, moved) for load, source, name, seconds, moved, _ in found}
        for number, what in enumerate(("frame time", "exchanged")):
            head = f"| {where.title}: {what} | {' | '.join(LOADS)} |"
            lines = [head, "|---" * (1 + len(LOADS)) + "|"]
            for policy in POLICIES:
                name = type(policy).__name__
                told = [" / ".join(f"{cells[load, s, name][number]:.2f}" for s in FROM) for load in LOADS]
                lines.append(f"| `{name}` | {' | '.join(told)} |")
            parts.append("\n".join(lines))
    good = sum(abs(row[3] - 1) <= 0.1 for row in rows)
    moved = [row[4] for row in rows if not math.isnan(row[4])]
    near = sum(abs(ratio - 1) <= 0.2 for ratio in moved)
    inside = sum(row[5] for row in rows)
    parts.append(
        f"Of {len(rows)} frame times, {good} are within 10 % of the run's, and {inside} within the replay's "
        f"own bounds; of {len(moved)} exchanges, {near} are within 20 %."
    )
    return "\n\n".join(parts)


def savings(grid: Grid) -> str:
    """Return the table of what `explain` says, and what the balancer that it names saves."""
    lines = ["| recorded under `Static` | `explain().saving` | true |", "|---|---|---|"]
    for machine, where in MACHINES.items():
        for load in LOADS:
            run = grid.run(machine, load, Static())
            told = run.explain()
            policy = next((one for one in POLICIES if type(one).__name__ == told.balancer), None)
            best = grid.run(machine, load, policy or getattr(motes.balance, told.balancer)())
            true = 1 - frame_s(best) / frame_s(run)
            bounds = f"{100 * told.saving:.0f} % ({100 * told.low:.0f} to {100 * told.high:.0f})"
            lines.append(f"| {where.title}: {load} | {told.balancer}, {bounds} | {100 * true:.0f} % |")
    return "\n".join(lines)


def main() -> None:
    """Write both tables into the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep scenes and logs in this directory")
    keep = parser.parse_args().keep
    with tempfile.TemporaryDirectory() as folder:
        grid = Grid(keep or Path(folder))
        page = PAGE.read_text()
        for name, text in (("replays", tables(grid)), ("savings", savings(grid))):
            start, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
            head, _, rest = page.partition(start)
            page = f"{head}{start}\n{text}\n\n{end}{rest.partition(end)[2]}"
        PAGE.write_text(page)


if __name__ == "__main__":
    main()
