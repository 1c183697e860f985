"""Each notebook runs from its first cell to its last, and the statements in its text are true."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("pandas")
pytest.importorskip("matplotlib")
nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "notebooks"
pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason="the notebooks need the source tree")

# Checks count particles, not seconds, which depend on the machine's load. Seconds still move the cuts, so
# bounds are wide.
BALANCING = """
# The paper counts processes, two of which are the manager and the image generator.
from motes.cluster.paper.tables import cells
rows = {(cell.processes - 2, cell.variant): cell.speedup for cell in cells(3) if cell.processes < 9}
assert all(paper.loc[n, name] == rows[n, name] for n in paper.index for name in paper.columns)
def speedup(n, name):
    return n / table[n, name].imbalance("n_end").mean()

def share(run):  # of the slow rank, once the first frames have passed
    held = run.load.query("frame > 30").groupby("rank")["n_end"].mean()
    return held[3] / held.sum()

def moved(run):
    return run.frames["exchanged"].mean()

# One of five, or one after the other of two in the middle of four, has all particles in infinite space.
assert set(table[5, "IS-SLB"].load.query("n_end > 0")["rank"]) == {2}
assert set(table[4, "IS-SLB"].load.query("n_end > 0")["rank"]) == {1, 2}
# Dynamic cuts come in from far away and win, and then the space hardly matters.
for n in (4, 5):
    static, dynamic = ([speedup(n, f"{space}-{way}") for space in ("IS", "FS")] for way in ("SLB", "DLB"))
    assert min(dynamic) > 1.2 * max(static)
    assert max(dynamic) < 1.4 * min(dynamic)
# Snow has nothing to gain, the gust a factor.
assert weather["snow", "SLB"].imbalance("n_end").mean() < 1.1
gust = {name: weather["gust", name].imbalance("n_end").mean() for name in ("SLB", "DLB")}
assert gust["SLB"] > 1.3 * gust["DLB"]
# The slow rank gets less than a quarter.
assert share(uneven[2]) < 0.23 and share(mine) < 0.23
# A replay predicts how many particles move, and pairs move most.
for balancer, real in ((motes.balance.PrefixCuts(), uneven[2]), (Gentle(), mine)):
    assert 0.4 < moved(recorded.replay(balancer)) / moved(real) < 2.5
    assert moved(real) < 0.9 * moved(recorded)
# On a slow network balancing loses. What messages add there is the particles moved, whatever the load.
sent = {name: ms[0] - ms[-1] for name, ms in frame_ms.items()}
assert sent["Static"] < min(sent[name] for name in ("Pairwise", "PrefixCuts", "Gentle"))
"""

# Checks count bytes, which hardly depend on seconds. (The notebook itself compares the pixels.)
PICTURES = """
sent = costs["sent"]
assert sent["near"]["tiles"] < 0.9 * min(sent["near"]["gather"], sent["near"]["composite"])
assert sent["far"]["composite"] < 0.2 * min(sent["far"]["gather"], sent["far"]["tiles"])
assert sent["near"]["gather"] > 0.7 * 8e-6 * films["near", "gather"].frames["records"].mean()
assert share["in front"] < 0.4 < share["at the side"]
assert {path for path in chosen["near"].frames["render_path"]} == {"tiles"}
assert chosen["far"].frames["render_path"].tolist()[3:] == ["composite"] * 7
"""

FIRST_STEPS = """
assert run.frames["frame"].tolist() == list(range(240))
assert (run.frames["particles"].tail(100) == 96 * 40).all() and run.frames["particles"][94] < 96 * 40
assert os.path.getsize("snow.mp4") > 10_000 and "<video" in film._repr_html_()
assert 3.9 < flakes["age"].max() < 4.1 and -0.5 < flakes["position_y"].min() < 0.5
assert not player.running and player.result() is None
"""

NOTEBOOKS = {"balancing": (BALANCING, 11), "first_steps": (FIRST_STEPS, 3), "pictures": (PICTURES, 2)}
"""For each notebook: checks to run at its end, and its number of figures."""


def pictures(notebook):
    """Count the figures among the outputs."""
    return sum(
        "image/png" in output.get("data", {})
        or "data:image/png" in output.get("data", {}).get("text/html", "")
        for cell in notebook.cells
        if cell.cell_type == "code"
        for output in cell.outputs
    )


def test_all_notebooks_are_tested():
    assert {path.stem for path in FOLDER.glob("*.ipynb")} == set(NOTEBOOKS)


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_what_is_committed_was_executed(name):
    path = FOLDER / f"{name}.ipynb"
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))
    assert pictures(notebook) == NOTEBOOKS[name][1]
    assert not any(output.output_type == "error" for cell in code for output in cell.outputs)
    assert path.stat().st_size < 600_000


@pytest.mark.timeout(900)
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[] if name == "first_steps" else [pytest.mark.slow]) for name in NOTEBOOKS],
)
def test_the_notebook_runs_and_its_claims_hold(name, monkeypatch):
    monkeypatch.setenv("MOTES_PROGRESS", "")
    claims, figures = NOTEBOOKS[name]
    notebook = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    notebook.cells.append(nbformat.v4.new_code_cell(claims))
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    assert pictures(notebook) == figures
