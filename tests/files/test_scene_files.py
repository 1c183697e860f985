"""Scenes recorded from scripts and replayed by `motes_replay`, without Python, on any number of ranks."""

from __future__ import annotations

import hashlib
import json
import os
import random
import resource
import select
import struct
import subprocess
import threading
from dataclasses import dataclass
from pathlib import Path

import pytest
from launching import Result, command, said
from standing import COMMAND_LINE, on_ranks

import motes
from motes._launch import starting

ROOT = Path(__file__).parents[2]
SAYINGS = Path(__file__).parents[1] / "scenes" / "sayings.py"
SMALL = ("--systems", 2, "--particles", 1500, "--frames", 4, "--size", "128x72")
SCRIPTS: dict[str, tuple[object, ...]] = {
    "snow": (ROOT / "examples" / "snow.py", *SMALL),
    "fountain": (ROOT / "examples" / "fountain.py", *SMALL, "--space", "fit"),
    "sayings": (SAYINGS,),
    "sayings that read": (SAYINGS, "--read"),
}
WORLD = """
import motes
world = motes.World(seed=1, progress="off")
water = world.system("water")
"""


@dataclass(frozen=True)
class Recorded:
    """A scene, the output of its recording, and the output of the script on one rank."""

    scene: Path
    text: str
    lines: list[str]


def record(scene: Path, script: object, *arguments: object, own: tuple[str, ...] = ()) -> Result:
    """Run `motes record` on one rank."""
    return on_ranks(1, COMMAND_LINE, "record", *own, "-o", scene, script, *arguments)


def record_text(tmp_path: Path, text: str, *own: str) -> Result:
    """Record a script given as text; the scene's file is x.motes."""
    script = tmp_path / "script.py"
    script.write_text(text)
    return record(tmp_path / "x.motes", script, own=own)


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Recorded]:
    """Run each script once and record it once."""
    folder = tmp_path_factory.mktemp("scenes")
    found = {}
    for name, (script, *arguments) in SCRIPTS.items():
        scene = folder / f"{name}.motes".replace(" ", "-")  # smpirun splits arguments at blanks
        assert isinstance(script, Path)
        out = [] if script == SAYINGS else ["--out", folder / "out"]
        said = record(scene, script, *arguments, *out)
        assert said.code == 0, said.text
        run = on_ranks(1, script, *arguments, *out, "--digest")
        found[name] = Recorded(scene, said.out, run.lines)
    return found


def replay(program: Path, ranks: int, *arguments: object, env: dict[str, str] | None = None) -> Result:
    """Run `motes_replay`, under mpirun for several ranks."""
    argv = [str(program), *map(str, arguments)]
    return command(argv if ranks == 1 else starting.command(ranks, argv), timeout=60, env=env)


def complaints(result: Result) -> list[str]:
    """Return the lines in which the driver reports errors."""
    return said(result.err, "motes_replay: ")


def test_a_balancers_program_that_ends_is_named(
    motes_replay: Path, recorded: dict[str, Recorded], tmp_path: Path
):
    """The program never reads the second table: no signal kills the ranks, and their error says why."""
    (tmp_path / "facts").write_text("Mine\n0.5 system\n")
    for name in ("tables", "plans"):
        os.mkfifo(tmp_path / name)
    tables = os.open(tmp_path / "tables", os.O_RDONLY | os.O_NONBLOCK)
    plans = os.open(tmp_path / "plans", os.O_RDWR)

    def answer_once() -> None:
        os.set_blocking(tables, True)
        assert select.select([tables], [], [], 60)[0] and os.read(tables, 4096).startswith(b"0 0 x 3 ")
        os.close(tables)
        os.write(plans, b"orders\n")

    helper = threading.Thread(target=answer_once)
    helper.start()
    ended = replay(motes_replay, 5, recorded["snow"].scene, "--ask", tmp_path)
    helper.join()
    os.close(plans)
    assert ended.code == 1 and "the balancer's program has ended" in ended.text, ended.text


