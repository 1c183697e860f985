"""motes.draw: pictures of arrays on the ranks of any MPI program."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from launching import mpirun
from standing import on_ranks

import motes
from motes.errors import ArgumentError

CAMERA = motes.Camera((0, 0, 6), (0, 0, 0))
RENDERER = motes.Renderer(160, 100, camera=CAMERA)

SHOWN = """
import json, sys
import numpy as np
from mpi4py import MPI
import motes

comm, path = MPI.COMM_WORLD, sys.argv[1]
rng = np.random.default_rng(1)
places = rng.normal(size=(4000, 3)).astype(np.float32)
places[2000:] = places[:2000]  # each has a twin, of another colour
colors, alphas, sizes = rng.random((4000, 3)), rng.random(4000), rng.random(4000) * 0.2
mine = np.random.default_rng(comm.size).permutation(4000)
mine = mine[comm.rank :: comm.size] if comm.size < 3 else mine[comm.rank - 1 :: comm.size - 1]
if comm.size > 2 and comm.rank == 0:
    mine = mine[:0]  # a rank without particles
sprites = [
    motes.Sprite(),
    motes.Sprite("sphere", pixels=None, blend="opaque"),
    motes.Sprite(pixels=7, blend="alpha"),
    motes.Sprite("image", 9, "opaque", image=[np.full((4, 4, 4), n * 60 + 60, np.uint8) for n in range(3)]),
    motes.Sprite("point", blend="opaque", lit=True, shadow=0.5),
]
camera = motes.Camera((0, 0, 6), (0, 0, 0))
digests = []
for sprite in sprites:
    renderer = motes.Renderer(160, 100, camera=camera, path=path, sun=(1, 2, 3))
    frame = motes.draw(
        places[mine], renderer=renderer, comm=comm, color=colors[mine], alpha=alphas[mine], size=sizes[mine],
        sprite=sprite,
    )
    assert bool(frame) == (comm.rank == 0)
    digests.append(frame.digest() if frame else "")
if comm.rank == 0:
    print(json.dumps(digests))
if comm.rank == 0 and len(sys.argv) > 2:  # the same particles in a world
    own = []
    for sprite in sprites:
        renderer = motes.Renderer(160, 100, camera=camera, sun=(1, 2, 3))
        world = motes.World(seed=1, renderer=renderer, progress="off", comm=MPI.COMM_SELF)
        system = world.system("all", sprite=sprite)
        with world:
            for _ in world.frames(1):
                wide = np.repeat(sizes[:, None], 3, axis=1)
                system.emit(position=places, color=colors, alpha=alphas, size=wide)
                own.append(world.render().digest())
    print(json.dumps(own))
"""


def test_the_picture_depends_on_the_particles_alone() -> None:
    """It is the same for any ranks, any order and any path, and the same as that of a world."""
    ours, worlds = on_ranks(1, SHOWN, "auto", "world").lines
    drawn, world = (json_list(line) for line in (ours, worlds))
    assert len(set(drawn)) == len(drawn)
    assert [drawn[k] for k in (0, 1, 2, 4)] == [world[k] for k in (0, 1, 2, 4)]  # 3 picks images at random
    for ranks, path in ((2, "auto"), (3, "tiles"), (5, "composite"), (3, "gather")):
        assert json_list(on_ranks(ranks, SHOWN, path).lines[0]) == drawn, (ranks, path)


def json_list(line: str) -> list[str]:
    """Read a line of JSON."""
    import json

    read: list[str] = json.loads(line)
    return read


WRONG = """
import numpy as np
from mpi4py import MPI
import motes
from motes.errors import ArgumentError, ScriptMismatchError

comm = MPI.COMM_WORLD
last = comm.rank == comm.size - 1
camera = motes.Camera((0, 0, 6), (0, 0, 0))
renderer = motes.Renderer(64, 48, camera=camera)
places = np.zeros((4, 3))

class Odd:
    def __array__(self, *_, **__):
        raise RuntimeError("odd")

for positions, given in (
    (np.full((4, 3), np.nan if last else 0), {}),
    (places, {"color": places[: 3 if last else 4]}),
    (places, {"alpha": "much" if last else 1}),
    (places, {"size": [1, 2, 3, 1e300] if last else 2}),
    (Odd() if last else places, {}),
    (places, {"sprite": motes.Sprite("ribbon", width=1, length=1) if last else None}),
    (places, {"renderer": None if last else renderer}),
):
    try:
        motes.draw(positions, comm=comm, **{"renderer": renderer, **given})
    except ArgumentError as error:
        print(comm.rank, error)
try:
    motes.draw(places, comm=comm, renderer=motes.Renderer(64 + comm.rank, 48, camera=camera))
except ScriptMismatchError as error:
    print(comm.rank, "different camera or renderer" in str(error))
frame = motes.draw(places, renderer=renderer)
print(comm.rank, "goes on", bool(frame), frame.made)
half = comm.Split(comm.rank % 2)
motes.draw(places, renderer=renderer, comm=half)
half.Free()
try:
    motes.draw(places, renderer=renderer, comm=half)
except ArgumentError as error:
    print(comm.rank, error)
