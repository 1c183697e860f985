"""Plots: they show the log's values, with labels and units, on the axes they are given."""

from __future__ import annotations

import inspect
import shutil

import numpy as np
import pytest
from handmade import load_row, moving_spot, rows, write_log

import motes
from motes import ArgumentError, LogError

pytest.importorskip("pandas")
matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")

from matplotlib import pyplot  # noqa: E402
from matplotlib.axes import Axes  # noqa: E402

from motes.analysis._plots import Plots, drawing, timeline  # noqa: E402


@pytest.fixture(scope="module")
def spot(tmp_path_factory):
    return motes.open_run(moving_spot(tmp_path_factory.mktemp("spot") / "run", frames=12))


@pytest.fixture
def small(tmp_path):
    """Return a run of two calculators and two frames; rank 1 takes three times as long, then equally long."""
    load = [
        load_row(frame, "a", rank, n_end=n, t_compute_s=s, t_exchange_s=0.1, t_image_s=0.05, t_wait_s=0.4)
        for frame, slow in enumerate((0.6, 0.2))
        for rank, s, n in ((0, 0.2, 10), (1, slow, 30))
    ]
    for row in load:
        row["domain_hi" if row["rank"] == 0 else "domain_lo"] = 0.25
    return motes.open_run(write_log(tmp_path / "run", load, facts={"ranks": [{"rank": 0}, {"rank": 1}]}))


@pytest.fixture(autouse=True)
def closed():
    yield
    pyplot.close("all")


PLOTS = [name for name, method in inspect.getmembers(Plots, inspect.isfunction) if not name.startswith("_")]


@pytest.mark.parametrize("name", PLOTS)
def test_every_plot_draws_where_it_is_told_and_says_what(spot, name, monkeypatch):
    monkeypatch.setattr(pyplot, "show", lambda *_, **__: pytest.fail("a plot must not show itself"))
    mine = pyplot.figure().add_subplot()
    drawn = getattr(spot.plot, name)(ax=mine)
    fresh = getattr(spot.plot, name)()
    mine.figure.canvas.draw()
    assert drawn is mine
    assert isinstance(fresh, Axes)
    assert fresh is not mine
    for ax in (drawn, fresh):
        assert ax.get_xlabel()
        assert ax.get_ylabel() or name == "gantt"
        assert "Pairwise(threshold=0.1)" in ax.get_title(loc="left")


def test_lines_are_the_measures(small):
    ax = small.plot.imbalance()
    line = ax.get_lines()[0]
    assert line.get_xdata().tolist() == [0, 1]
    assert line.get_ydata() == pytest.approx([1.5, 1.0])
    assert small.plot.efficiency().get_lines()[0].get_ydata() == pytest.approx([2 / 3, 1.0])
    assert small.plot.imbalance(column="n_end").get_lines()[0].get_ydata() == pytest.approx([1.5, 1.5])


def test_runs_on_one_axes_have_colours_and_names_of_their_own(small, spot):
    ax = small.plot.imbalance(label="static")
    spot.plot.imbalance(label="pairwise", ax=ax)
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["static", "pairwise"]
    named = [line for line in ax.get_lines() if not line.get_label().startswith("_")]
    assert len({line.get_color() for line in named}) == 2
    assert ax.get_ylim()[1] > max(spot.imbalance())


def test_smoothing_is_a_mean_over_frames(small):
    lines = small.plot.imbalance(smooth=2).get_lines()
    assert lines[0].get_ydata() == pytest.approx([1.5, 1.0]), "what was measured stays visible"
    assert lines[1].get_ydata() == pytest.approx([1.5, 1.25])
    with pytest.raises(ArgumentError, match="smooth"):
        small.plot.imbalance(smooth=0)


def test_cells_are_the_table(small):
    ax = small.plot.heatmap("t_compute_s")
    assert np.allclose(ax.collections[0].get_array(), [[200, 200], [600, 200]])
    assert ax.figure.axes[1].get_ylabel() == "compute (ms)"
    assert [text.get_text() for text in ax.get_yticklabels()] == ["0", "1"]
    assert small.plot.heatmap("n_end").collections[0].get_array().tolist() == [[10, 10], [30, 30]]


