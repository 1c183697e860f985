"""Compare predictions of replays with real runs, for seven policies and four loads, on a virtual cluster.

`python docs/scripts/make_replay_table.py` prints the tables of docs/notes/balancing.md, with the same
figures each time. Each load runs once under static cuts; its log is replayed under each policy, with the
cluster's cost per migrant. The same scene then runs under that policy. Needs SimGrid and
`python -m motes cluster build`.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from motes.balance import Balancer, Bisection, CostAware, Diffusive, Pairwise, PrefixCuts, Static, Targets
from motes.cluster import Cluster, FastEthernet, Node, migrant_s, simulate
from motes.cluster.simulate import record

HERE = Path(__file__).parent
LOADS = ("step", "wave", "drift", "jet")
CLUSTER = Cluster([Node("fast", cores=2, count=2), Node("slow", 0.6, cores=2, count=1)], FastEthernet())
COSTS = "action = 400\nbirth = 300\nleave = 300\narrive = 300\nrecord = 50\n"
SCALE = 20.0
SIZES = {"step": 28, "wave": 28, "drift": 36, "jet": 36}
"""Bytes of a particle in a message."""
SKIP = 10
"""First frames, in which speeds are learned, are ignored."""


class BySpeed(Balancer):
    """The policy of docs/ranks.md."""

    def decide(self, load: Any) -> Targets:
        """Return shares by speed."""
        return Targets(load.powers)


def policies() -> list[Balancer]:
    """Return the policies of the table."""
    return [Static(), Pairwise(), Diffusive(), PrefixCuts(), Bisection(), CostAware(move_cost=1.0), BySpeed()]


def main() -> None:
    """Print both tables: predicted over real."""
    rows: dict[str, dict[str, tuple[float, float]]] = {}
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        costs = folder / "costs"
        costs.write_text(COSTS)
        sizes: dict[str, Any] = {"scale": SCALE, "costs": costs, "options": ["--births", "manager"]}
        for load in LOADS:
            scene = folder / f"{load}.motes"
            record(scene, HERE / "replay_loads.py", [load])
            each = migrant_s(CLUSTER, costs, scale=SCALE, size=SIZES[load])
            log = simulate(scene, CLUSTER, log=folder / f"{load}-recorded", balancer=Static(), **sizes)
            for policy in policies():
                name = type(policy).__name__
                real = simulate(scene, CLUSTER, log=folder / f"{load}-{name}", balancer=policy, **sizes)
                guess = log.replay(policy, migrant_s=each)
                rows.setdefault(name, {})[load] = _ratios(real, guess)
    for k, title in enumerate(("frame time", "exchanged")):
        print(f"\n| {title} | {' | '.join(LOADS)} |\n|{'---|' * (1 + len(LOADS))}")
        for name, found in rows.items():
            print(f"| `{name}` | {' | '.join(f'{found[load][k]:.2f}' for load in LOADS)} |")


def _ratios(real: Any, guess: Any) -> tuple[float, float]:
    """Return predicted over real: mean frame time, and particles exchanged."""
    both = [run.frames[run.frames["frame"] >= SKIP] for run in (guess, real)]
    seconds = [float(frames["t_frame_s"].mean()) for frames in both]
    exchanged = [float(frames["exchanged"].mean()) for frames in both]
    return seconds[0] / seconds[1], exchanged[0] / exchanged[1] if exchanged[1] else float("nan")


if __name__ == "__main__":
    main()
