"""Benchmarks: every action is measured, and figures match their names.

Times are not checked, because machines differ.
"""

from __future__ import annotations

import itertools
import json
import re
from typing import Any

import pytest

from motes import _core
from motes._launch import starting
from motes._system.session import Session
from motes.actions import between
from motes.cli import main
from motes_lab.bench import overhead, paths

BETWEEN = [*between.__all__, "Interact"]
MEETINGS = {re.sub("(?<!^)(?=[A-Z])", "_", name).lower() for name in BETWEEN} | {"contact_clumps", "pairs"}
ACTIONS = [name for name in _core.action_names() if name not in MEETINGS]


def figures(capsys: pytest.CaptureFixture[str], *argv: str) -> dict[str, Any]:
    """Run a benchmark and return its JSON object."""
    assert main(["bench", *argv, "--json"]) == 0
    result: dict[str, Any] = json.loads(capsys.readouterr().out)
    return result


def test_every_action_has_its_cost(capsys):
    found = figures(capsys, "actions", "--particles", "4096", "--repeats", "2")
    assert set(found["actions"]) == set(ACTIONS)
    for name, cost in found["actions"].items():
        assert cost["alone_ns"] > 0, name
        assert cost["alone_in_cache_ns"] > 0, name
        assert cost["bytes_loaded"] >= cost["bytes_stored"], name
    gravity, restore = found["actions"]["gravity"], found["actions"]["restore"]
    assert (gravity["bytes_loaded"], gravity["bytes_stored"]) == (12, 12)
    assert (restore["bytes_loaded"], restore["bytes_stored"]) == (72, 48)


PICTURE = "--particles 5000 --size 64x36 --frames 2"
FACTS: list[tuple[str, dict[str, Any]]] = [
    ("meshes --particles 20000 --repeats 2", {"triangles": 72 * 71 * 2, "grid_bytes": 4 * 101**3}),
    ("snow --particles 20000 --steps 3", {"particles": 20000}),
    ("fountain --particles 20000 --steps 3", {"particles": 20000}),
    ("lists --particles 20000 --steps 5", {}),
    (f"render {PICTURE}", {"particles": 5000}),
    (f"render {PICTURE} --fountain", {"particles": 5000}),
    ("scenery --size 64x36 --frames 2", {"width": 64, "height": 36, "mesh_triangles": 100_000}),
    ("leavers --particles 5000 --steps 2 --bins 8", {"particles": 5000, "bins": 8}),
    ("scale --particles 30000 --steps 1", {"largest_by_least": 1}),
    *((f"births --calculators {n} --births 500 --repeats 5", {}) for n in (1, 3, 40)),
    ("recording --systems 2 --frames 3", {"systems": 2, "actions": 24, "frames": 3}),
    ("sums --particles 2000 --repeats 2", {}),
    ("checkpoint --particles 500 --systems 2 --every 3 --repeats 2", {"particles": 1000, "every": 3}),
]


@pytest.mark.parametrize(("command", "facts"), FACTS, ids=[command for command, _ in FACTS])
def test_figures_are_above_0_and_of_what_was_asked(command: str, facts: dict[str, Any], capsys):
    found = figures(capsys, *command.split())
    assert facts.items() <= found.items()
    numbers = {name: value for name, value in found.items() if isinstance(value, (int, float))}
    assert len(numbers) > len(facts) and not [name for name, value in numbers.items() if not value > 0]


def test_every_meeting_has_its_cost(capsys):
    found = figures(capsys, "meetings", "--particles", "3000", "--repeats", "2")
    assert len(found["rows"]) >= 5 and all(row["ns"] > 0 for row in found["rows"])
    assert 5 < found["neighbours"] < 9


def test_each_kind_and_blend_of_sprites_has_its_cost(capsys):
    rows = figures(capsys, "render", *PICTURE.split())["rows"]
    kinds, blends = ("point", "disc", "sphere", "image"), ("add", "alpha", "opaque")
    assert {(row["kind"], row["blend"]) for row in rows} == set(itertools.product(kinds, blends))
    assert all(row["ms_per_frame"] > row["ms_project"] > 0 for row in rows)