def test_one_interrupted_frame_does_not_darken_the_others(tmp_path):
    load = [load_row(frame, "a", 0, t_compute_s=1.0 if frame == 7 else 0.001) for frame in range(1000)]
    mesh = motes.open_run(write_log(tmp_path / "run", load)).plot.heatmap().collections[0]
    assert mesh.norm.vmax == pytest.approx(1.0)


def test_domains_of_a_run_without_density(small):
    ax = small.plot.domains()
    (cut,) = ax.get_lines()
    assert cut.get_xdata().tolist() == [0, 1, 2], "the last frame has its width"
    assert cut.get_ydata().tolist() == [0.25] * 3
    low, high = ax.get_ylim()
    assert low < -1
    assert high > 1
    assert ax.get_ylabel() == "x (m)"
    assert len(ax.collections) == 2


def test_domains_show_where_particles_are(spot):
    ax = spot.plot.domains("cloud")
    medians = [line for line in ax.get_lines() if line.get_color() != "#333333"]
    rank2 = spot.density[spot.density["rank"] == 2]
    assert medians[0].get_ydata() == pytest.approx(rank2["x_q08"].to_numpy(), nan_ok=True)
    low, high = ax.get_ylim()
    assert low < spot.density["x_q01"].min() < spot.density["x_q15"].max() < high
    assert len(spot.plot.domains(particles=False).get_lines()) == 3
    with pytest.raises(ArgumentError, match="system"):
        spot.plot.domains("sand")


def test_a_system_may_have_an_axis_of_its_own(tmp_path):
    load = [load_row(0, system, 0) for system in ("a", "b")]
    run = motes.open_run(write_log(tmp_path / "run", load, facts={"axis": "x", "axes": ["x", "z"]}))
    assert [run.plot.domains(system).get_ylabel() for system in ("a", "b")] == ["x (m)", "z (m)"]


def test_infinite_space_is_looked_at_where_the_particles_are(tmp_path):
    cuts = {0: 0.0, 1: 2.0**19}
    load = [
        load_row(f, "a", r, n_end=9, domain_lo=cuts.get(r - 1), domain_hi=cuts.get(r))
        for f in range(3)
        for r in range(3)
    ]
    log = write_log(tmp_path / "run", load, facts={"space": None})
    points = {f"x_q{i:02d}": -4 + i / 2 for i in range(17)}
    rows(log / "density.jsonl", [{"frame": f, "system": "a", "rank": 1, "n": 9, **points} for f in range(3)])
    ax = motes.open_run(log).plot.domains()
    low, high = ax.get_ylim()
    assert -8 < low < -3.5
    assert 3.5 < high < 8
    assert any("1 cut outside the plot" in text.get_text() for text in ax.texts)


def test_shares_and_what_is_fair(spot, small):
    ax = spot.plot.shares()
    fair = sorted(line.get_ydata()[0] for line in ax.get_lines())
    assert fair == pytest.approx([1 / 3.5, 2 / 3.5, 3 / 3.5])
    top = small.plot.shares().collections[0].get_paths()[0].vertices[:, 1].max()
    assert top == pytest.approx(0.25)


def test_speeds_are_in_millions_with_what_factors_say(spot):
    ax = spot.plot.speeds()
    assert np.nanmax(ax.get_lines()[0].get_ydata()) == pytest.approx(4.0, rel=1e-3)
    dashed = [line.get_ydata()[0] for line in ax.get_lines() if line.get_linestyle() == "--"]
    assert dashed == pytest.approx([4, 4, 4, 2], rel=1e-3)


def test_given_is_signed(spot):
    ax = spot.plot.given()
    expected = spot.balance.pivot(index="left_rank", columns="frame", values="given")
    assert np.array_equal(ax.collections[0].get_array(), expected.to_numpy())
    assert ax.collections[0].norm.vmin == -ax.collections[0].norm.vmax
    assert [text.get_text() for text in ax.get_yticklabels()] == ["2|3", "3|4", "4|5"]


