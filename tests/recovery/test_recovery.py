"""Ranks that are killed: with `on_loss="recover"` the others finish the run with the same result."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import pytest

pytest.importorskip("av")

from films import packets  # noqa: E402
from launching import Result, command, said  # noqa: E402
from standing import on_ranks  # noqa: E402

import motes  # noqa: E402
from motes import _core  # noqa: E402, F401  (MPI must start before the query below, which does not start it)
from motes._launch import starting  # noqa: E402

SCENE = Path(__file__).parents[1] / "scenes" / "recovering.py"
FRAMES = 30

survives = pytest.mark.skipif(starting.cannot_survive() is not None, reason=str(starting.cannot_survive()))


def run(
    out: Path, n: int, *arguments: object, frames: int = FRAMES, flags: tuple[str, ...] = ("--survive",)
) -> Result:
    """Run the scene on ranks of which some die."""
    return command(
        [sys.executable, "-m", "motes", "run", *flags, "-n", n, SCENE, out, frames, *arguments], timeout=90
    )


def digests(out: Path) -> list[tuple[int, str, str]]:
    rows = map(json.loads, (out / "log" / "frames.jsonl").read_text().splitlines())
    return [(row["frame"], row["particles_digest"], row["image_sha256"]) for row in rows]


def check_same(out: Path, model: Path) -> None:
    assert packets(out / "film.mp4") == packets(model / "film.mp4")
    assert digests(out) == digests(model)
    pictures = sorted(path.name for path in model.glob("*.png"))
    assert pictures == sorted(path.name for path in out.glob("*.png"))
    assert all((out / name).read_bytes() == (model / name).read_bytes() for name in pictures)
    assert not (out / "film.partial.mp4").exists()


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run the scene undisturbed, without replicas."""
    out = tmp_path_factory.mktemp("model")
    result = run(out, 1)
    assert result.code == 0, result.text
    return out


@survives
@pytest.mark.parametrize(
    ("n", "death", "role"),
    [
        (5, "0@26", "image generator"),
        (5, "1@20.7", "manager"),
        (5, "3@7.3", "calculator 1"),
        (2, "1@17", "calculator 0"),
        pytest.param(2, "0@29", "image generator, manager", marks=pytest.mark.slow),
        pytest.param(3, "2@13", "calculator 0", marks=pytest.mark.slow),
        pytest.param(5, "0@0", "image generator", marks=pytest.mark.slow),
        pytest.param(5, "4@28.2", "calculator 2", marks=pytest.mark.slow),
    ],
)
def test_the_others_go_on_without_a_lost_rank(tmp_path, model, n, death, role):
    result = run(tmp_path, n, death)
    assert result.code == 0, result.text
    assert result.lines[0].endswith(f" on {n - 1}"), result.text
    check_same(tmp_path, model)
    (told,) = said(result.err, "motes: lost ")
    left = "1 rank continues" if n == 2 else f"{n - 1} ranks continue"
    assert re.fullmatch(rf"rank {death[0]} \({role}\); {left} from replicas of frame \d+", told), told
    events = [json.loads(row) for row in (tmp_path / "log" / "events.jsonl").read_text().splitlines()]
    assert [event["kind"] for event in events] == ["start", "recovered", "end"]
    motes.open_run(tmp_path / "log").summary()


@survives
@pytest.mark.parametrize(
    ("deaths", "times"),
    [(["4@10", "0@22"], {2}), pytest.param(["2@16", "0@16"], {1, 2}, marks=pytest.mark.slow)],
)
def test_several_ranks_may_be_lost(tmp_path, model, deaths, times):
    """The loss of two ranks in one frame may be noticed at once."""
    result = run(tmp_path, 5, *deaths)
    assert result.code == 0, result.text
    assert result.lines[0].endswith(" on 3"), result.text
    check_same(tmp_path, model)
    events = [json.loads(row) for row in (tmp_path / "log" / "events.jsonl").read_text().splitlines()]
    begin, *recovered, end = [event["kind"] for event in events]
    assert (begin, end) == ("start", "end") and set(recovered) == {"recovered"} and len(recovered) in times
    lost = said(result.err, "motes: lost ")
    assert (len(lost), len(re.findall(r"rank \d", "".join(lost)))) == (len(recovered), 2), result.text


@survives
@pytest.mark.parametrize("ranks", [2, 5])
def test_a_film_is_closed_by_others_where_its_writer_is_lost_while_closing_it(tmp_path, model, ranks):
    result = run(tmp_path, ranks, "--closing")
    assert result.code == 0, result.text
    assert said(result.err, "motes: lost rank 0 (image generator")
    check_same(tmp_path, model)


