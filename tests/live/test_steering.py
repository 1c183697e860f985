"""A replay repeats what viewers did in a run, bit for bit, on any number of ranks. Real jobs."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import random
import signal
import sys
from pathlib import Path
from typing import Any

import pytest
from launching import Result, command, mpirun
from standing import COMMAND_LINE, on_ranks
from viewers import Beside, Client, url_of

from motes._live import steer_file
from motes.errors import ArgumentError

SCENE = Path(__file__).parents[1] / "scenes" / "steered.py"
LIVE = "dict(live=motes.Live(0, wait=True))"


def rows(folder: Path, name: str = "frames.jsonl") -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / "log" / name).read_text().splitlines()]


def orders(folder: Path) -> list[dict[str, Any]]:
    """Return what steer.jsonl says, but for numbers of ranks, which no run repeats."""
    return [{**row, "ranks": None} for row in rows(folder, "steer.jsonl") if "resize" not in row]


def film(folder: Path) -> list[tuple[int, str, str]]:
    """Return the fields that identify each frame: the digests of its particles and its picture."""
    return [(row["frame"], row["particles_digest"], row["image_sha256"]) for row in rows(folder)]


def new(folder: Path, name: str) -> Path:
    (folder / name).mkdir()
    return folder / name


def run(
    ranks: int, folder: Path, frames: int, options: str = "{}", start: Any = on_ranks, **given: Any
) -> Result:
    return start(ranks, SCENE, folder, frames, options, timeout=100, **given)


def repeat(ranks: int, folder: Path, of: Path, frames: int, more: str = "") -> Result:
    return run(ranks, folder, frames, f"dict(steering={str(of / 'log' / 'steer.jsonl')!r}{more})")


def kill_rank(rank: int, folder: Path, number: int) -> None:
    """Send a signal to a rank of the job in this folder."""
    for entry in Path("/proc").iterdir():
        with contextlib.suppress(OSError):
            ours = entry.name.isdigit() and str(folder).encode() in (entry / "cmdline").read_bytes()
            if ours and b"OMPI_COMM_WORLD_RANK=%d\0" % rank in (entry / "environ").read_bytes():
                os.kill(int(entry.name), number)


async def steer(folder: Path, frames: int) -> None:
    """Send random orders, like a person, until the run is nearly over."""
    dice = random.Random(5)
    async with Client.of(await url_of(folder)) as viewer:
        await viewer.until(lambda: viewer.state.get("frame", 0) > 3)
        for turn in range(1000):
            if viewer.state.get("ended") or viewer.state["frame"] > frames - 60:
                break
            order = dice.choice(
                [
                    {"set": {"wind": dice.uniform(-7, 7)}},
                    {"set": {"dense": dice.choice([10, 33, 60]), "still": dice.random() < 0.3}},
                    {"set": {"shape": dice.choice(["wide", "narrow"])}},
                    {"orbit": [dice.uniform(-0.5, 0.5), dice.uniform(-0.3, 0.3)]},
                    {"pan": [dice.uniform(-0.1, 0.1), dice.uniform(-0.1, 0.1)]},
                    {"zoom": dice.uniform(-0.2, 0.2)},
                    {"camera": None},
                    {"pause": True},
                ]
            )
            await viewer.say(**order)
            if "pause" in order:
                await viewer.until(lambda: bool(viewer.state.get("paused")))
                at = viewer.state["frame"]
                await viewer.say(orbit=[0.3, 0.1])
                await viewer.say(step=2)
                await viewer.until(lambda at=at: viewer.state["frame"] == at + 2)
                await viewer.say(set={"wind": 1.0 + turn / 10})
                await viewer.say(pause=False)
                await viewer.until(lambda: not viewer.state["paused"])
            await asyncio.sleep(0.02)
        await viewer.until(lambda: bool(viewer.state.get("ended") or viewer.state.get("closed")))


@pytest.fixture(scope="module")
def steered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make a run of 200 frames on 4 ranks, steered all the time."""
    folder = tmp_path_factory.mktemp("steered")
    with Beside(lambda: steer(folder, 200)) as beside:
        result = run(4, folder, 200, "dict(live=motes.Live(0, wait=True), pause_s=0.02)", watch=beside.check)
    assert result.code == 0, result.text
    assert len(film(folder)) == 200
    return folder