def test_given_of_a_balancer_that_cuts_anew_shows_the_cuts(tmp_path, spot):
    log = write_log(tmp_path / "run", [load_row(f, "a", r) for f in range(2) for r in range(3)])
    ends = [(0, 0, 1.0, 1.5), (0, 1, 4.0, 2.0), (1, 0, 1.5, 1.5), (1, 1, 2.0, 2.25)]
    fields = ("frame", "left_rank", "cut_before", "cut_after")
    table = [dict(zip(fields, row, strict=True)) for row in ends]
    rows(log / "balance.jsonl", [{**row, "system": "a", "right_rank": row["left_rank"] + 1} for row in table])
    ax = motes.open_run(log).plot.given()
    assert ax.collections[0].get_array().tolist() == [[0.5, 0.0], [-2.0, 0.25]]
    assert ax.figure.axes[1].get_ylabel() == "moved to the right (m)"


def test_given_without_a_balancer_says_so(small):
    with pytest.raises(LogError, match=r"no cut was evaluated.*Static"):
        small.plot.given()


def test_exchange(spot):
    ax = spot.plot.exchange()
    (stairs,) = ax.patches
    assert stairs.get_data().values.tolist() == spot.frames["exchanged"].tolist()
    assert stairs.get_data().edges[:2].tolist() == [-0.5, 0.5]
    right = next(other for other in ax.figure.axes if other is not ax)
    assert right.get_lines()[0].get_ydata() * 1024 == pytest.approx(spot.frames["exchanged_bytes"].to_numpy())
    assert "KiB" in right.get_ylabel()


# --- phases and times


def stacks(ax):
    """Read a stacked bar chart; return the heights by label."""
    return {box.get_label(): [bar.get_height() for bar in box] for box in ax.containers}


def test_phases_without_spans_add_up_to_the_frame(small):
    found = stacks(small.plot.phases(frames=[0]))
    assert found["compute"] == pytest.approx([200, 600])
    assert found["exchange"] == pytest.approx([100, 100])
    assert found["image"] == pytest.approx([50, 50])
    assert found["wait"] == pytest.approx([400, 250]), "no more than is left of the frame"
    assert np.sum(list(found.values()), axis=0) == pytest.approx([1000, 1000])
    assert stacks(small.plot.phases())["compute"] == pytest.approx([200, 400])


def test_phases_from_spans_show_all_ranks(spot, tmp_path):
    log = shutil.copytree(spot.path, tmp_path / "old")
    (log / "times.jsonl").unlink()
    spot = motes.open_run(log)  # a log of an earlier version
    ax = spot.plot.phases()
    found = stacks(ax)
    assert [text.get_text() for text in ax.get_xticklabels()] == ["0", "1", "2", "3", "4", "5"]
    act = spot.load.groupby("rank")["t_compute_s"].mean() * 1e3
    assert found["act"] == pytest.approx([0, 0, *act])
    assert found["render"] == pytest.approx([1.2] + [0.5] * 5)


def test_gantt_of_spans(spot):
    ax = spot.plot.gantt([3, 4])
    spans = spot.spans[spot.spans["frame"].isin([3, 4])]
    begin = spans["start_s"].min()
    bars = {(round(b.get_x(), 6), round(b.get_width(), 6)) for box in ax.containers for b in box}
    expected = {
        (round((a - begin) * 1e3, 6), round((b - a) * 1e3, 6))
        for a, b in zip(spans["start_s"], spans["end_s"], strict=True)
    }
    assert bars == expected
    assert [text.get_text() for text in ax.get_yticklabels()] == ["0 image", "1 manager", "2", "3", "4", "5"]
    assert "put together" not in ax.get_title(loc="left")


def test_gantt_without_spans_says_that_places_are_guessed(small):
    ax = small.plot.gantt()
    assert "reconstructed from durations" in ax.get_title(loc="left")
    found, measured = timeline.slices(small)
    assert not measured
    act = found[(found["phase"] == "act") & (found["frame"] == 1)]
    assert (act["end_s"] - act["start_s"]).tolist() == pytest.approx([0.2, 0.2])
    assert act["start_s"].min() == pytest.approx(1.0), "the second frame starts when the first ended"
    for _, mine in found.groupby("rank"):
        assert (mine["start_s"].to_numpy()[1:] >= mine["end_s"].to_numpy()[:-1] - 1e-12).all()


def test_frames_that_are_not_there(small):
    with pytest.raises(ArgumentError, match="frames"):
        small.plot.gantt([77])