@pytest.mark.parametrize("ranks", [1, 3, 5])
@pytest.mark.parametrize("name", SCRIPTS)
def test_same_digests_without_python(
    motes_replay: Path, recorded: dict[str, Recorded], name: str, ranks: int
):
    lines = recorded[name].lines
    assert len({line.split()[1] for line in lines}) == len(lines) > 3, "each frame differs"
    assert replay(motes_replay, ranks, recorded[name].scene, "--digest").lines == lines


PERIODIC = """
import motes
from motes import shapes
world = motes.World(seed=2, periodic={"x": (0, 3), "y": (-1, 1)}, progress="off")
s = world.system("s")
with world:
    for frame in world.frames(4):
        s.configure(velocity=shapes.Sphere((0, 0, 0), 30), size=0.2)
        s.burst(shapes.Box((0, 0, 0), (9, 9, 1)), count=80)
        s.collide()
        s.move()
        world.step()
    print("digest", world.digest())
"""


def test_a_scene_has_its_space(motes_replay: Path, tmp_path: Path):
    assert record_text(tmp_path, PERIODIC).code == 0
    wanted = on_ranks(3, PERIODIC).lines[0].removeprefix("digest ")
    for ranks in (1, 2):
        last = replay(motes_replay, ranks, tmp_path / "x.motes", "--no-images", "--digest").lines[-1]
        assert wanted in last


def test_sayings_say_all_that_a_scene_can_hold(recorded: dict[str, Recorded]):
    assert recorded["sayings"].lines != recorded["sayings that read"].lines
    pictures = [line.split()[2] for line in recorded["sayings"].lines]
    assert pictures[4] == "-" and len(set(pictures)) == len(pictures)
    assert "7 frames, 3 systems" in recorded["sayings"].text


def test_neither_python_nor_a_certain_mpi_in_it(motes_replay: Path):
    needed = subprocess.run(["ldd", motes_replay], capture_output=True, text=True, check=True).stdout
    assert "libstdc++" in needed and "libmpi" not in needed and "python" not in needed.lower()


def test_recording_on_any_number_of_ranks_gives_the_same_file(recorded: dict[str, Recorded], tmp_path: Path):
    made = on_ranks(3, COMMAND_LINE, "record", "--json", SAYINGS, "--read", "-o", tmp_path / "s.motes")
    wanted = recorded["sayings that read"].scene.read_bytes()
    said = json.loads(made.lines[-1])
    assert (said["frames"], said["systems"], said["bytes"]) == (7, 3, len(wanted))
    assert (tmp_path / "s.motes").read_bytes() == wanted


def test_full_recording_is_an_ordinary_run(recorded: dict[str, Recorded], tmp_path: Path):
    made = record(tmp_path / "s.motes", SAYINGS, "--digest", own=("--full",))
    assert made.lines[:-1] == recorded["sayings"].lines
    plain = record(tmp_path / "t.motes", SAYINGS, "--digest")
    assert [line.split()[1] for line in plain.lines[:-1]] == [
        line.split()[1] for line in recorded["sayings"].lines
    ], "digests are computed when they are asked for"


def test_pictures_logs_and_parts_of_a_scene(
    motes_replay: Path, recorded: dict[str, Recorded], tmp_path: Path
):
    scene, _, lines = recorded["sayings"].scene, "", recorded["sayings"].lines
    out, log = tmp_path / "out", tmp_path / "log"
    argv = (scene, "--digest", "--out", out, "--log", log, "--roles", "shared")
    assert replay(motes_replay, 3, *argv).lines == lines
    names = [f"frame-{i:05}.ppm" for i in range(7) if i != 4]
    assert sorted(path.name for path in out.iterdir()) == names
    for name in names:
        header, size, most, pixels = (out / name).read_bytes().split(b"\n", 3)
        assert (header, size, most) == (b"P6", b"96 64", b"255")
        digest = hashlib.sha256(b"64x96x3\n" + pixels).hexdigest()
        assert digest == lines[int(name[6:11])].split()[2]
    rows = [json.loads(line) for line in (log / "frames.jsonl").read_text().splitlines()]
    assert [f"{r['frame']} {r['particles_digest']} {r.get('image_sha256', '-')}" for r in rows] == lines
    run = json.loads((log / "run.json").read_text())
    assert run["seed"] == 77 and run["calculators"] == [0, 1, 2] and len(run["ranks"]) == 3
    assert (run["balancer"], run["systems"], run["axes"]) == ("Static()", ["sparks", "smoke"], ["x", "y"])
    less = replay(motes_replay, 1, scene, "--frames", 2, "--no-images", "--digest").lines
    assert less == [" ".join([*line.split()[:2], "-"]) for line in lines[:2]]


