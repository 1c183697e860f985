"""Jobs under Slurm on three simulated hosts: srun alone, allocations, time limits, arrays."""

from __future__ import annotations

import csv
import json
import os
import re
import sys
from pathlib import Path

import pytest
from launching import mpirun, python
from slurm import Cluster, missing, slurm

ROOT = Path(__file__).resolve().parents[2]
EVERYTHING = ROOT / "tests" / "scenes" / "everything.py"
PAGE = ROOT / "docs" / "clusters.md"
SNOW = ROOT / "examples" / "snow.py"
VARIANTS = json.dumps([{"roles": "auto", "space": None}, {"roles": "shared", "space": [-3, 3]}])
SMALL = ("--systems", 2, "--particles", 3000, "--frames", 6, "--size", "320x180", "--digest")
LACK = missing()
pytestmark = [
    pytest.mark.slow,  # Slurm looks at time limits every half minute
    pytest.mark.skipif(
        bool(LACK) and os.environ.get("MOTES_TEST_SLURM") != "required", reason=LACK or "nothing lacks"
    ),
]

FILM = """
import os
import re
import sys
import time
import motes
from motes import shapes

out = sys.argv[1]
camera = motes.Camera((0, 2, 9), (0, 0.5, 0))
world = motes.World(
    seed=3, renderer=motes.Renderer(160, 90, camera=camera), space=(-3, 3), digest=True,
    log=f"{out}/log", checkpoint=motes.Checkpoint(f"{out}/checkpoints", every=1000),
)
sparks = world.system("sparks")
sparks.configure(velocity=shapes.Sphere((0.5, 6, 0), 1.5), lifetime=2)
pause = 0.4 if int(os.environ.get("SLURM_RESTART_COUNT", 0)) < 3 and "SLURM_JOB_ID" in os.environ else 0
with world, motes.Movie(f"{out}/film.mp4") as movie:
    for frame in world.frames(480):
        sparks.source(shapes.Disc((0, 0.1, 0), (0, 1, 0), 0.5), rate=2400, jitter=True)
        sparks.gravity((0, -9.8, 0))
        sparks.bounce(shapes.Plane((0, 0, 0), (0, 1, 0)), restitution=0.6)
        sparks.kill_expired()
        sparks.move()
        movie.write(world.render())
        time.sleep(pause)
"""

SWEPT = """
import motes
from motes import shapes

world = motes.World(seed=2, renderer=motes.Renderer(80, 60, camera=motes.Camera((0, 1, 9), (0, 1, 0))))
dust = world.system("dust")
gravity = world.control("gravity", 1.0, low=0, high=9)
with world:
    for frame in world.frames(4):
        dust.burst(shapes.Box((-1, 1, -1), (1, 2, 1)), count=50)
        dust.gravity((0, -gravity.value, 0))
        dust.move()
        world.render()
"""


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with slurm(tmp_path_factory.mktemp("slurm")) as up:
        yield up


@pytest.fixture
def with_pmix(cluster: Cluster) -> Cluster:
    if not cluster.pmix:
        pytest.skip("this Slurm has no PMIx: apt-get install libpmix-dev")
    return cluster


@pytest.mark.parametrize("ranks", [1, 2, 4])
def test_srun_alone_starts_it(with_pmix: Cluster, ranks: int, tmp_path: Path) -> None:
    """Without mpirun, the same digests."""
    nodes = f"--nodes={min(ranks, 3)}"
    srun = ("srun", "--mpi=pmix", nodes, "-n", ranks, sys.executable)
    wanted = mpirun(ranks, SNOW, *SMALL, "--out", tmp_path / "mpirun").lines
    made = with_pmix.run(*srun, SNOW, *SMALL, "--out", tmp_path / "srun")
    assert made.lines == wanted and len(wanted) == 6, made.text
    pictures = [(tmp_path / where / "snow.png").read_bytes() for where in ("mpirun", "srun")]
    assert pictures[0] == pictures[1]
    everything = with_pmix.run(*srun, EVERYTHING, VARIANTS)
    assert sorted(everything.lines) == sorted(python(EVERYTHING, VARIANTS).lines)


def test_a_rank_that_fails_ends_the_step(with_pmix: Cluster, tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "import motes\n"
        "world = motes.World(seed=1, progress='off')\n"
        "with world:\n"
        "    for frame in world.frames(1000):\n"
        "        if world.rank == 2 and frame == 3: raise ValueError('three is too much')\n"
        "        world.step()\n"
    )
    ended = with_pmix.run("srun", "--mpi=pmix", "--nodes=3", "-n", 4, sys.executable, script)
    assert ended.code != 0 and ended.err.count("*** motes: rank 2 (") == 1, ended.text