@pytest.mark.parametrize("name", PLOTS)
def test_an_empty_log_is_no_picture(tmp_path, name):
    run = motes.open_run(write_log(tmp_path / "run", []))
    with pytest.raises(LogError, match="run: no "):
        getattr(run.plot, name)()


def test_colours_can_be_told_apart_without_red_and_green():
    """Lines differ under simulated protanopia and deuteranopia (Vienot, Brettel and Mollon 1999)."""
    to_rgb = matplotlib.colors.to_rgb
    lms = np.array([[17.8824, 43.5161, 4.11935], [3.45565, 27.1554, 3.86714], [0.0299566, 0.184309, 1.46709]])
    blind = {
        "protanopia": np.array([[0, 2.02344, -2.52581], [0, 1, 0], [0, 0, 1]]),
        "deuteranopia": np.array([[1, 0, 0], [0.494207, 0, 1.24827], [0, 0, 1]]),
    }
    linear = np.array([np.power(to_rgb(color), 2.2) for color in drawing.PALETTE])
    for name, loss in blind.items():
        seen = np.clip(linear @ (np.linalg.inv(lms) @ loss @ lms).T, 0, 1) ** (1 / 2.2)
        apart = np.linalg.norm(seen[:, None] - seen[None], axis=2) + 9 * np.eye(len(seen))
        assert apart.min() > 0.1, f"{name}: {np.argwhere(apart < 0.1).tolist()}"


# --- many runs


def test_speedup_of_runs(tmp_path):
    for n, seconds in ((1, 4.0), (2, 2.0), (4, 1.5)):
        load = [load_row(0, "a", rank) for rank in range(n)]
        facts = {"ranks": [{"rank": rank} for rank in range(n)]}
        write_log(tmp_path / str(n), load, facts=facts, t_frame_s=seconds)
    ax = motes.open_runs(tmp_path).plot.speedup()
    line, ideal = ax.get_lines()
    assert line.get_xdata().tolist() == [1, 2, 4]
    assert line.get_ydata() == pytest.approx([1, 2, 4 / 1.5])
    assert list(ideal.get_ydata()) == [1, 4]
    assert line.get_label() == "FS-SLB" and ax.get_ylabel() == "times as fast as 1"


def test_lines_of_runs_are_named_by_what_differs(tmp_path):
    for name, balancer in (("a", "Static()"), ("b", "Pairwise(threshold=0.1)")):
        write_log(tmp_path / name, [load_row(0, "a", 0, t_compute_s=1.0)], facts={"balancer": balancer})
    runs = motes.open_runs(tmp_path)
    ax = runs.plot.imbalance()
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [
        "Static()",
        "Pairwise(threshold=0.1)",
    ]
    assert isinstance(runs.plot.efficiency(), Axes)


@pytest.fixture
def bricks(tmp_path):
    """Three calculators with bricks as domains: x is cut at 0, the upper half at y = 0.5, later at 0.25."""
    load = []
    for frame, y in enumerate((0.5, 0.25)):
        load.append(load_row(frame, "a", 0, n_end=5, domain_hi=0.0))
        load.append(load_row(frame, "a", 1, n_end=5, domain_lo=0.0, domain_y_hi=y))
        load.append(load_row(frame, "a", 2, n_end=5, domain_lo=0.0, domain_y_lo=y))
    facts = {"ranks": [{"rank": 0}, {"rank": 1}, {"rank": 2}], "axes": ["xy"]}
    return motes.open_run(write_log(tmp_path / "run", load, facts=facts))


def test_bricks_are_drawn_in_their_plane(bricks):
    ax = bricks.plot.domains()
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x (m)", "y (m)")
    drawn = [patch.get_xy()[:4] for patch in ax.patches if patch.get_facecolor()[3] > 0]
    assert [tuple(np.ptp(corners, axis=0)) for corners in drawn] == [(1, 2), (1, 1.25), (1, 0.75)]
    first = bricks.plot.domains(frame=0)
    assert first.patches[2].get_xy()[:4].max() == 1 and 0.5 in first.patches[2].get_xy()[:, 1]
    with pytest.raises(ArgumentError, match="frame must be a frame of the log"):
        bricks.plot.domains(frame=2)
