"""Logs written by hand, for tests of what reads them."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

__all__ = ["load_row", "rows", "write_log"]


def rows(path: Path, table: Iterable[dict[str, Any]], *, mode: str = "w", pad: int = 256) -> None:
    """Write rows as the engine does: one JSON object a line, padded."""
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
    unknown = set(columns) - set(zero)
    assert not unknown, unknown
    return {"frame": frame, "system": system, "rank": rank, "host": "h", **zero, **columns}


def write_log(
    folder: Path, load: list[dict[str, Any]], *, facts: dict[str, Any] | None = None, t_frame_s: float = 1.0
) -> Path:
    """Write a log that came to its end, its frames made from the rows of load."""
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
            }
        )
    rows(folder / "frames.jsonl", frames)
    last = max((row["frame"] for row in load), default=0)
    rows(
        folder / "events.jsonl",
        [{"frame": 0, "kind": "start", "text": ""}, {"frame": last, "kind": "end", "text": ""}],
    )
    return folder