def test_srun_without_pmix_is_named(cluster: Cluster, tmp_path: Path) -> None:
    """Ranks that do not see each other would all write the same film."""
    script = tmp_path / "script.py"
    script.write_text("import motes\nwith motes.World(seed=1, progress='off') as world: world.step()\n")
    ended = cluster.run("srun", "--mpi=none", "--nodes=2", "-n", 2, sys.executable, script)
    assert ended.code != 0 and "srun seems to have started 2 processes" in ended.err, ended.text


@pytest.mark.parametrize("ranks", [3, 6])
def test_motes_run_inside_an_allocation(cluster: Cluster, ranks: int) -> None:
    """mpirun starts its daemons by srun: no hosts are named, and no ssh is used."""
    run = (sys.executable, "-m", "motes", "run", "-n", ranks, EVERYTHING, VARIANTS)
    made = cluster.run("salloc", "--quiet", "--nodes=3", f"--ntasks={ranks}", *run)
    assert sorted(made.lines) == sorted(python(EVERYTHING, VARIANTS).lines)


def recipe(how: str, film: str) -> str:
    """Return a batch script of docs/clusters.md, with a film and a short limit."""
    blocks = re.findall("```bash\n(.*?)```", PAGE.read_text(), re.DOTALL)
    (text,) = (block for block in blocks if f"\n{how} " in block)
    changes = {
        "--ntasks=18": "--ntasks=4",
        "--time=02:00:00": "--time=1",
        "USR1@120": "USR1@10",
        "source .venv/bin/activate\n": "",
        "python ": f"{sys.executable} ",
        "snow.py": film,
    }
    for old, new in changes.items():
        assert text.count(old) == 1, f"{old!r} in the recipe\n{text}"
        text = text.replace(old, new)
    return text


@pytest.mark.parametrize("how", ["srun", "python -m motes run"])
def test_a_film_that_its_time_limit_interrupts_is_whole(with_pmix: Cluster, how: str, tmp_path: Path) -> None:
    """A signal before the limit, a checkpoint, a requeue, three times; then the same frames as without."""
    film, out = tmp_path / "film.py", tmp_path / "out"
    film.write_text(FILM)
    batch = tmp_path / "film.sbatch"
    batch.write_text(recipe(how, f"{film} {out}"))
    (job,) = with_pmix.wait(with_pmix.submit(batch, f"--output={tmp_path}/%j.txt"), timeout=540)
    assert (job.state, job.restarts) == ("COMPLETED", 3), job.output
    assert job.output.count("motes: stopped by SIGUSR1 after frame ") == 3, job.output
    assert job.output.count("motes: continues with frame ") == 3, job.output
    whole = tmp_path / "whole"
    assert python(film, whole, timeout=120).code == 0
    assert digests(out) == digests(whole)
    assert frames_of(out / "film.mp4") == frames_of(whole / "film.mp4") == 480


def digests(out: Path) -> list[tuple[int, str, str]]:
    """Return number and digests of each frame in a log."""
    rows = [json.loads(line) for line in (out / "log" / "frames.jsonl").read_text().splitlines()]
    return [(row["frame"], row["particles_digest"], row["image_sha256"]) for row in rows]


def frames_of(film: Path) -> int:
    """Return the number of frames that can be decoded."""
    av = pytest.importorskip("av")
    with av.open(str(film)) as opened:
        return sum(1 for _ in opened.decode(video=0))


def test_a_sweep_as_a_job_array(cluster: Cluster, tmp_path: Path) -> None:
    """Each task runs one case; the table is that of a sweep without Slurm."""
    script = tmp_path / "dust.py"
    script.write_text(SWEPT)
    sweep = (sys.executable, "-m", "motes", "sweep", script, "--set", "gravity=1,3", "--ranks", "1,2")
    told = cluster.run(*sweep, "-o", tmp_path / "array", "--slurm")
    sbatch, path = told.lines[-1].split(" ", 1)
    assert sbatch == "sbatch"
    tasks = cluster.wait(cluster.submit(Path(path), "--time=5"), timeout=240)
    assert [task.state for task in tasks] == ["COMPLETED"] * 4, "\n".join(task.output for task in tasks)
    # Only the table is still missing, and what the sweep says is that nothing else is.
    finished = cluster.run(*sweep, "-o", tmp_path / "array")
    assert finished.code == 0 and "4 of 4 runs are complete" in finished.err, finished.text
    assert cluster.run(*sweep, "-o", tmp_path / "local").code == 0
    assert table(tmp_path / "array") == table(tmp_path / "local")


def table(out: Path) -> list[tuple[str, ...]]:
    """Return the values and digests of a sweep's rows."""
    with (out / "sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    return [
        tuple(row[name] for name in ("gravity", "ranks", "particles", "picture", "error")) for row in rows
    ]
