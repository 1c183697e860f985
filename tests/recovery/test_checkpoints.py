"""A killed run continues from its newest complete checkpoint, and makes the same as an undisturbed run."""

from __future__ import annotations

import json
import random
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from films import packets
from launching import command, mpirun, said
from standing import on_ranks

import motes
from motes import _core
from motes._checkpoint import folder
from motes._checkpoint.manifest import VERSION, Manifest, PartEntry
from motes._launch.hosts import reachable
from motes._run.same_script import difference
from motes.errors import ArgumentError, CheckpointError, MotesError

SCRIPT = Path(__file__).parents[1] / "scenes" / "checkpointed.py"
EVERY = 4
FRAMES = 20


def run(ranks, place, *, fails=False, env=None, **options):
    start = mpirun if "kill_at" in options else on_ranks
    result = start(ranks, SCRIPT, place, env={"OPTIONS": json.dumps(options), **(env or {})})
    assert (result.code != 0) == fails, result.text
    return result


def made(place):
    """Return a run's results: rows of the log, packets of the film."""
    text = (place / "log" / "frames.jsonl").read_text()
    rows = [
        (row["frame"], row["particles"], row["particles_digest"], row["image_sha256"])
        for row in map(json.loads, text.splitlines())
    ]
    return rows, packets(place / "film.mp4")


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    place = tmp_path_factory.mktemp("undisturbed")
    run(1, place)
    rows, film = made(place)
    assert [row[0] for row in rows] == list(range(FRAMES)) and len(film[0]) == FRAMES
    return rows, film


@pytest.fixture(scope="module")
def killed(tmp_path_factory):
    """Return the files of a run on three ranks that was killed in frame 16: checkpoints of frames 8 and 12.

    The checkpoint of frame 16 has begun by then; it waited until the one before was complete.
    """
    place = tmp_path_factory.mktemp("killed") / "run"
    place.mkdir()
    run(3, place, fails=True, kill_at=16, roles="shared")
    assert [frame for frame, _ in folder.whole(place / "checkpoints")] == [12, 8]
    shutil.copytree(place, place.with_name("saved"))
    return place


MANAGED = """
import os, sys
import numpy as np, motes

class Counts(motes.balance.Balancer):
    def decide(self, load):
        print("evaluation", load.evaluation, "of frame", load.frame, flush=True)
        return motes.balance.Orders([])

world = motes.World(seed=1, space=(-1, 1), progress="off", roles="shared", balancer=Counts(),
                    checkpoint=motes.Checkpoint(sys.argv[1], every=3))
dust = world.system("dust")
with world:
    for frame in world.frames(8):
        if frame == 0:
            dust.emit(position=np.random.default_rng(1).uniform(0.5, 0.51, (1500, 3)))
        if frame == 7 and "KILLED" in os.environ:
            world.digest()
            os._exit(9)
        dust.gravitate(1e-6, max_radius=1)
        dust.move()
        world.step()
"""


def test_the_manager_goes_on_where_it_was(tmp_path):
    """No warning is repeated, and balancers get the evaluation's number counted from the first frame."""
    script = tmp_path / "managed.py"
    script.write_text(MANAGED)
    first = mpirun(3, script, tmp_path / "checkpoints", env={"KILLED": "yes"})
    assert first.code != 0 and first.err.count("1500 particles are in one cell") == 1
    newest = folder.whole(tmp_path / "checkpoints")[0][0]
    assert newest in (3, 6)
    then = on_ranks(3, script, tmp_path / "checkpoints")
    assert then.code == 0, then.text
    assert "particles are in one cell" not in then.err
    assert [f"evaluation {i} of frame {i}" in then.out for i in range(8)] == [i >= newest for i in range(8)]


@pytest.fixture
def copied(killed):
    """Restore the killed run's folder under the same path, so arguments and films keep their names."""
    shutil.rmtree(killed)
    return Path(shutil.copytree(killed.with_name("saved"), killed))


HILBERT = {"axis": "hilbert", "space": (-4, 4)}
CASES = [
    (1, dict(kill_at=13), 3, {}),
    pytest.param(2, dict(kill_at=11, rank=0), 1, {}, marks=pytest.mark.slow),
    (3, dict(kill_at=9, rank=1, roles="shared", **HILBERT), 2, dict(axis="yz", births="calculators")),
    (
        5,
        dict(kill_at=14, rank=2, balancer="pairwise"),
        3,
        dict(roles="shared", balancer="pairwise", **HILBERT),
    ),
    pytest.param(
        *(3, dict(kill_at=18, roles="shared", axis=None), 3, dict(roles="shared", axis=None)),
        marks=pytest.mark.slow,
    ),
]


