"""The state in a checkpoint besides particles: births can be repeated; frames that failed are left out."""

from __future__ import annotations

import base64
import json
import os
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from launching import python, said
from standing import on_ranks

import motes
from motes._checkpoint import folder, plain_data
from motes._checkpoint.manifest import Manifest

BORN_OF_MESHES = """
import os, sys, motes
from motes import shapes
from motes.expressions import column
world = motes.World(seed=1, progress="off", checkpoint=motes.Checkpoint(sys.argv[1], every=2))
s = world.system("s")
with world:
    for frame in world.frames(8):
        if frame == int(os.environ.get("KILL", -1)):
            os._exit(9)
        if frame == 0:
            corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
            solid = motes.Mesh(corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], solid=True)
            s.configure(velocity=motes.Mesh(corners, [(0, 1, 2)]))
            s.burst(solid | shapes.Sphere((3, 0, 0), 1), count=50)
            s.burst(solid.at((5, 0, 0)), count=50)
        s.move()
        world.step()
    s.set(color=column("position_b"))
    s.set(size=column("velocity_b"))
    world.step()
    print("digest", world.digest(), s.total(column("position_b").x))
"""


def test_births_of_meshes_are_made_again_where_another_run_goes_on(tmp_path):
    """The other run never constructs these meshes."""
    whole = on_ranks(1, BORN_OF_MESHES, tmp_path / "a")
    assert python(BORN_OF_MESHES, tmp_path / "b", env={"KILL": "6"}).code == 9
    again = on_ranks(2, BORN_OF_MESHES, tmp_path / "b")
    assert said(again.err, "motes: continues with frame 4")
    assert set(said(again.out, "digest")) == set(said(whole.out, "digest")), again.text


FAILS_AT_THE_END = """
import resource, sys, motes
from motes import shapes
world = motes.World(seed=1, progress="off", checkpoint=motes.Checkpoint(sys.argv[1], every=2))
s, sparks = world.system("s"), world.system("sparks")
with world:
    for frame in world.frames(3):
        s.source(shapes.Sphere((0, 0, 0), 1), rate=2400)
        if frame == 2 and "calculator" in world.role:
            now = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
            resource.setrlimit(resource.RLIMIT_AS, (now + 400_000_000, resource.RLIM_INFINITY))
        if frame == 2:
            s.spawn(into=sparks, on="birth", count=1_000_000)
        s.move()
        world.step()
"""


@pytest.mark.parametrize("ranks", [1, 3])
def test_a_frame_that_failed_is_in_no_checkpoint(tmp_path, ranks):
    """The last frame fails after all ranks have agreed on it: there is no memory for its children."""
    result = on_ranks(ranks, FAILS_AT_THE_END, tmp_path)
    assert result.code != 0
    assert "MemoryError" in result.err, result.text
    assert [frame for frame, _ in folder.whole(tmp_path)] == [2]


# --- trust in checkpoints


class Planted:
    """An object whose pickle creates a directory when it is loaded."""

    def __init__(self, target: Path) -> None:
        self.target = target

    def __reduce__(self) -> Any:
        return os.mkdir, (str(self.target),)


def test_what_is_kept_reads_back_as_it_was():
    given = {
        "a": [1, 2.5, None, True, "text", float("inf"), 2**70],
        3: (b"\0\xff", np.arange(6, dtype=np.float32).reshape(2, 3), np.float64(0.1)),
        "moves": motes.Uniform(motes.Curve([(0, 1), (2, (3.0))]), 5),
        "nested": {"tuple": [1]},
    }
    again = plain_data.value_of(json.loads(json.dumps(plain_data.data_of(given))))
    assert repr(again) == repr(given) and type(again[3][2]) is np.float64
    assert again[3][1].dtype == np.float32 and again["moves"] == given["moves"]
    for no_data in (object(), {1, 2}, np.array([object()]), motes.World, motes.shapes.Sphere((0, 0, 0), 1)):
        with pytest.raises(TypeError, match="is not plain data"):
            plain_data.data_of(no_data)


