"""Columns of the log that are sums of others: over ranks, over frames, and of the script's own counts."""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest
from standing import on_ranks

Row = dict[str, Any]

SCENE = """
import json, sys
import numpy as np
import motes
from motes._world.world import session_of
from motes.shapes import Box, Plane, Sphere

log, options = sys.argv[1], json.loads(sys.argv[2])


class Anything(motes.balance.Balancer):
    def decide(self, load):
        return motes.balance.Targets(np.random.default_rng(load.frame).random(len(load.particles)) + 0.05)


if options.pop("balanced"):
    options["balancer"] = Anything()
camera = motes.Camera((0, 1, 9), (0, 0, 0))
renderer = motes.Renderer(64, 48, camera=camera)
world = motes.World(seed=5, log=log, digest=True, progress="off", renderer=renderer, **options)
a, b = world.system("a", capacity=900), world.system("b")
c, d = world.system("c", capacity=400), world.system("d")
systems = (a, b, c, d)
with world:
    for frame in world.frames(12):
        a.configure(velocity=Sphere((0, 3, 0), 2), lifetime=motes.Uniform(0.1, 0.4))
        c.configure(lifetime=0.15)
        a.source(Box((-2, 0, -1), (2, 1, 1)), 3000 + 500 * frame)
        a.gravity((0, -9, 0))
        a.spawn(into=c, on="death", count=2)
        a.spawn(into=b, on="collision", count=1)
        a.spawn(into=b, on="birth", count=1, where=Sphere((0, 0, 0), 0.5))
        if frame % 3:
            a.collide(0.02)
        if frame % 4 == 1:
            a.match_velocity(0.2, max_radius=0.3)
        a.bounce(Plane((0, 0, 0), (0, 1, 0)), 0.5)
        a.kill_expired()
        a.sink(Sphere((1, 1, 0), 0.4))
        a.move()
        b.burst(Box((-1, -1, -1), (1, 1, 1)), 50)
        b.random_velocity(Sphere((0, 0, 0), 9))
        b.kill_old(0.2)
        b.move()
        c.kill_expired()
        c.random_displacement(Sphere((0, 0, 0), 5))
        c.move()
        d.burst(Box((-1, -1, -1), (1, 1, 1)), 20)
        d.random_velocity(Sphere((0, 0, 0), 6))
        d.follow(2.0)
        if frame % 2:
            d.gravitate(1e-6)
        d.move()
        (world.render if frame % 5 else world.step)()
        if frame == 6:
            world.digest()
        world.say(json.dumps([frame, [(s.name, s.count, s.born, s.dropped) for s in systems]]))
        if "manager" in world.role and (row := session_of(world).engine.last_row):
            names = ("frame", "particles", "exchanged", "exchanged_bytes", "dropped")
            print(json.dumps({name: row[name] for name in names}))
"""

SLABS, BRICKS, BY_ID = "x", "xyz", None
ONE = {"axis": SLABS, "space": (-2, 2), "balanced": False}
WAYS = [
    (1, {}),
    (2, {"substeps": 2}),
    (3, {"axis": BRICKS}),
    (3, {"combine": "one_by_one", "births": "calculators", "balanced": True}),
    (5, {"combine": "overlapped", "roles": "shared", "substeps": 3}),
    (5, {"axis": BRICKS, "balanced": True, "roles": "shared"}),
    (3, {"axis": BY_ID, "space": None, "roles": "shared"}),
    (5, {"roles": "shared", "balanced": True, "births": "calculators"}),
]


def rows_of(path: Path) -> list[Row]:
    return [json.loads(line) for line in path.read_text().splitlines()]


def total(rows: list[Row], column: str) -> int:
    return sum(row.get(column) or 0 for row in rows)


def check_rows(load: list[Row], density: list[Row]) -> None:
    """Check that each row's particles are the last ones plus gains minus losses, and equal `density`'s."""
    held: dict[tuple[str, int], int] = defaultdict(int)
    placed = {(row["frame"], row["system"], row["rank"]): row["n"] for row in density}
    for row in load:
        place = row["system"], row["rank"]
        assert row["n_start"] == held[place], row
        gained, lost = row["created"] + row["received"], row["killed"] + row["sent"]
        assert row["n_end"] == row["n_start"] + gained - lost, row
        assert placed.pop((row["frame"], *place)) == row["n_end"], row
        assert row["bytes_sent"] >= (row.get("interaction_bytes") or 0), row
        assert row["sent"] == 0 or row["bytes_sent"] > 0, row
        held[place] = row["n_end"]
    assert not placed


def check_frame(row: Row, load: list[Row], counted: dict[str, list[int]]) -> None:
    """Check that a frame's row sums up those of its calculators and agrees with the script's own counts."""
    assert row["particles"] == total(load, "n_end") == sum(count for count, _, _ in counted.values())
    assert row["exchanged"] == total(load, "sent") == total(load, "received"), row
    assert row["exchanged_bytes"] == total(load, "bytes_sent"), row
    assert row["dropped"] == sum(dropped for _, _, dropped in counted.values()), row
    seconds: dict[int, float] = defaultdict(float)
    for one in load:
        seconds[one["rank"]] += one["t_compute_s"]
    mean = sum(seconds.values()) / len(seconds)
    assert row["imbalance"] == pytest.approx(max(seconds.values()) / mean, rel=1e-4)
    assert seconds[row["slowest_rank"]] == pytest.approx(max(seconds.values()), rel=1e-4)
    for column, whole in (("t_exchange_s", "t_exchange_s"), ("t_image_s", "t_render_s")):
        assert max(one[column] for one in load) <= row[whole] * (1 + 1e-5), row


@pytest.mark.parametrize(("ranks", "way"), WAYS)
def test_rows_of_ranks_add_up_to_those_of_frames(tmp_path: Path, ranks: int, way: Row) -> None:
    result = on_ranks(ranks, SCENE, tmp_path, json.dumps(ONE | way))
    assert result.code == 0, result.text
    lines = [json.loads(line) for line in result.lines]
    said = [line for line in lines if isinstance(line, list)]
    frames, load = rows_of(tmp_path / "frames.jsonl"), rows_of(tmp_path / "load.jsonl")
    assert [row["frame"] for row in frames] == [frame for frame, _ in said] == list(range(12))
    check_rows(load, rows_of(tmp_path / "density.jsonl"))
    born: dict[str, int] = defaultdict(int)
    for row, (frame, systems) in zip(frames, said, strict=True):
        mine = [one for one in load if one["frame"] == frame]
        check_frame(row, mine, {name: counts for name, *counts in systems})
        for name, count, born_by_now, _ in systems:
            of_it = [one for one in mine if one["system"] == name]
            assert total(of_it, "n_end") == count
            assert total(of_it, "created") == born_by_now - born[name], (frame, name)
            born[name] = born_by_now
    accounts = [line for line in lines if isinstance(line, dict)]  # the core's totals during the run
    assert len(accounts) > 8
    for account in accounts:
        assert account == {name: frames[account["frame"]][name] for name in account}
    calculators = {row["rank"] for row in load}
    assert total(load, "interactions") > 0 and frames[-1]["dropped"] > 100
    if len(calculators) > 1:
        assert total(load, "ghosts") > 0 and total(frames, "exchanged_bytes") > 10_000
        assert (total(frames, "exchanged") > 100) == ("axis" not in way or way["axis"] is not BY_ID)