def test_balancers_and_rounds_of_its_own_choice(
    motes_replay: Path, recorded: dict[str, Recorded], tmp_path: Path
):
    scene, lines = recorded["sayings that read"].scene, recorded["sayings that read"].lines
    argv = ("--digest", "--combine", "overlapped", "--log", tmp_path, "--spans")
    assert replay(motes_replay, 5, scene, "--balancer", "PrefixCuts(min_particles=1)", *argv).lines == lines
    assert motes.open_run(tmp_path).frames.exchanged.sum() > 0
    run = json.loads((tmp_path / "run.json").read_text())
    assert (run["balancer"], run["combine"]) == (
        repr(motes.balance.PrefixCuts(min_particles=1)),
        "overlapped",
    )
    # The driver's own defaults match those of Python.
    for name in ("Static", "Pairwise", "Diffusive", "PrefixCuts"):
        replay(motes_replay, 1, scene, "--frames", 0, "--log", tmp_path, "--balancer", name)
        run = json.loads((tmp_path / "run.json").read_text())
        assert run["balancer"] == repr(getattr(motes.balance, name)())


def test_the_scenes_own_balancer_is_used_if_it_is_built_in(motes_replay: Path, tmp_path: Path):
    body = "with world:\n    for frame in world.frames(2):\n        world.step()\n"
    scene, log = tmp_path / "x.motes", tmp_path / "log"
    kept = WORLD.replace("seed=1", "seed=1, balancer=motes.balance.Pairwise(0.25), combine='one_by_one'")
    assert record_text(tmp_path, kept + body).code == 0
    assert replay(motes_replay, 1, scene, "--log", log).code == 0
    run = json.loads((log / "run.json").read_text())
    assert (run["balancer"], run["combine"]) == (repr(motes.balance.Pairwise(0.25)), "one_by_one")
    own = "import motes\nfrom motes.balance import Balancer, Orders\n"
    own += "class Own(Balancer):\n    def decide(self, load): return Orders([])\n"
    assert record_text(tmp_path, own + WORLD.replace("seed=1", "seed=1, balancer=Own()") + body).code == 0
    refused = replay(motes_replay, 1, scene)
    assert refused.code == 1 and "Own() is defined by its script: choose one with --balancer" in refused.err
    assert replay(motes_replay, 1, scene, "--balancer", "Static").code == 0


@pytest.mark.parametrize("ranks", [1, 3])
def test_what_is_wrong_is_said_once(
    motes_replay: Path, recorded: dict[str, Recorded], tmp_path: Path, ranks: int
):
    whole = recorded["snow"].scene.read_bytes()
    (tmp_path / "cut.motes").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "damaged.motes").write_bytes(whole[:-9] + bytes([whole[-9] ^ 1]) + whole[-8:])
    cases: list[tuple[tuple[object, ...], str]] = [
        ((), "no scene given"),
        ((tmp_path / "none.motes",), "No such file"),
        ((tmp_path / "cut.motes",), f"is cut off: {len(whole) // 2} of {len(whole)} bytes"),
        ((tmp_path / "damaged.motes",), "is damaged"),
        ((SAYINGS,), "is not a recorded scene"),
        ((tmp_path,), "it is not a regular file"),
        ((recorded["snow"].scene, "--frames", "two"), "--frames must be a whole number, got 'two'"),
        (
            (recorded["snow"].scene, "--roles", "any"),
            "must be one of auto, shared, managing, all, got 'any'",
        ),
        ((recorded["snow"].scene, "--balancer", "Own()"), "balancer must be one of Static, Pairwise"),
        ((recorded["snow"].scene, "--balancer", "Static", "--ask", "x"), "both name a balancer"),
        ((recorded["snow"].scene, "--spans"), "--spans needs --log"),
        ((recorded["snow"].scene, "--fast"), "unknown option --fast"),
        ((recorded["snow"].scene, "--out"), "--out must be followed by a value"),
    ]
    for argv, text in cases if ranks == 1 else cases[:3]:
        result = replay(motes_replay, ranks, *argv)
        assert result.code == 2, result.text
        assert len(complaints(result)) == 1 and text in complaints(result)[0], result.text
        assert not result.out