def test_the_log_tells_what_viewers_did(steered):
    head, *told = rows(steered, "steer.jsonl")
    assert head["schema"] == 1 and head["seed"] == 3 and len(head["script_sha256"]) == 64
    assert head["controls"] == {
        "wind": {"value": 0.0, "low": -5.0, "high": 5.0, "step": 0.1},
        "dense": {"value": 20, "low": 10, "high": 60, "step": 10},
        "still": {"value": False},
        "shape": {"value": "wide", "choices": ["wide", "narrow"]},
    }
    frames = [row["frame"] for row in told]
    assert frames == sorted(set(frames)) and len(frames) > 20
    assert {name for row in told for name in row} == {"frame", "set", "camera"}
    winds = [row["set"]["wind"] for row in told if "wind" in row.get("set", {})]
    assert len(winds) > 3 and all(-5 <= wind <= 5 and wind == float(f"{wind:.1f}") for wind in winds)
    denser = [row["set"]["dense"] for row in told if "dense" in row.get("set", {})]
    assert denser and set(denser) <= {10, 20, 30, 40, 50, 60} and all(type(one) is int for one in denser)
    cameras = [row["camera"] for row in told if row.get("camera")]
    assert len(cameras) > 3 and all(round(x, 4) == x for camera in cameras for x in camera["position"])
    assert any("camera" in row and row["camera"] is None for row in told)


@pytest.mark.parametrize(
    "ranks", [1, pytest.param(2, marks=pytest.mark.slow), pytest.param(3, marks=pytest.mark.slow), 5]
)
def test_a_steered_run_happens_again_on_any_number_of_ranks(steered, tmp_path, ranks):
    more = ", roles='shared'" if ranks == 5 else ""
    result = repeat(ranks, tmp_path, steered, 200, more)
    assert result.code == 0, result.text
    assert film(tmp_path) == film(steered)
    assert orders(tmp_path) == orders(steered)


def test_without_the_orders_it_is_another_film(steered, tmp_path):
    assert run(2, tmp_path, 60, "dict()").code == 0
    assert film(tmp_path) != film(steered)[:60]


# --- what cannot be repeated is refused on all ranks, before anything is lost


@pytest.mark.parametrize("ranks", [pytest.param(1, marks=pytest.mark.slow), 3])
def test_another_seed_is_refused(steered, tmp_path, ranks):
    result = repeat(ranks, tmp_path, steered, 20, ", seed=4")
    assert result.code == 1, result.text
    assert "a steer.jsonl of a run with seed 4: this one has seed 3, got" in result.err, result.text
    assert result.err.count("Traceback") == 1, result.text
    assert not (tmp_path / "log").exists()


def test_a_script_without_a_seed_takes_the_files(steered, tmp_path):
    assert repeat(2, tmp_path, steered, 30, ", seed=None").code == 0
    assert film(tmp_path) == film(steered)[:30]


def test_another_script_is_refused_unless_told_otherwise(steered, tmp_path):
    script = tmp_path / "changed.py"
    script.write_text(SCENE.read_text().replace("half = 4 if", "half = 5 if"))
    path = str(steered / "log" / "steer.jsonl")
    arguments = (tmp_path, 20, f"dict(steering={path!r})")
    result = on_ranks(2, script, *arguments)
    assert result.code == 1, result.text
    line = next(i for i, text in enumerate(script.read_text().splitlines(), 1) if "half = 5 if" in text)
    told = f"the script's line {line} was 'half = 4 if shape.value == \"wide\" else 1' and is 'half = 5 if"
    assert told in result.err and "--anyway repeats it)" in result.err, result.text
    assert on_ranks(2, script, *arguments, env={"MOTES_ANYWAY": "1"}).code == 0
    lost = tmp_path / "steer.jsonl"  # without the log beside it
    lost.write_bytes(Path(path).read_bytes())
    result = on_ranks(1, script, tmp_path, 20, f"dict(steering={str(lost)!r})")
    assert result.code == 1 and "the script has changed since, or is a different one" in result.err


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda lines: [], "it is empty"),
        (lambda lines: ["x", *lines[1:]], "line 1 is not a JSON object"),
        (lambda lines: ['{"schema": 2}'], "its schema is 2, not 1"),
        (lambda lines: ['{"schema": 1}'], "its first line lacks a seed, 0..2.64-1, and script_sha256"),
        (
            lambda lines: [lines[0].replace('"seed": ', '"seed": 18446744073709551616'), *lines[1:]],
            "lacks a seed",
        ),
        (lambda lines: [lines[0].replace('"seed": ', '"seed": -'), *lines[1:]], "lacks a seed"),
        (lambda lines: [*lines, f'{{"frame": {2**70}, "set": {{}}}}'], "must have a frame"),
        (lambda lines: [*lines, "[3]"], "is not a JSON object"),
        (lambda lines: [*lines, '{"frame": -1, "set": {}}'], "must have a frame"),
        (
            lambda lines: [*lines, '{"frame": 900, "sett": {}}'],
            "set, camera, balancer, speeds, resize or stop",
        ),
        (lambda lines: [*lines, '{"frame": 900, "set": 3}'], "sets or stops nothing"),
        (lambda lines: [*lines, '{"frame": 900, "camera": {"position": 1}}'], "a camera must have position"),
        (lambda lines: [*lines, lines[1]], "comes after a later one"),
    ],
)
def test_a_damaged_file_is_refused(steered, tmp_path, damage, message):
    lines = damage((steered / "log" / "steer.jsonl").read_text().splitlines())
    path = tmp_path / "steer.jsonl"
    path.write_text("".join(f"{line}\n" for line in lines))
    with pytest.raises(ArgumentError, match=f"steering must be a steer.jsonl of a run: .*{message}"):
        steer_file.read(str(path))


