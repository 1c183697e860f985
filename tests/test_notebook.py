"""The notebook on balancing runs from its first cell to its last, and what its text says is so."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("pandas")
pytest.importorskip("matplotlib")
nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")

PATH = Path(__file__).resolve().parents[1] / "docs" / "notebooks" / "balancing.ipynb"
pytestmark = pytest.mark.skipif(not PATH.is_file(), reason="the notebook needs the source tree")

CLAIMS = """
# One of five, or one after the other of two in the middle of four, has all particles in infinite space.
assert set(table[5, "IS-SLB"].load.query("n_end > 0")["rank"]) == {2}
assert set(table[4, "IS-SLB"].load.query("n_end > 0")["rank"]) == {1, 2}
# Dynamic cuts come in from far away and win, and then the space hardly matters.
for n in (4, 5):
    assert ours.loc[n, ["IS-DLB", "FS-DLB"]].min() > 1.3 * ours.loc[n, ["IS-SLB", "FS-SLB"]].max()
    assert abs(ours.loc[n, "IS-DLB"] / ours.loc[n, "FS-DLB"] - 1) < 0.2
# Snow has nothing to gain, the gust a factor.
assert weather["snow", "SLB"].imbalance("n_end").mean() < 1.1
gust = {name: weather["gust", name].imbalance("n_end").mean() for name in ("SLB", "DLB")}
assert gust["SLB"] > 1.5 * gust["DLB"]
# Cuts at once beat pairs where the cloud moves on, and the slow rank gets less.
assert uneven[2].imbalance().tail(30).mean() < uneven[0].imbalance().tail(30).mean()
assert uneven[2].load.query("frame > 30").groupby("rank")["n_end"].mean().idxmin() == 3
# A replay predicts, and pairs hand over most.
for balancer, real in ((motes.PrefixCuts(), uneven[2]), (Gentle(), mine)):
    predicted = recorded.replay(balancer)
    assert abs(predicted.imbalance().mean() / real.imbalance().mean() - 1) < 0.25
    assert abs(predicted.frames["exchanged"].mean() / real.frames["exchanged"].mean() - 1) < 0.5
    assert real.frames["exchanged"].mean() < 0.7 * recorded.frames["exchanged"].mean()
"""


def pictures(notebook):
    """Count the figures among the outputs."""
    return sum(
        "image/png" in output.get("data", {})
        or "data:image/png" in output.get("data", {}).get("text/html", "")
        for cell in notebook.cells
        if cell.cell_type == "code"
        for output in cell.outputs
    )


def test_what_is_committed_was_executed():
    notebook = nbformat.read(PATH, as_version=4)
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))
    assert pictures(notebook) == 10
    assert not any(output.output_type == "error" for cell in code for output in cell.outputs)
    assert PATH.stat().st_size < 600_000


def test_the_notebook_runs_and_its_claims_hold(monkeypatch):
    monkeypatch.setenv("MOTES_PROGRESS", "")
    notebook = nbformat.read(PATH, as_version=4)
    notebook.cells.append(nbformat.v4.new_code_cell(CLAIMS))
    nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3").execute()
    assert pictures(notebook) == 10