@pytest.mark.parametrize("ranks", [1, 3])
def test_a_run_that_fails_ends_on_all_ranks(motes_replay: Path, recorded: dict[str, Recorded], ranks: int):
    scene = recorded["snow"].scene
    for argv in (("--log", "/dev/null/log"), ("--out", "/dev/null/out")):
        result = replay(motes_replay, ranks, scene, *argv)
        assert result.code == 1, result.text
        assert len(complaints(result)) == 1 and "/dev/null" in complaints(result)[0], result.text
    wrong = replay(motes_replay, ranks, scene, env={"MOTES_STALL_S": "soon"})
    assert wrong.code == 2 and "MOTES_STALL_S" in complaints(wrong)[0]


def scene_hash(content: bytes) -> bytes:
    """Hash the content as `cpp/recording/record.cpp` does."""
    most = 2**64 - 1

    def mix(x: int) -> int:
        x = ((x ^ (x >> 30)) * 0xBF58476D1CE4E5B9) & most
        x = ((x ^ (x >> 27)) * 0x94D049BB133111EB) & most
        return x ^ (x >> 31)

    low, high = 0x9E3779B97F4A7C15, len(content)
    for at in range(0, len(content), 8):
        piece = int.from_bytes(content[at : at + 8], "little")
        low = (mix(low ^ piece) + 0x9E3779B97F4A7C15) & most
        high = mix((high + piece * 0xD6E8FEB86659FD93) & most) ^ low
    return struct.pack("<QQ", mix(low), mix(high))


def repaired(scene: bytes | bytearray) -> bytes:
    """Return the scene with the hash recomputed from its content."""
    return bytes(scene[:24]) + scene_hash(bytes(scene[56:])) + bytes(scene[40:])


def damaged(scene: bytes, seed: int) -> bytes:
    """Change a few bytes of the content and repair the hash."""
    chosen, changed = random.Random(seed), bytearray(scene)
    for _ in range(chosen.randint(1, 3)):
        at = chosen.randrange(56, len(scene) - 4)
        number = chosen.choice((-(2**31), -1, 0, 1, 5, 64, 100, 2**31 - 1))
        kind = chosen.randrange(3)
        if kind == 0:
            changed[at] = chosen.choice((0, 1, 2, 3, 4, 5, 9, 13, 20, 63, 64, 127, 128, 255))
        elif kind == 1:
            changed[at] ^= 1 << chosen.randrange(8)
        else:
            changed[at : at + 4] = number.to_bytes(4, "little", signed=True)
    return repaired(changed)


def survives(program: Path, scene: Path, *, memory: int | None = 4 << 30) -> None:
    """Replay a scene that may be damaged: it runs, times out, or prints one line saying why not."""

    def limit() -> None:
        if memory is not None:
            resource.setrlimit(resource.RLIMIT_AS, (memory, memory))

    try:
        run = subprocess.run(
            [program, scene, "--digest"], capture_output=True, text=True, timeout=20, preexec_fn=limit
        )
    except subprocess.TimeoutExpired:
        return
    assert run.returncode in (0, 1, 2), f"{scene}: {run.returncode}\n{run.stderr}"
    assert (run.returncode == 0) == (len(said(run.stderr, "motes_replay: ")) == 0), run.stderr