@pytest.mark.parametrize(("ranks", "first", "then_ranks", "then"), CASES)
def test_a_killed_run_goes_on(tmp_path, undisturbed, ranks, first, then_ranks, then):
    run(ranks, tmp_path, fails=True, **first)
    newest = folder.whole(tmp_path / "checkpoints")[0][0]
    result = run(then_ranks, tmp_path, **then)
    assert said(result.err, f"motes: continues with frame {newest}, from")
    assert made(tmp_path) == undisturbed
    assert not (tmp_path / "film.partial.mp4").exists()


def test_a_run_that_was_killed_before_its_first_checkpoint_starts_anew(tmp_path, undisturbed):
    run(2, tmp_path, fails=True, kill_at=2)
    assert folder.whole(tmp_path / "checkpoints") == []
    run(2, tmp_path)
    assert made(tmp_path) == undisturbed


def test_a_run_that_is_done_is_done(tmp_path, undisturbed):
    run(2, tmp_path)
    again = run(3, tmp_path)
    assert said(again.err, f"motes: continues with frame {FRAMES}")
    assert made(tmp_path) == undisturbed


def test_a_film_can_be_prolonged(tmp_path, undisturbed):
    run(1, tmp_path, frames=10)
    run(2, tmp_path)
    rows, film = made(tmp_path)
    assert rows == undisturbed[0] and len(film[0]) == FRAMES


def test_two_checkpoints_are_kept_and_nothing_else(tmp_path):
    run(2, tmp_path, fails=True, kill_at=17)
    (tmp_path / "checkpoints" / "frame-000099.tmp").mkdir()
    run(2, tmp_path)
    names = {path.name for path in (tmp_path / "checkpoints").iterdir()}
    assert names == {".lock", "frame-000016", "frame-000020"}


# --- damage


def flip(path, random):
    content = bytearray(path.read_bytes())
    at = random.randrange(len(content))
    content[at] ^= 1 << random.randrange(8)
    path.write_bytes(content)


def newest_of(place):
    return folder.whole(place / "checkpoints")[0][1]


DAMAGES = {
    "a truncated part": lambda at: (at / "part-00001.safetensors").write_bytes(
        (at / "part-00001.safetensors").read_bytes()[:-7]
    ),
    "a missing part": lambda at: (at / "part-00002.safetensors").unlink(),
    "a part of another checkpoint": lambda at: shutil.copy(
        at.with_name("frame-000008") / "part-00000.safetensors", at / "part-00000.safetensors"
    ),
    "an empty part": lambda at: (at / "part-00000.safetensors").write_bytes(b""),
    "a changed value": lambda at: _change_last_byte(at / "part-00000.safetensors"),
    "a changed count": lambda at: _change_last_byte(at / "world.bin"),
    "no manifest": lambda at: (at / "manifest.json").unlink(),
    "a torn manifest": lambda at: (at / "manifest.json").write_bytes(
        (at / "manifest.json").read_bytes()[:300]
    ),
}


def _change_last_byte(path):
    content = bytearray(path.read_bytes())
    content[-1] ^= 16
    path.write_bytes(content)


SLOW = ("an empty part", "a part of another checkpoint", "a torn manifest", "a changed count")


@pytest.mark.parametrize(
    "damage",
    [pytest.param(name, marks=pytest.mark.slow if name in SLOW else ()) for name in DAMAGES],
)
def test_the_checkpoint_before_a_damaged_one_is_used(copied, undisturbed, damage):
    DAMAGES[damage](newest_of(copied))
    result = run(2, copied)
    assert said(result.err, "motes: the checkpoint of frame 12 is skipped: ")
    assert said(result.err, "motes: continues with frame 8")
    assert made(copied) == undisturbed


def test_a_run_without_a_whole_checkpoint_ends_clearly(copied):
    for _, place in folder.whole(copied / "checkpoints"):
        (place / "world.bin").unlink()
    result = run(3, copied, fails=True)
    assert "CheckpointError: none of the 2 checkpoint(s)" in result.text
    run(1, copied, env={"MOTES_FRESH": "1"})


def test_a_disk_that_is_full_costs_a_checkpoint_and_not_the_run(tmp_path, undisturbed):
    result = run(2, tmp_path, full_at=8)
    assert said(result.err, "motes: rank 1")
    assert "the checkpoint of frame 8 could not be written" in result.text
    assert "the newest complete one is of frame 4" in result.text
    assert made(tmp_path)[0] == undisturbed[0]


# --- another run


def test_another_script_is_refused_unless_told_otherwise(copied, tmp_path):
    other = tmp_path / "other.py"
    other.write_text(SCRIPT.read_text().replace("rate=700", "rate=710"))
    told = {"OPTIONS": json.dumps({"roles": "shared"})}
    result = on_ranks(2, other, copied, env=told)
    assert result.code == 1
    assert "rate=700" in result.text and "rate=710" in result.text and "--anyway" in result.text
    assert on_ranks(2, other, copied, env={**told, "MOTES_ANYWAY": "1"}).code == 0