def test_a_torn_last_line_is_left_out(steered, tmp_path):
    path = tmp_path / "steer.jsonl"
    text = (steered / "log" / "steer.jsonl").read_text()
    path.write_text(text + '{"frame": 900, "se')
    assert steer_file.read(str(path)) == steer_file.read(str(steered / "log" / "steer.jsonl"))


def test_a_file_that_is_not_there_is_refused(tmp_path):
    result = on_ranks(2, SCENE, tmp_path, 5, "dict(steering='/nowhere/steer.jsonl')")
    assert result.code == 1 and "No such file or directory, got '/nowhere/steer.jsonl'" in result.err
    assert result.err.count("*** motes") == 1, result.text
    result = command([sys.executable, "-m", "motes", "run", "-n", "2", "--steering", "nowhere", SCENE])
    assert (
        result.code == 2
        and "--steering must be the steer.jsonl of an earlier run, got 'nowhere'" in result.err
    )


def test_what_the_script_has_no_control_for_is_said_on_all_ranks(steered, tmp_path):
    path = tmp_path / "steer.jsonl"
    lines = (steered / "log" / "steer.jsonl").read_text().splitlines()
    path.write_text(lines[0] + '\n{"frame": 3, "set": {"rain": 1}}\n')
    result = on_ranks(3, SCENE, tmp_path, 5, f"dict(steering={str(path)!r})")
    assert result.code == 1 and "sets 'rain' before frame 3: this run has no such control" in result.err, (
        result.text
    )


def test_the_command_line_repeats_too(steered, tmp_path):
    argv = [sys.executable, "-m", "motes", "run", "-n", "2", "--steering", steered / "log" / "steer.jsonl"]
    assert command([*argv, SCENE, tmp_path, 25]).code == 0
    assert film(tmp_path) == film(steered)[:25]


DIFFERENT = """
import motes
world = motes.World(seed=1, progress="off", {live})
world.control("wind", 0.0, low=-1, high=1 + ({what} and world.rank == 1))
if not {what} and world.rank == 1:
    world.control("rain", True)
with world:
    for frame in world.frames(3):
        world.step()
"""


@pytest.mark.parametrize(
    ("live", "what"),
    [
        ("", True),
        ("live=motes.Live(0, paused=True)", False),
        pytest.param("", False, marks=pytest.mark.slow),
        pytest.param("live=motes.Live(0, paused=True)", True, marks=pytest.mark.slow),
    ],
)
def test_ranks_that_declare_other_controls_are_found(live, what):
    result = on_ranks(3, DIFFERENT.format(live=live, what=what))
    assert result.code == 1, result.text
    assert "different arguments: controls {" in result.err and "rank 1" in result.err, result.text


# --- together with stops, checkpoints and the script's own loops