@survives
@pytest.mark.parametrize(
    ("option", "why"),
    [
        ("--callback", "cannot run again without the script"),
        ("--write", "cannot run again without the script|wrote to particles in frame"),
        ("--export", "lack the lost ranks' particles"),
    ],
)
def test_what_cannot_be_done_again_ends_the_run_with_a_sentence(tmp_path, option, why):
    result = run(tmp_path, 5, "3@17", option)
    assert result.code == 1, result.text
    (report,) = said(result.err, "*** motes: ")
    assert re.search(f"rank 3 was lost, and .*({why})", report), result.text


@survives
def test_a_checkpoint_goes_on_behind_a_loss(tmp_path, model):
    """The remaining ranks write the checkpoint, and another job continues from it."""
    first = run(tmp_path, 4, "2@11", "--checkpoint", frames=24)
    assert first.code == 0, first.text
    second = run(tmp_path, 3, "--checkpoint", flags=("--survive", "--anyway"))
    assert second.code == 0, second.text
    assert "continues with frame 24" in second.err, second.text
    assert digests(tmp_path) == digests(model)


def test_a_job_that_ends_with_a_lost_rank_is_refused(tmp_path):
    result = run(tmp_path, 2, flags=())
    assert result.code == 1, result.text
    assert "python -m motes run --survive" in result.err
    assert not (tmp_path / "log").exists()


def test_on_one_rank_there_is_nothing_to_recover(tmp_path):
    world = motes.World(on_loss="recover", progress="off")
    sparks = world.system("sparks")
    with world:
        sparks.burst(motes.shapes.Point((0, 0, 0)), count=3)
        world.step()
    with pytest.raises(motes.errors.ArgumentError, match="on_loss"):
        motes.World(on_loss="wait")


@survives
def test_a_loss_that_replicas_do_not_cover_falls_back_on_the_checkpoint(tmp_path):
    """Neighbours die together; `--restarts` continues from the checkpoint on disk."""
    model, out = tmp_path / "model", tmp_path / "out"
    assert run(model, 1, "--checkpoint").code == 0
    flags = ("--survive", "--restarts", "1")
    result = run(out, 5, "2@20", "3@20", "--checkpoint", "--once", flags=flags)
    assert result.code == 0, result.text
    assert said(result.err, "motes run: restarts; 0 more restarts are allowed")
    went_on = (
        said(result.err, "motes: continues with frame 8"),
        said(result.err, "motes: continues with frame 16"),
    )
    assert any(went_on), result.text  # the checkpoint of frame 16 waits until that of frame 8 is complete
    check_same(out, model)


@survives
def test_a_crash_while_others_are_lost_counts_as_a_loss(tmp_path):
    model, out = tmp_path / "model", tmp_path / "out"
    assert run(model, 1, "--checkpoint").code == 0
    flags = ("--survive", "--restarts", "1")
    result = run(out, 5, "2@20", "--checkpoint", "--once", "--crashing", flags=flags)
    assert result.code == 0, result.text
    told = r"\*\*\* motes: rank .*, while recovering from lost ranks: segmentation fault"
    assert re.search(told, result.err), result.text
    assert said(result.err, "motes run: restarts; 0 more restarts are allowed")
    check_same(out, model)