def test_another_seed_is_refused(copied):
    result = run(2, copied, fails=True, seed=6, env={"MOTES_ANYWAY": "1"})
    assert "World(seed=...) was 5 and is 6" in result.text


def test_a_fresh_run_forgets_the_earlier_one(copied, undisturbed):
    result = run(2, copied, env={"MOTES_FRESH": "1"})
    assert not said(result.err, "motes: continues")
    assert made(copied) == undisturbed


def test_differences_of_scripts_are_named():
    then = {"path": "a.py", "sha256": "1", "text": "a\nb\n", "arguments": []}
    assert difference(then, {**then, "path": "b.py"}) == ""
    assert difference(then, {**then, "arguments": ["x"]}) == "the script's arguments were none and are 'x'"
    assert (
        difference(then, {**then, "sha256": "2", "text": "a\nc\n"})
        == "the script's line 2 was 'b' and is 'c'"
    )
    assert "was missing and is 'd'" in difference(then, {**then, "sha256": "2", "text": "a\nb\nd\n"})


# --- the script's own loops, reads


OWN_LOOP = """
import os, sys, motes
from motes import shapes
world = motes.World(seed=1, progress="off", checkpoint=motes.Checkpoint(sys.argv[1], every=2))
s = world.system("s")
with world:
    for warm in range(3):
        s.source(shapes.Sphere((0, 0, 0), 1), rate=2400)
        s.gravity((0, -1, 0))
        s.move()
        world.step()
    for frame in world.frames(8):
        if frame == int(os.environ.get("KILL", -1)):
            os._exit(9)
        s.source(shapes.Sphere((0, 0, 0), 1), rate=2400)
        s.gravity((0, -1, 0))
        s.move()
        world.step()
    print("digest", world.digest(), s.born, world.frame)
"""


def test_frames_before_the_loop_are_not_done_twice(tmp_path):
    script = tmp_path / "own.py"
    script.write_text(OWN_LOOP)
    whole = on_ranks(1, script, tmp_path / "a")
    killed = mpirun(1, script, tmp_path / "b", env={"KILL": "6"})
    assert whole.code == 0 and killed.code == 9
    again = on_ranks(2, script, tmp_path / "b")
    assert said(again.err, "motes: continues with frame 4")
    assert set(said(again.out, "digest")) == set(said(whole.out, "digest"))


# --- the files


def test_parts_are_read_by_others(copied):
    """A safetensors file holds the header's length in eight bytes, a JSON header, then the values."""
    place = newest_of(copied)
    rows = 0
    for path in sorted(place.glob("part-*.safetensors")):
        content = path.read_bytes()
        length = int.from_bytes(content[:8], "little")
        header = json.loads(content[8 : 8 + length])
        data = content[8 + length :]
        spans = sorted(entry["data_offsets"] for name, entry in header.items() if name != "__metadata__")
        assert spans[0][0] == 0 and spans[-1][1] == len(data)
        assert all(before[1] == after[0] for before, after in zip(spans, spans[1:], strict=False))
        entry = header["snow/position.y"]
        y = np.frombuffer(data[slice(*entry["data_offsets"])], np.float32)
        assert entry["dtype"] == "F32" and list(y.shape) == entry["shape"] and np.isfinite(y).all()
        rows += len(y)
    manifest = Manifest.from_bytes((place / folder.MANIFEST).read_bytes(), place)
    assert manifest.particles[manifest.systems.index("snow")] == rows


def test_every_flipped_bit_of_a_part_is_found_or_harmless(copied, tmp_path):
    source = newest_of(copied) / "part-00000.safetensors"
    whole = _core.PartFile(str(source), True)
    length = 8 + int.from_bytes(source.read_bytes()[:8], "little")
    numbers = random.Random(3)
    for _ in range(200):
        content = bytearray(source.read_bytes())
        at = numbers.choice(
            [numbers.randrange(len(content)), numbers.randrange(8), length + numbers.randrange(24)]
        )
        content[at] ^= 1 << numbers.randrange(8)
        damaged = tmp_path / "damaged"
        damaged.write_bytes(content)
        try:
            part = _core.PartFile(str(damaged), True)
        except RuntimeError as error:
            assert "damaged checkpoint" in str(error)
        else:  # in the metadata for other readers
            assert 8 <= at < length or at in range(length + 20, length + 24)
            assert part.rows == whole.rows