@pytest.mark.parametrize(
    "planted",
    [{"array": ["O", [1], "", True]}, {"value": ["World", {"dict": []}]}, {"x": 1}, {}, {"a": 1, "b": 2}],
)
def test_what_is_never_kept_is_a_checkpoint_error(planted):
    manifest = Manifest(1, 0.0, 1, 0.1, 1, "1", {}, [], [], {}, script_state=planted)
    with pytest.raises(motes.CheckpointError, match="is damaged"):
        manifest.unpacked(Path("here"))


KEEPS = """
import sys, motes

class Own(motes.balance.Balancer):
    def __init__(self):
        self.seen = [0]
        if sys.argv[2] == "more":
            self.more = {1, 2}

    def decide(self, load):
        return motes.balance.Orders([])

balancer = Own()
pickles = sys.argv[3:] == ["pickles"]
world = motes.World(seed=1, progress="off", balancer=balancer,
                    checkpoint=motes.Checkpoint(sys.argv[1], every=1, pickles=pickles))
s = world.system("s")
with world:
    s.configure(velocity=motes.Uniform((0, 0, 0), motes.Curve([(0, (1, 0, 0)), (1, (2, 0, 0))])))
    for frame in world.frames(4):
        print("seen", balancer.seen, getattr(balancer, "more", None), flush=True)
        balancer.seen.append(frame)
        if hasattr(balancer, "more"):
            balancer.more.add(frame)
        if frame == 2 and not world.time > 1:
            import os; os._exit(9)
        s.burst((0, 0, 0), count=3)
        s.move()
        world.step()
"""


@pytest.mark.parametrize(
    ("arguments", "then"),
    [
        (("data",), ("[0, 0] None", "[0, 0, 1] None")),
        (("more",), ("[0] {1, 2}",)),
        (("more", "pickles"), ("[0, 0] {0, 1, 2}", "[0, 0, 1] {0, 1, 2}")),
    ],
)
def test_a_balancers_own_attributes_are_kept_as_data_or_by_pickle_where_asked(tmp_path, arguments, then):
    first = python(KEEPS, tmp_path, *arguments)
    assert first.code == 9
    assert ("Checkpoint(pickles=True) stores it as a pickle" in first.err) == (arguments == ("more",)), (
        first.text
    )
    again = python(KEEPS, tmp_path, *arguments)
    assert said(again.out, "seen")[0].strip() in then, again.text


@pytest.mark.parametrize("where", ["kept", "balancer"])
def test_a_checkpoint_of_somebody_else_runs_no_code(tmp_path, where):
    assert python(KEEPS, tmp_path / "checkpoints", "data").code == 9
    text = pickle.dumps(Planted(tmp_path / "ran"))
    for _, path in folder.whole(tmp_path / "checkpoints"):
        manifest = Manifest.from_bytes((path / folder.MANIFEST).read_bytes(), path)
        if where == "kept":
            manifest.script_state = base64.b64encode(text).decode()
        else:
            manifest.with_script_state({**manifest.unpacked(path), "balancer": ("Own", text)})
        manifest.write(path)
    again = python(KEEPS, tmp_path / "checkpoints", "data")
    assert again.code == 1 and "CheckpointError" in again.err, again.text
    assert where == "kept" or "as a pickle, which can run any code" in again.err
    assert not (tmp_path / "ran").exists()


def test_no_symbolic_link_in_a_directory_of_checkpoints_is_written_to(tmp_path):
    victim = tmp_path / "victim"
    victim.write_text("precious")
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / ".lock").symlink_to(victim)
    with pytest.raises(motes.CheckpointError, match="cannot use the directory"):
        folder.Lock(tmp_path / "a")
    (tmp_path / "elsewhere").mkdir()
    place = folder.begun(tmp_path / "a", 3)
    place.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(FileExistsError, match="it is a symbolic link to"):
        folder.make_begun(place)
    assert victim.read_text() == "precious" and not list((tmp_path / "elsewhere").iterdir())