def test_overhead_compares_balancers_with_static_cuts(capsys):
    sizes = ["--systems", "2", "--particles", "4000", "--rounds", "3", "--frames", "2"]
    found = figures(capsys, "overhead", *sizes)
    rows = {row["balancer"]: row for row in found["rows"]}
    assert list(rows) == ["static", "static again", "pairwise", "diffusive", "prefix", "proportional"]
    assert rows["static"]["overhead_percent"] == 0
    assert rows["static"]["balance_ms"] == 0
    assert all(row["frame_ms"] > 0 and row["act_ms"] > 0 for row in rows.values())
    for row in rows.values():
        ratio = row["frame_ms"] / rows["static"]["frame_ms"]
        assert row["overhead_percent"] == pytest.approx(100 * (ratio - 1)), "of what stands beside it"
    assert (found["ranks"], found["calculators"], found["particles"]) == (4, 2, 4000)
    assert main(["bench", "overhead", "--ranks", "2", "--particles", str(2**63), *sizes[4:]]) == 2
    assert "the job on 2 ranks failed" in capsys.readouterr().err


def test_differences_within_a_round_count():
    static, own = [1.0, 5.0, 1.2], [1.1, 5.1, 1.4]  # the second round was slow for both
    assert overhead._beside(own, static) == pytest.approx(1.2 + 0.1)
    assert overhead._beside(static, static) == 1.2
    times = [{f"t_{phase}_s": float(i) for phase in overhead.PHASES} for i in range(4)]
    assert overhead._by_round(times, 2)["act"] == [0.5, 2.5]


