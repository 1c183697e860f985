"""Writes a game under static cuts as a run's log for students, without the machines' speeds."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from motes.balance import Static
from motes.replay import simulate
from motes.replay.density import Density
from motes.replay.frames import SystemStep
from motes.replay.history import Floats

from ..workloads import Planned
from ._games import Game

__all__ = ["write_log"]

SYSTEM = "particles"
BYTES = 44
"""Bytes of a particle in a message."""
OTHER = 0.15
"""Time of a frame besides computing, as a fraction of the calculators' mean compute time."""

Row = dict[str, Any]


def write_log(folder: Path, game: Game) -> None:
    """Write the log.

    Args:
        folder: of the log; it must not exist.
        game: the game to log.
    """
    speeds = game.track.speeds
    count = len(speeds)
    tables: dict[str, list[Row]] = {"frames": [], "load": [], "density": []}
    for step in simulate(Planned(game.workload, speeds), Static()):
        (system,) = step.systems
        noise = 1 if game.noise is None else 1 + game.noise[step.frame]
        seconds = system.seconds * noise
        tables["load"] += _load(step.frame, system, seconds)
        tables["density"] += _density(step.frame, system)
        tables["frames"].append(_frame(step.frame, system, seconds, OTHER * float(seconds.mean())))
    last = len(tables["frames"]) - 1
    events = [{"frame": 0, "kind": "start", "text": ""}, {"frame": last, "kind": "end", "text": ""}]
    folder.mkdir(parents=True)
    facts = {
        "schema": 1,
        "argv": ["scene.py"],
        "space": [0.0, float(game.workload.cells)],
        "balancer": "Static()",
        "manager": 0,
        "image_generator": 0,
        "calculators": list(range(count)),
        "systems": [SYSTEM],
        "axis": "x",
        "ranks": [{"rank": rank, "host": f"node{rank}"} for rank in range(count)],
    }
    (folder / "run.json").write_text(json.dumps(facts, indent=1) + "\n")
    for name, rows in {**tables, "events": events}.items():
        (folder / f"{name}.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))


def _load(frame: int, system: SystemStep, seconds: Floats) -> Iterator[Row]:
    cuts = [None, *map(float, np.asarray(system.cuts)), None]
    worked = system.n_start + system.created
    sent, received = np.rint(system.sent), np.rint(system.received)
    for c, took in enumerate(map(float, seconds)):
        yield {
            "frame": frame,
            "system": SYSTEM,
            "rank": c,
            "host": f"node{c}",
            "n_start": int(system.n_start[c]),
            "n_end": int(system.n_end[c]),
            "created": int(system.created[c]),
            "killed": 0,
            "sent": int(sent[c]),
            "received": int(received[c]),
            "bytes_sent": BYTES * int(sent[c]),
            "t_compute_s": took,
            "t_rescaled_s": took * float(system.n_end[c]) / max(int(worked[c]), 1),
            "t_exchange_s": 0.0,
            "t_wait_s": float(seconds.max()) - took,
            "t_image_s": 0.0,
            "domain_lo": cuts[c],
            "domain_hi": cuts[c + 1],
            "speed": int(worked[c]) / took if took > 0 else 0.0,
        }


def _density(frame: int, system: SystemStep) -> Iterable[Row]:
    assert isinstance(system.density, Density)
    places = system.density.quantiles(np.asarray(system.cuts), 16)
    for c, (n, along) in enumerate(zip(system.n_end, places, strict=True)):
        told = {f"x_q{q:02d}": None if np.isnan(x) else float(x) for q, x in enumerate(along)}
        yield {"frame": frame, "system": SYSTEM, "rank": c, "n": int(n), **told}


def _frame(frame: int, system: SystemStep, seconds: Floats, other_s: float) -> Row:
    longest, sent = float(seconds.max()), round(float(system.sent.sum()))
    return {
        "frame": frame,
        "time": (frame + 1) / 24,
        "particles": int(system.n_end.sum()),
        "exchanged": sent,
        "exchanged_bytes": BYTES * sent,
        "dropped": 0,
        "imbalance": longest / float(seconds.mean()),
        "slowest_rank": int(np.argmax(seconds)),
        "t_frame_s": longest + other_s,
        "t_act_s": longest,
        **dict.fromkeys(("t_create_s", "t_report_s", "t_exchange_s", "t_balance_s", "t_render_s"), 0.0),
    }