def test_a_stop_ends_the_replay_where_it_ended_the_run(tmp_path):
    async def conversation() -> None:
        async with Client.of(await url_of(tmp_path)) as viewer:
            await viewer.until(lambda: viewer.state.get("frame", 0) >= 5)
            await viewer.say(set={"wind": 2})
            await viewer.until(lambda: viewer.state["frame"] >= 9)
            await viewer.say(stop=True)
            await viewer.until(lambda: bool(viewer.state.get("ended")))

    with Beside(conversation) as beside:
        result = run(3, tmp_path, 5000, LIVE, watch=beside.check)
    assert result.code == 0 and "motes: stopped by a viewer after frame" in result.err, result.text
    *_, last = rows(tmp_path, "steer.jsonl")
    done = len(film(tmp_path))
    assert last == {"frame": done, "stop": True} and 9 <= done < 5000
    again = new(tmp_path, "again")
    result = repeat(2, again, tmp_path, 5000)
    assert f"motes: stopped by the repeated run after frame {done} of 5000" in result.err, result.text
    assert film(again) == film(tmp_path)


@pytest.mark.parametrize("held", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_signal_is_a_stop_too_also_in_a_pause(tmp_path, held):
    async def conversation() -> None:
        async with Client.of(await url_of(tmp_path)) as viewer:
            await viewer.until(lambda: viewer.state.get("frame", 0) >= 5)
            await viewer.say(set={"wind": 2})
            await viewer.until(lambda: viewer.state["controls"]["wind"]["value"] == 2)
            if held:
                await viewer.say(pause=True)
                await viewer.until(lambda: viewer.state["paused"])
                await viewer.say(set={"dense": 60})  # no frame will use it
                await viewer.until(lambda: viewer.state["controls"]["dense"]["value"] == 60)
            kill_rank(1, tmp_path, signal.SIGTERM)
            await viewer.until(lambda: bool(viewer.state.get("ended")))

    with Beside(conversation) as beside:
        result = run(3, tmp_path, 5000, LIVE, mpirun, watch=beside.check)
    assert result.code == 143 and "motes: stopped by SIGTERM after frame" in result.err, result.text
    told = rows(tmp_path, "steer.jsonl")
    assert told[-1] == {"frame": len(film(tmp_path)), "stop": True}
    assert not any("dense" in row.get("set", {}) for row in told)
    again = new(tmp_path, "again")
    assert repeat(1, again, tmp_path, 5000).code == 0
    assert film(again) == film(tmp_path)


def test_a_steered_run_goes_on_from_its_checkpoint(tmp_path):
    """The run is killed in the middle, then steered again; the result is one film and replays as one."""
    saving = f"motes.Checkpoint({str(tmp_path / 'c')!r}, every=8)"
    options = f"dict(live=motes.Live(0, wait=True), pause_s=0.03, checkpoint={saving})"

    async def first() -> None:
        async with Client.of(await url_of(tmp_path)) as viewer:
            await viewer.until(lambda: viewer.state.get("frame", 0) >= 3)
            await viewer.say(set={"wind": 2, "dense": 40})
            await viewer.say(orbit=[0.5, 0.2])
            await viewer.until(
                lambda: viewer.state["frame"] >= 30 and any((tmp_path / "c").glob("frame-*[0-9]"))
            )
            await viewer.say(pause=True)
            await viewer.until(lambda: viewer.state["paused"])
            await viewer.say(set={"wind": -3})
            await viewer.until(lambda: viewer.state["controls"]["wind"]["value"] == -3)
            await viewer.say(step=1)  # perhaps beyond the last checkpoint
            at = viewer.state["frame"]
            await viewer.until(lambda: viewer.state["frame"] == at + 1)
            killing.append(at)
            await viewer.until(lambda: "closed" in viewer.state)

    def kill(launcher: int) -> None:
        beside.check(launcher)
        if killing and not killed:
            killed.append(launcher)
            kill_rank(2, tmp_path, signal.SIGKILL)

    killing: list[int] = []
    killed: list[int] = []
    with Beside(first) as beside:
        result = run(3, tmp_path, 100, options, mpirun, watch=kill)
    assert result.code != 0, result.text
    (tmp_path / "url").unlink()
    seen: dict[str, Any] = {}

    async def second() -> None:
        async with Client.of(await url_of(tmp_path)) as viewer:
            await viewer.until(lambda: viewer.state.get("frame", 0) > 0)
            seen.update(viewer.state)
            await viewer.until(lambda: viewer.state["frame"] >= 50)
            await viewer.say(set={"wind": 1})
            await viewer.until(lambda: bool(viewer.state.get("ended")))

    with Beside(second) as beside:
        result = run(2, tmp_path, 100, options, watch=beside.check)
    assert result.code == 0 and "motes: continues with frame" in result.err, result.text
    assert (
        seen["controls"]["dense"]["value"] == 40 and seen["controls"]["wind"]["value"] == 2 and seen["turned"]
    )
    assert [frame for frame, *_ in film(tmp_path)] == list(range(100))
    told = rows(tmp_path, "steer.jsonl")[1:]
    assert [row["set"]["wind"] for row in told if "wind" in row.get("set", {})] == [2.0, 1.0]
    again = new(tmp_path, "again")
    assert repeat(4, again, tmp_path, 100).code == 0
    assert film(again) == film(tmp_path)
    assert orders(again) == orders(tmp_path)


def test_a_replay_goes_on_from_its_checkpoint(steered, tmp_path):
    path = str(steered / "log" / "steer.jsonl")
    options = f"dict(steering={path!r}, checkpoint=motes.Checkpoint({str(tmp_path / 'c')!r}, every=20))"
    assert run(2, tmp_path, 50, options).code == 0
    result = run(3, tmp_path, 120, options, env={"MOTES_ANYWAY": "1"})  # another number of frames
    assert result.code == 0 and "continues with frame 50" in result.err, result.text
    assert film(tmp_path) == film(steered)[:120]


def test_a_loop_of_ones_own_is_steered_too(tmp_path):
    async def conversation() -> None:
        async with Client.of(await url_of(tmp_path)) as viewer:
            await viewer.until(lambda: viewer.state.get("frame", 0) >= 3)
            await viewer.say(set={"wind": 2})
            await viewer.say(pause=True)
            await viewer.until(lambda: viewer.state["paused"])
            await viewer.say(orbit=[0.4, 0])
            await viewer.say(pause=False)
            await viewer.until(
                lambda: viewer.state["controls"]["wind"]["value"] == 2 and viewer.state["turned"]
            )
            at = viewer.state["frame"]
            await viewer.until(lambda: viewer.state["frame"] > at + 5)
            await viewer.say(stop=True)
            await viewer.until(lambda: bool(viewer.state.get("ended")))

    options = "dict(live=motes.Live(0), own_loop=True, pause_s=0.01)"
    with Beside(conversation) as beside:
        result = run(3, tmp_path, 5000, options, watch=beside.check)
    assert result.code == 0, result.text
    again = new(tmp_path, "again")
    path = str(tmp_path / "log" / "steer.jsonl")
    assert run(2, again, 5000, f"dict(steering={path!r}, own_loop=True)").code == 0
    assert film(again) == film(tmp_path) and len(film(again)) > 5


@pytest.mark.slow
def test_a_replay_can_be_watched_and_paused_but_not_steered(steered, tmp_path):
    async def conversation() -> None:
        async with Client.of(await url_of(tmp_path)) as viewer:
            await viewer.until(lambda: viewer.state.get("frame", 0) >= 3)
            assert viewer.state["repeats"].endswith("steer.jsonl")
            await viewer.say(set={"wind": -5})
            await viewer.until(lambda: bool(viewer.refusals))
            assert "repeats the orders of" in viewer.refusals[0]
            await viewer.say(pause=True)
            await viewer.until(lambda: viewer.state["paused"])
            await viewer.say(step=1)
            await viewer.say(pause=False)
            await viewer.until(lambda: bool(viewer.state.get("ended")))

    with Beside(conversation) as beside:
        result = repeat(2, tmp_path, steered, 100, ", live=motes.Live(0, wait=True), pause_s=0.03")
        beside.check(0)
    assert result.code == 0, result.text
    assert film(tmp_path) == film(steered)[:100]


def test_a_recorded_scene_has_the_first_values(tmp_path):
    """`motes record` serves no viewers, whatever the script or the environment requests."""
    argv = ["record", SCENE, tmp_path, 5, "-o", tmp_path / "a.motes"]
    result = on_ranks(1, COMMAND_LINE, *argv, env={"MOTES_LIVE": "0,paused"})
    assert result.code == 0 and (tmp_path / "a.motes").exists(), result.text
    assert "live at" not in result.err