def check_damaged_scenes(program: Path, whole: bytes, folder: Path, seeds: range) -> None:
    for seed in seeds:
        scene = folder / f"damaged-{seed}.motes"
        scene.write_bytes(damaged(whole, seed))
        survives(program, scene, memory=None if "MOTES_TEST_REPLAY" in os.environ else 4 << 30)
        scene.unlink()


def test_a_scene_with_wrong_content_under_a_right_hash_is_no_crash(
    motes_replay: Path, recorded: dict[str, Recorded], tmp_path: Path
):
    whole = recorded["sayings that read"].scene.read_bytes()
    assert repaired(whole) == whole, "the hash is the core's"
    check_damaged_scenes(motes_replay, whole, tmp_path, range(10))


@pytest.mark.slow
def test_many_scenes_with_wrong_content_are_no_crash(
    motes_replay: Path, recorded: dict[str, Recorded], tmp_path: Path
):
    whole = recorded["sayings that read"].scene.read_bytes()
    check_damaged_scenes(motes_replay, whole, tmp_path, range(10, 400))


def test_ranks_behave_like_slower_machines(motes_replay: Path, recorded: dict[str, Recorded], tmp_path: Path):
    scene = recorded["fountain"]
    asked = {"MOTES_SPEEDS": "0:1.0,2:0.25"}
    result = replay(motes_replay, 4, scene.scene, "--digest", "--log", tmp_path / "log", env=asked)
    assert result.lines == scene.lines
    assert motes.open_run(tmp_path / "log").speeds == {0: 1.0, 2: 0.25}
    for text in ("0", "0:0", "4:0.5", "0:0.5,", "0:1e-9", "-1:1", "0:nan", "0:0.5x"):
        refused = replay(motes_replay, 1, scene.scene, env={"MOTES_SPEEDS": text})
        assert refused.code == 2, text
        assert f"with ranks 0..0 and speeds 0.001..1, got '{text}'" in complaints(refused)[0]


def test_help(motes_replay: Path):
    lines = replay(motes_replay, 3, "--help").lines
    assert lines[0].startswith("usage: motes_replay scene.motes") and lines.count(lines[0]) == 1


def test_what_only_python_can_do_is_refused(tmp_path: Path):
    loop = "with world:\n    for frame in world.frames(3):\n        water.burst((0, 0, 0), count=5)\n"
    called = "def heat_up(p): pass\n" + loop + "        if frame == 2: water.callback(heat_up)\n"
    written = loop + "        with water.local() as p: p.age[:] = frame\n"
    for body, text in (
        (called + "        world.step()\n", "record: frame 2: 'water' calls the function heat_up"),
        (written + "        world.step()\n", "record: frame 0: the script writes particles of 'water'"),
        (
            written.replace("p.age[:] = frame", "p.age *= 2") + "        world.step()\n",
            "record: frame 0: the script writes particles of 'water'",
        ),
        (
            written.replace("p.age[:] = frame", "p.position[1:, 0][:2] = 5") + "        world.step()\n",
            "record: frame 0: the script writes particles of 'water'",
        ),
        (
            loop + "        world.step()\nwith motes.World(): pass\n",
            "record: the script creates a second world",
        ),
        ("", "ran no world to its end"),
        (loop + "        world.step()\n    raise ValueError('the mistake')\n", "ValueError: the mistake"),
    ):
        result = record_text(tmp_path, WORLD + body)
        assert result.code != 0 and text in result.err, result.text
        assert [path.name for path in tmp_path.iterdir()] == ["script.py"], "nothing is written"


ROPE_AFTER_CHILDREN = """
import sys, motes
from motes.shapes import Sphere
world = motes.World(seed=1, dt=0.02, progress="off")
s, t = world.system("s"), world.system("t")
with world:
    for frame in world.frames(6):
        s.configure(lifetime=0.05)
        s.burst(Sphere((0, 0, 0), 1), count=7)
        s.spawn(into=t, on="death", count=1)
        s.move()
        s.kill_expired()
        if frame == 4:
            ties = t.rope((0, 0, 0), (1, 0, 0), 10)
        if frame >= 4:
            t.gravity((0, -9, 0))
            t.tie(ties)
        t.move()
        picture = world.step()
        if "--digest" in sys.argv:
            motes.script.print_digest(world, picture)
"""


