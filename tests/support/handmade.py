"""Logs written by hand, for tests of code that reads them."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

__all__ = ["load_row", "moving_spot", "rows", "time_row", "write_log"]


def rows(path: Path, table: Iterable[dict[str, Any]], *, mode: str = "w", pad: int = 256) -> None:
    """Write rows as the engine does: one JSON object per line, padded."""
    with path.open(mode) as file:
        for row in table:
            text = json.dumps(row)
            file.write(text.ljust(-(-(len(text) + 1) // pad) * pad - 1) + "\n")


def load_row(frame: int, system: str, rank: int, **columns: Any) -> dict[str, Any]:
    """Make a row of load.jsonl; columns not given are zero."""
    zero: dict[str, Any] = dict.fromkeys(
        ("n_start", "n_end", "created", "killed", "sent", "received", "bytes_sent"), 0
    )
    seconds = ("t_compute_s", "t_rescaled_s", "t_exchange_s", "t_wait_s", "t_image_s")
    zero |= dict.fromkeys(seconds, 0.0) | {"domain_lo": None, "domain_hi": None, "speed": 0.0}
    zero |= {name: None for name in columns if name.startswith("domain_")}
    unknown = set(columns) - set(zero)
    assert not unknown, unknown
    return {"frame": frame, "system": system, "rank": rank, "host": "h", **zero, **columns}


def time_row(
    frame: int, rank: int, *, chain_s: float, messages_s: float = 0.0, **spent: float
) -> dict[str, Any]:
    """Make a row of times.jsonl from seconds by activity: `act=0.2, wait=0.1`; others are zero."""
    names = ("script", "births", "act", "talk", "picture", "log", "checkpoint", "recovery", "other", "wait")
    assert set(spent) <= {*names, "script_idle"}, spent
    seconds = {f"{name}_s": spent.get(name, 0.0) for name in names}
    whole = {"wall_s": sum(seconds.values()), "messages_s": messages_s, "chain_s": chain_s}
    whole["script_idle_s"] = spent.get("script_idle", 0.0)
    return {"frame": frame, "rank": rank, **seconds, **whole}


def write_log(
    folder: Path, load: list[dict[str, Any]], *, facts: dict[str, Any] | None = None, t_frame_s: float = 1.0
) -> Path:
    """Write the log of a finished run, its frames made from the rows of load."""
    folder.mkdir(parents=True)
    told: dict[str, Any] = {
        "schema": 1,
        "argv": ["scene.py"],
        "space": [-1.0, 1.0],
        "balancer": "Static()",
        "manager": 1,
        "image_generator": 0,
        "calculators": sorted({row["rank"] for row in load}),
        "systems": list(dict.fromkeys(row["system"] for row in load)),
        "ranks": [{"rank": rank, "host": "h"} for rank in range(4)],
    }
    (folder / "run.json").write_text(json.dumps(told | (facts or {})))
    rows(folder / "load.jsonl", load, pad=512)
    frames = []
    for frame in sorted({row["frame"] for row in load}):
        mine = [row for row in load if row["frame"] == frame]
        seconds: dict[int, float] = {}
        for row in mine:
            seconds[row["rank"]] = seconds.get(row["rank"], 0.0) + row["t_compute_s"]
        total = sum(seconds.values())
        frames.append(
            {
                "frame": frame,
                "time": (frame + 1) / 24,
                "particles": sum(row["n_end"] for row in mine),
                "exchanged": sum(row.get("sent", 0) for row in mine),
                "exchanged_bytes": sum(row.get("bytes_sent", 0) for row in mine),
                "dropped": 0,
                "imbalance": max(seconds.values()) * len(seconds) / total if total else 1.0,
                "slowest_rank": max(seconds, key=lambda rank: seconds[rank]),
                "t_frame_s": t_frame_s,
                "t_create_s": 0.0,
                "t_act_s": max(seconds.values()),
                "t_report_s": 0.0,
                "t_exchange_s": 0.0,
                "t_balance_s": 0.0,
                "t_render_s": 0.0,
                "t_project_s": 0.0,
                "t_draw_s": 0.0,
                "t_assemble_s": 0.0,
                "render_path": "gather",
                "records": 0,
                "render_bytes": 0,
            }
        )
    rows(folder / "frames.jsonl", frames)
    last = max((row["frame"] for row in load), default=0)
    rows(
        folder / "events.jsonl",
        [{"frame": 0, "kind": "start", "text": ""}, {"frame": last, "kind": "end", "text": ""}],
    )
    return folder


def moving_spot(folder: Path, *, frames: int = 40, calculators: int = 4, particles: int = 40_000) -> Path:
    """Write a log in which a cloud of particles moves; cuts follow it by half of the distance per frame.

    The last calculator has half the speed. The log has all possible files.
    """
    import numpy as np

    ranks = [rank + 2 for rank in range(calculators)]
    factors = [1.0] * (calculators - 1) + [0.5]
    wanted = np.cumsum(factors)[:-1] / sum(factors)
    cuts = np.linspace(-10, 10, calculators + 1)[1:-1]
    rest = np.random.default_rng(7).normal(0, 2, particles)
    load, balance, density, spans, seconds = [], [], [], {rank: [] for rank in range(calculators + 2)}, 0.0
    for frame in range(frames):
        x = np.sort(rest + 6 * np.sin(frame / 8))
        new = cuts + 0.5 * (np.quantile(x, wanted) - cuts)
        ends = np.searchsorted(x, [-np.inf, *cuts, np.inf])
        counts, longest = np.diff(ends), 0.0
        for i, rank in enumerate(ranks):
            n, took = int(counts[i]), float(counts[i] / (4e6 * factors[i]))
            longest = max(longest, took)
            row = load_row(frame, "cloud", rank, n_start=n, n_end=n, t_compute_s=took, t_rescaled_s=took)
            row |= {"speed": n / took if n else 0.0, "sent": n // 100, "received": n // 100}
            row |= {"bytes_sent": 41 * (n // 100), "t_exchange_s": 0.0004, "t_wait_s": 0.0005}
            row |= {"domain_lo": float(cuts[i - 1]) if i else None}
            load.append(row | {"domain_hi": float(cuts[i]) if i < calculators - 1 else None})
            mine = x[ends[i] : ends[i + 1]]
            points = np.quantile(mine, np.linspace(0, 1, 17)).tolist() if n else [None] * 17
            named = {f"x_q{k:02d}": value for k, value in enumerate(points)}
            density.append({"frame": frame, "system": "cloud", "rank": rank, "n": n, **named})
        for i, (before, after) in enumerate(zip(cuts, new, strict=True)):
            moved = int(np.searchsorted(x, before) - np.searchsorted(x, after))
            sides = {"left_rank": ranks[i], "right_rank": ranks[i + 1], "n_left": int(counts[i])}
            sides |= {"n_right": int(counts[i + 1]), "ordered": moved + 3 * (moved > 0), "given": moved}
            cut = {"cut_before": float(before), "cut_after": float(after), "policy": "Pairwise"}
            balance.append({"frame": frame, "system": "cloud", **sides, **cut})
        for rank in spans:
            took = load[-calculators + rank - 2]["t_compute_s"] if rank in ranks else 0.0
            stations = [("create", 0.0003), ("act", took), ("report", longest - took + 0.0002)]
            stations += [
                ("exchange", 0.0004),
                ("balance", 0.0003),
                ("render", 0.0012 if rank < 1 else 0.0005),
            ]
            at = seconds
            for phase, length in stations:
                system = "cloud" if phase == "act" else ""
                spans[rank].append({"frame": frame, "phase": phase, "system": system, "start_s": at})
                at += length
                spans[rank][-1]["end_s"] = at
        seconds += longest + 0.0025
        cuts = new
    times, waits = [], []
    for row in load:
        spent = {"act": row["t_compute_s"], "wait": seconds / frames - row["t_compute_s"]}
        times.append(
            time_row(row["frame"], row["rank"], chain_s=seconds * (row["frame"] + 1) / frames, **spent)
        )
        waited = {"rank": row["rank"], "waited_for": ranks[-1], "phase": "report", "seconds": spent["wait"]}
        waits.append({"frame": row["frame"], **waited})
    facts = {"balancer": "Pairwise(threshold=0.1)", "space": [-10, 10], "axis": "x", "clock": "cpu"}
    facts |= {"ranks": [{"rank": rank, "host": "h"} for rank in spans]}
    facts |= {"speeds": {str(ranks[-1]): 0.5}}
    write_log(folder, load, facts=facts, t_frame_s=seconds / frames)
    rows(folder / "balance.jsonl", balance, pad=512)
    rows(folder / "density.jsonl", density, pad=1024)
    rows(folder / "times.jsonl", times, pad=512)
    rows(folder / "waits.jsonl", waits)
    for rank, table in spans.items():
        rows(folder / f"spans.r{rank:04d}.jsonl", table)
    return folder