MEETING = """
import os, signal, sys
import numpy as np
import motes
from mpi4py import MPI
from motes import expressions as ex
from motes.shapes import Box, Plane

deaths = [tuple(map(int, pair.split("@"))) for pair in sys.argv[1:]]
me = MPI.COMM_WORLD.rank
world = motes.World(
    seed=3, dt=0.02, substeps=6, roles="shared", axis="xz", periodic={"x": (-1, 1), "z": (-1, 1)},
    balancer=motes.balance.PrefixCuts(threshold=0.01, min_particles=1), on_loss="recover", progress="off",
)
clumps, grains, net = (world.system(name) for name in ("clumps", "grains", "net"))
clumps.clumps([(0, 0, 0, 0.06), (0.08, 0, 0, 0.05)], density=1000)
slope = Plane((0, 0, 0), (0.2, 1, 0.1))
ids = np.arange(20)
ring = motes.Ties(np.stack([ids, np.roll(ids, -1)], -1), 0.08)
turned = ex.a.state.turned
with world:
    for frame in world.frames(10):
        if (me, frame) in deaths:
            os.kill(os.getpid(), signal.SIGKILL)
        clumps.configure(velocity=(2, -1, 1))
        grains.configure(velocity=motes.shapes.Sphere((-3, -1, 2), 1))
        if frame == 0:
            places = np.stack([0.1 * ids - 1, 0.5 + 0.05 * (ids % 2), 0.95 + 0 * ids], -1)
            net.emit(position=places, velocity=np.full((20, 3), (3, 0, 2)))
        for system in (clumps, grains):
            system.source(Box((-1, 0.3, -1), (1, 1, 1)), rate=1000 if frame < 4 else 0)
            system.gravity((0, -9.81, 0))
        clumps.contact(2000, friction=0.6, rolling_friction=0.05, walls=[slope])
        grains.contact(500, radius=0.06, walls=[slope])
        clumps.contact(800, friction=0.3, other=grains, other_radius=0.06)
        law = 30 * ex.normal * (0.1 - ex.r) + (ex.normal - turned)
        grains.interact(0.2, acceleration=law, state={"turned": 3}, set={"turned": ex.normal})
        net.tie(ring, damping=1)
        for system in world.systems:
            system.move()
        world.step()
    counts = [system.count for system in world.systems]
    touching = clumps.total(ex.column("contacts")) > 0 and grains.total(ex.column("contacts")) > 0
    digest = world.digest()
    pressed = world.force(slope).force.tolist()
    print(digest, pressed, counts, touching) if "manager" in world.role else None
"""


@survives
@pytest.mark.parametrize("deaths", [["1@6"], pytest.param(["0@3", "2@8"], marks=pytest.mark.slow)])
def test_particles_that_meet_go_on_as_if_nobody_were_lost(tmp_path, deaths):
    """The scene has periodic space, walls, clumps, ties, and laws that keep a state."""
    script = tmp_path / "script.py"
    script.write_text(MEETING)
    wanted = on_ranks(1, MEETING).lines
    assert wanted[0].endswith("[80, 80, 20] True"), wanted
    lost = command([sys.executable, "-m", "motes", "run", "--survive", "-n", 4, script, *deaths], timeout=90)
    assert lost.lines == wanted
    assert len(said(lost.err, "motes: lost rank ")) == len(deaths), lost.text


LATER_WORLDS = """
import os, signal
import motes
from motes._world.world import session_of
from mpi4py import MPI

roles = motes.Roles(manager=1, image_generator=0, calculators=[3, 2], speeds={2: 0.5})
common = {"space": (-1, 1), "progress": "off", "roles": roles}
worlds = [
    motes.World(seed=0, comm=MPI.COMM_WORLD.Dup(), on_loss="recover", **common),
    motes.World(seed=1, on_loss="recover", **common),
    motes.World(seed=2, **common),
    motes.World(seed=3, on_loss="recover", **common),
]
for k, world in enumerate(worlds):
    dust = world.system("dust")
    with world:
        for frame in world.frames(4):
            if frame == 2 and (k, world.rank, world.size) in [(0, 3, 4), (1, 1, 3)]:
                os.kill(os.getpid(), signal.SIGKILL)
            dust.burst((0, 0, 0), count=10)
            dust.move()
            world.step()
    facts = sorted(world.role), world.calculators, session_of(world).settings.speeds
    print(k, world.rank, world.size, *facts, flush=True)
    world.say(f"said in {k} at {world.frame}")
    assert dust.count == 40
    if (k, world.rank) == (2, 1):
        os.kill(os.getpid(), signal.SIGKILL)
"""


@survives
def test_later_worlds_are_made_of_those_that_are_left(tmp_path):
    """The script's roles name the original ranks; a rank is lost between two worlds, too."""
    script = tmp_path / "script.py"
    script.write_text(LATER_WORLDS)
    result = command([sys.executable, "-m", "motes", "run", "--survive", "-n", 4, script], timeout=90)
    assert sorted(result.lines) == [
        "0 0 3 ['image_generator'] (2,) {2: 0.5}",
        "0 1 3 ['manager'] (2,) {2: 0.5}",
        "0 2 3 ['calculator'] (2,) {2: 0.5}",
        "1 0 2 ['image_generator', 'manager'] (1,) {1: 0.5}",
        "1 1 2 ['calculator'] (1,) {1: 0.5}",
        "2 0 2 ['image_generator', 'manager'] (1,) {1: 0.5}",
        "2 1 2 ['calculator'] (1,) {1: 0.5}",
        "3 0 1 ['calculator', 'image_generator', 'manager'] (0,) {}",
        *(f"said in {k} at 4" for k in range(4)),
    ], result.text
    assert said(result.err, "motes: lost ")[-1] == "rank 1 between two worlds; 1 rank continues"