def manifest_of(frame=8):
    script = {"path": "x.py", "sha256": "0", "text": "", "arguments": []}
    parts = [PartEntry("part-00000.safetensors", 100, [3])]
    world = {"file": "world.bin", "bytes": 3, "crc32c": 7}
    return Manifest(frame, frame / 24, 5, 1 / 24, 1, "1", script, ["snow"], parts, world, {"/film.mp4": 8})


def test_a_manifest_says_when_it_has_changed(tmp_path):
    text = manifest_of().with_script_state({"configured": {}}).to_bytes()
    assert Manifest.from_bytes(text, tmp_path) == manifest_of().with_script_state({"configured": {}})
    assert Manifest.from_bytes(text, tmp_path).unpacked(tmp_path) == {"configured": {}}
    numbers = random.Random(1)
    for _ in range(300):
        content = bytearray(text)
        content[numbers.randrange(len(text) - 1)] ^= 1 << numbers.randrange(7)
        try:
            read = Manifest.from_bytes(bytes(content), tmp_path)
        except CheckpointError:
            continue
        assert read == manifest_of().with_script_state({"configured": {}})  # only white space changed
    for other in (1, VERSION - 1):
        changed = text.replace(b'"version": %d' % VERSION, b'"version": %d' % other)
        with pytest.raises(CheckpointError, match=f"version {other}"):
            Manifest.from_bytes(changed, tmp_path)


def test_a_directory_belongs_to_one_run(tmp_path):
    first = folder.Lock(tmp_path)
    with pytest.raises(ArgumentError, match="no other run uses"):
        folder.Lock(tmp_path)
    first.release()
    folder.Lock(tmp_path).release()


@pytest.mark.parametrize("wrong", [0, "", -1, dict(directory="x", every=0), dict(directory="x", keep=0)])
def test_wrong_checkpoints_are_refused(wrong):
    with pytest.raises(ArgumentError):
        if isinstance(wrong, dict):
            motes.Checkpoint(**wrong)
        else:
            motes.World(checkpoint=wrong)


# --- any moment


@pytest.mark.slow
def test_kills_at_random_moments(tmp_path, undisturbed):
    numbers = random.Random(7)
    for turn in range(100):
        place = tmp_path / str(turn)
        place.mkdir()
        ranks = numbers.choice([1, 2, 3, 5])
        victim = dict(kill_at=numbers.randrange(FRAMES), rank=numbers.randrange(ranks))
        run(ranks, place, fails=True, roles=numbers.choice(["auto", "shared"]), **victim)
        run(numbers.choice([1, 2, 3, 5]), place, roles=numbers.choice(["auto", "shared"]))
        assert made(place) == undisturbed, (turn, ranks, victim)
        shutil.rmtree(place)


# --- starting again


@pytest.mark.parametrize("ranks", [1, 3])
def test_a_job_starts_again_by_itself(tmp_path, undisturbed, ranks):
    options = json.dumps({"kill_at": 9, "roles": "shared"})
    # The restarted job can finish the frame only if it is not killed there again: kill it once.
    script = tmp_path / "once.py"
    once = "if os.path.exists(sys.argv[1] + '/killed'): os.environ['OPTIONS'] = '{}'\n"
    mark = "open(folder + '/killed', 'w').close(); os.kill(os.getpid(), 9)"
    text = SCRIPT.read_text().replace("import motes\n", f"{once}import motes\n", 1)
    script.write_text(text.replace("os.kill(os.getpid(), 9)", mark))
    argv = [sys.executable, "-m", "motes", "run", "-n", ranks, "--restarts", 2, script, tmp_path]
    result = command(argv, env={"OPTIONS": options})
    assert result.code == 0, result.text
    assert said(result.err, "motes run: restarts; 1 more restart is allowed")
    assert said(result.err, "motes: continues with frame ")
    assert made(tmp_path) == undisturbed


def test_a_mistake_in_the_script_is_not_repeated(tmp_path):
    script = tmp_path / "wrong.py"
    script.write_text("import motes\nwith motes.World(seed=1):\n    raise ValueError('wrong')\n")
    result = command([sys.executable, "-m", "motes", "run", "-n", 2, "--restarts", 3, script])
    assert result.code == 1 and "ValueError: wrong" in result.text
    assert not said(result.err, "motes run: restarts")


def test_a_job_goes_on_without_hosts_that_do_not_answer(tmp_path, monkeypatch, capfd):
    agent = tmp_path / "agent"
    agent.write_text('#!/bin/sh\n[ "$1" != gone ] && [ "$2" = true ]\n')
    agent.chmod(0o755)
    monkeypatch.setenv("PRTE_MCA_plm_ssh_agent", str(agent))
    assert reachable("here:2,gone:3,there") == "here:2,there"
    assert "continues without gone:3" in capfd.readouterr().err
    with pytest.raises(MotesError, match="no host answers"):
        reachable("gone:1")