def test_text_is_a_table(capsys):
    assert main(["bench", "actions", "--particles", "1000", "--repeats", "1"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[1:-2]] == ACTIONS


@pytest.mark.parametrize(
    ("path", "far", "drawn"), [("tiles", (), "tiles"), ("auto", ("--far",), "composite")]
)
def test_paths_compare_layouts_with_the_first(path, far, drawn, capsys):
    sizes = ["--particles", "200000", "--rounds", "1", "--frames", "2", "--size", "320x180"]
    found = figures(capsys, "paths", *sizes, "--path", path, *far, "--layouts", "1", "2 shared")
    one, two = found["rows"]
    assert (one["layout"], two["layout"]) == ("1", "2 shared")
    assert (one["speedup"], one["cpu_speedup"]) == (1, 1)
    assert two["path"] == drawn
    assert 0 < two["busiest_cpu_ms"] < two["all_cpu_ms"] < 2.1 * two["busiest_cpu_ms"]
    assert two["frame_ms"] > 0 and two["speedup"] > 0
    assert "of_apart" not in two


def test_paths_compare_layouts_with_jobs_that_know_nothing_of_each_other(capsys):
    sizes = ["--particles", "200000", "--rounds", "1", "--frames", "3", "--size", "320x180", "--parts"]
    found = figures(capsys, "paths", *sizes, "--layouts", "1", "2 apart", "2 shared")
    one, apart, two = found["rows"]
    assert apart["of_apart"] == 1
    assert two["of_apart"] == pytest.approx(apart["frame_ms"] / two["frame_ms"])
    assert one["act_speedup"] == 1 and two["act_speedup"] == pytest.approx(one["act_ms"] / two["act_ms"])
    assert (len(found["parts"]["1"]["draw"]), len(found["parts"]["2 apart"]["draw"])) == (1, 2)
    assert apart["busiest_cpu_ms"] < apart["all_cpu_ms"] < 2.1 * apart["busiest_cpu_ms"]


def test_jobs_apart_share_the_systems(monkeypatch):
    def job(layout, options, parts):
        asked.append((layout.ranks, *options))
        return {"path": "gather", "frame_ms": len(asked), "act_ms": 1, "busiest_cpu_ms": 1, "all_cpu_ms": 1}

    asked: list[tuple] = []
    monkeypatch.setattr(paths, "_job", job)
    figures = paths._run(paths.LAYOUTS["2 apart"], 800, ["--far"], False)
    assert asked == 2 * [(1, "--particles=400", "--systems=4", "--far")]
    assert (figures["frame_ms"], figures["all_cpu_ms"]) == (2, 2)
    asked.clear()
    paths._run(paths.LAYOUTS["2 shared"], 800, ["--far"], False)
    assert asked == [(2, "--particles=800", "--systems=8", "--far")]


def test_paths_tell_the_processor_time_of_each_part(capsys):
    sizes = ["--particles", "200000", "--rounds", "1", "--frames", "3", "--size", "320x180"]
    options = ["--path", "tiles", "--objects", "--blend", "opaque", "--parts"]
    found = figures(capsys, "paths", *sizes, *options, "--layouts", "1", "2 shared")
    assert (found["objects"], found["blend"]) == (True, "opaque")
    for row, ranks in zip(found["rows"], (1, 2), strict=True):
        parts = found["parts"][row["layout"]]
        assert all(len(spent) == ranks for spent in parts.values())
        assert all(min(parts[name]) > 0 for name in ("act", "project", "draw"))
        drawn = sum(sum(spent) for spent in parts.values())
        assert 0.3 * row["all_cpu_ms"] < drawn < 1.1 * row["all_cpu_ms"]


def test_costs_of_pictures_are_positive(capsys):
    found = figures(capsys, "costs", "--particles", "20000", "--size", "320x180", "--repeats", "1")
    names = (
        "kProject",
        "record of 5 pixels",
        "kPixel",
        "kBloomPixel",
        "kSpreadPixel",
        "kPartialPixel",
        "kMessage",
    )
    assert all(found[name] > 0 for name in names)
    assert 0 <= found["kByte"] < 50


def test_a_viewers_wait_is_measured(capsys):
    pytest.importorskip("websockets")
    pytest.importorskip("simplejpeg")
    found = figures(capsys, "live", "--particles", "500", "--size", "160x90", "--orders", "8")
    assert found["orders"] == 8 and found["ranks"] == 2
    assert 0 < found["order_to_picture_ms"] <= found["order_to_picture_p95_ms"]
    assert found["paused_order_to_picture_ms"] > 0 and found["frames_per_s"] >= found["pictures_per_s"] * 0.5


class Slow:
    """An engine on a disk so slow that every checkpoint is still being written."""

    def __init__(self, engine):
        self._engine = engine

    def part_outcome(self):
        return True, *self._engine.part_outcome()[1:]


def test_checkpoints_on_a_slow_disk_are_measured_too(capsys, monkeypatch):
    engine_for = Session.engine_for
    looks = itertools.count()

    def slow_for(session, call):
        engine = engine_for(session, call)
        begun = call == "bench" and next(looks) >= 3  # from the first checkpoint on
        return Slow(engine) if begun else engine

    monkeypatch.setattr(Session, "engine_for", slow_for)
    sizes = ("--particles", "500", "--systems", "2", "--every", "3", "--repeats", "2")
    assert figures(capsys, "checkpoint", *sizes)["write_ms"] > 0


def test_frames_without_a_checkpoint_are_needed(capsys):
    assert main(["bench", "checkpoint", "--particles", "500", "--every", "1"]) != 0
    assert "--every must be a whole number >= 2" in capsys.readouterr().err


@pytest.mark.skipif(starting.cannot_survive() is not None, reason=str(starting.cannot_survive()))
def test_losses_are_measured_beside_frames(capsys):
    found = figures(
        capsys, "recovery", "--particles", "500", "--systems", "2", "--repeats", "1", "--ranks", "3"
    )
    assert found["particles"] == 1000 and found["ranks"] == 3 and found["every"] == 12
    assert found["frame_ms"] > 0 and found["recovery_ms"] > 0


def test_exports_are_measured_beside_a_plain_write(capsys):
    found = figures(capsys, "export", "--particles", "3000", "--repeats", "2")
    assert found["particles"] > 1500 and found["copy_ms"] > 0
    rows = {row["format"]: row for row in found["rows"]}
    assert {"npz", "vtp"} <= set(rows) and set(rows) ^ set(found["not_installed"]) <= {
        "npz",
        "vtp",
        "usdc",
        "usd-core",
    }
    assert 60 < rows["npz"]["megabytes"] < 80, "64 bytes per particle"
    assert 80 < rows["vtp"]["megabytes"] < 110, "as text of four characters for three bytes, and vertices"
    assert all(row["ms"] > 0 and row["by_plain"] > 0 for row in rows.values())