"""


def test_what_is_wrong_on_one_rank_is_said_on_all() -> None:
    """Each rank raises ArgumentError; afterwards they can draw."""
    lines = on_ranks(3, WRONG).lines
    for rank in range(3):
        said = [line.split(" ", 1)[1] for line in lines if line.startswith(f"{rank} ")]
        who = "" if rank == 2 else "rank 2: "
        assert said[:7] == [
            f"{who}positions must be finite numbers within float32's range, got '[nan, nan, nan] in row 0'",
            f"{who}color must be one for all, or of 4 rows, like positions, got '3 rows'",
            f"{who}alpha must be a number, got 'much'",
            f"{who}size must be finite numbers within float32's range, got '1e+300 in row 3'",
            said[4],
            f"{who}sprite must be of a kind without past positions, got 'ribbon'",
            f"{who}renderer must be a motes.Renderer, got None",
        ]
        assert said[4].startswith(f"{who}positions must be numbers of shape (n, 3), got ")
        assert said[7:9] == ["True", f"goes on {rank == 0} True"]
        assert said[9].startswith("comm must be None or an mpi4py intracommunicator that has not been freed")


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"positions": np.zeros(3)}, r"positions must be numbers of shape \(n, 3\)"),
        ({"positions": np.zeros((2, 4))}, "positions must be"),
        ({"positions": [[1, "x", 2]]}, "positions must be"),
        ({"positions": np.ma.masked_array(np.zeros((1, 3)), mask=[[0, 1, 0]])}, "positions must be"),
        ({"color": "oranje"}, "color must be a colour"),
        ({"color": [[1, 2], [3]]}, r"color must be numbers of shape \(n, 3\)"),
        ({"color": np.zeros((2, 3, 1))}, "color must be"),
        ({"alpha": [[1], [2]]}, "alpha must be one number, or numbers of shape"),
        ({"alpha": np.inf}, "alpha must be a finite number"),
        ({"size": np.zeros((2, 3))}, "size must be one number, or numbers of shape"),
        ({"sprite": "point"}, "sprite must be None or a motes.Sprite"),
        ({"renderer": RENDERER.camera}, "renderer must be None or a motes.Renderer"),
        ({"comm": "world"}, "comm must be None or an mpi4py intracommunicator"),
    ],
)
def test_wrong_arguments(given: dict[str, object], text: str) -> None:
    """Each is named, with what is allowed."""
    good: dict[str, object] = {"positions": np.zeros((2, 3)), "renderer": RENDERER}
    with pytest.raises(ArgumentError, match=text):
        motes.draw(**{**good, **given})  # type: ignore[arg-type]


def test_numbers_of_any_type_and_order() -> None:
    """The picture is that of the same numbers as float32 in C order; one value stands for all."""
    places = np.arange(-6, 6).reshape(4, 3)
    size, white = np.full(4, 0.5, np.float32), np.ones((4, 3), np.float32)
    sprite = motes.Sprite(pixels=None)
    plain = motes.draw(places.astype(np.float32), renderer=RENDERER, size=size, color=white, sprite=sprite)
    assert np.asarray(plain).max() > 100
    kinds = (
        places,
        places.tolist(),
        np.asfortranarray(places, np.float64),
        places.astype(">f4"),
        np.repeat(places, 2, axis=0)[::2],
        places.astype(np.float16),
    )
    for given in kinds:
        for color in (1, "white", (1, 1, 1), ["white"] * 4):
            frame = motes.draw(given, renderer=RENDERER, size=0.5, color=color, sprite=sprite)
            assert frame.digest() == plain.digest()
    flat = motes.draw(places[:, :2], renderer=RENDERER)
    assert flat.digest() == motes.draw(places * (1, 1, 0), renderer=RENDERER).digest() != plain.digest()
    assert np.asarray(motes.draw(np.zeros((0, 3)), renderer=RENDERER)).max() == 0
    assert np.asarray(motes.draw(places, renderer=RENDERER, color=0.0)).max() == 0


def test_late_layers_are_those_of_their_picture() -> None:
    """A picture keeps its linear light when the next one is drawn."""
    renderer = motes.Renderer(64, 48, camera=CAMERA, linear=True)
    first = motes.draw(np.zeros((1, 3)), renderer=renderer)
    motes.draw(np.zeros((0, 3)), renderer=renderer)
    assert first.linear.max() > 0


ENDS = """
import sys
import numpy as np
from mpi4py import MPI
import motes

renderer = motes.Renderer(64, 48, camera=motes.Camera((0, 0, 6), (0, 0, 0)))
for k in range(3):
    if k == 2 and MPI.COMM_WORLD.rank == 1 and sys.argv[1] == "leaves":
        sys.exit(0)
    frame = motes.draw(np.zeros((2, 3)), renderer=renderer)
assert frame.index == 2 and frame.time == 3 / 24
frame.save(sys.argv[2])
"""


def test_the_program_ends_as_it_likes(tmp_path: Path) -> None:
    """Nothing is left open after a picture; a rank that leaves while others draw ends the job."""
    assert mpirun(2, ENDS, "ends", tmp_path / "one.png").code == 0
    assert (tmp_path / "one.png").exists()
    left = mpirun(2, ENDS, "leaves", tmp_path / "other.png")
    assert left.code == 1
    assert "rank 1 left the script before the run started" in left.err