def test_a_recorded_rope_ties_its_own_particles(motes_replay: Path, tmp_path: Path):
    """Ids depend on the number of children, so a recording must count them."""
    record_text(tmp_path, ROPE_AFTER_CHILDREN)
    again = replay(motes_replay, 1, tmp_path / "x.motes", "--digest")
    assert again.lines == on_ranks(1, ROPE_AFTER_CHILDREN, "--digest").lines


def test_a_recording_draws_nothing_and_says_so(tmp_path: Path):
    text = WORLD.replace(
        "seed=1", "seed=1, renderer=motes.Renderer(8, 8, camera=motes.Camera((0, 0, 1), (0, 0, 0)))"
    )
    text += "with world:\n    frame = world.render()\n    assert not frame and not frame.made\n"
    assert record_text(tmp_path, text + f"    frame.save({str(tmp_path / 'x.png')!r})\n").code == 0
    assert not (tmp_path / "x.png").exists()
    refused = record_text(tmp_path, text + "    frame.pixels\n")
    assert refused.code != 0 and "frame 0 has no picture: a recording draws no pictures" in refused.err
    assert (
        record_text(tmp_path, text.replace("not frame and not", "") + "    frame.pixels\n", "--full").code
        == 0
    )


def test_record_needs_a_script_and_a_name(tmp_path: Path):
    for argv, text in (
        ([], "no script given"),
        (["none.py", "-o", "x.motes"], "script none.py does not exist"),
        ([str(SAYINGS)], "no output file given"),
    ):
        result = on_ranks(1, COMMAND_LINE, "record", *argv)
        assert result.code == 2 and text in result.err, result.text


def test_a_program_of_ones_own(native_example: Path):
    alone = command([native_example]).lines
    assert len(alone) == 24 and len(set(line.split()[-1] for line in alone)) == 24
    assert command(starting.command(3, [str(native_example)])).lines == alone


CLUSTER = """<?xml version='1.0'?>
<!DOCTYPE platform SYSTEM "https://simgrid.org/simgrid.dtd">
<platform version="4.1"><zone id="world" routing="Full">
<cluster id="cluster" prefix="n" suffix="" radical="0-39" speed="1Gf" bw="1Gbps" lat="50us"/>
</zone></platform>
"""
FLAGS = ("simulate-computation:no", "test:0", "lat-factor:0:1", "bw-factor:0:1")


@pytest.mark.slow
def test_same_digests_and_equal_logs_on_a_simulated_cluster(
    simulated_replay: Path, recorded: dict[str, Recorded], tmp_path: Path
):
    (tmp_path / "cluster.xml").write_text(CLUSTER)
    (tmp_path / "hosts").write_text("".join(f"n{i}\n" for i in range(40)))
    flags = ["--log=root.thresh:warning", *(f"--cfg=smpi/{flag}" for flag in FLAGS)]
    where = ["-hostfile", tmp_path / "hosts", "-platform", tmp_path / "cluster.xml"]
    for name in SCRIPTS:
        many = ["--births", "calculators", "--fan-out", "3"]  # 38 calculators: a ring of two steps
        for ranks, log, more in ((1, "a", []), (4, "b", []), (18, "c", []), (18, "d", []), (40, "e", many)):
            argv = ["smpirun", "-np", ranks, *where, *flags, simulated_replay, recorded[name].scene]
            played = command([*argv, *more, "--digest", "--log", tmp_path / log])
            assert played.lines == recorded[name].lines, f"{name} on {ranks} ranks"
        for table in ("frames.jsonl", "load.jsonl", "events.jsonl"):
            assert (tmp_path / "c" / table).read_bytes() == (tmp_path / "d" / table).read_bytes()
    failed = command(["smpirun", "-np", 3, *where, *flags, simulated_replay, SAYINGS])
    assert failed.code == 2 and "is not a recorded scene" in failed.err
