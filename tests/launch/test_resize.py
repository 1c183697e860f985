"""`motes resize`: another number of ranks in the middle of a run."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

import motes

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(motes.__file__).parents[1])}
SCRIPT = """
import sys, time
import motes
from motes.shapes import Box

frames, pause, directory = int(sys.argv[1]), float(sys.argv[2]), sys.argv[3]
checkpoint = motes.Checkpoint(directory, every=1000) if directory else None
camera = motes.Camera((0, 0, 8), (0, 0, 0))
world = motes.World(
    seed=7, space=(-3, 3), log="log", digest=True, checkpoint=checkpoint, progress="off",
    renderer=motes.Renderer(64, 48, camera=camera),
)
snow = world.system("snow")
with world, motes.Movie("snow.mp4") as film, motes.Export("particles") as particles:
    for frame in world.frames(frames):
        snow.source(Box((-2, -1, -1), (2, 2, 1)), rate=2400)
        snow.random_acceleration((1, 1, 1))
        snow.move()
        film.write(world.render())
        particles.write(world)
        time.sleep(pause)
"""
FRAMES = 30
TOLD_S = 60


def started(directory: Path, ranks: int, *arguments: object) -> subprocess.Popen[str]:
    """Start SCRIPT under `motes run` in a directory."""
    (directory / "script.py").write_text(SCRIPT)
    argv = [sys.executable, "-m", "motes", "run", "-n", ranks, "script.py", *arguments]
    return subprocess.Popen(
        list(map(str, argv)), cwd=directory, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True
    )


def resize(directory: Path, ranks: int, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Call `motes resize`."""
    argv = [sys.executable, "-m", "motes", "resize", "log", "-n", str(ranks), *arguments]
    return subprocess.run(
        argv, cwd=directory, env=ENVIRONMENT, capture_output=True, text=True, timeout=TOLD_S
    )


def rows_of(directory: Path) -> list[dict[str, Any]]:
    """Return the complete rows of frames.jsonl."""
    path = directory / "log" / "frames.jsonl"
    text = path.read_text() if path.exists() else ""
    return [json.loads(line) for line in text.splitlines(keepends=True) if line.endswith("\n")]


def wait_for_frame(directory: Path, frame: int) -> None:
    """Wait until the log has that many frames, and a run that could be asked."""
    deadline = time.monotonic() + TOLD_S
    while len(rows_of(directory)) < frame and time.monotonic() < deadline:
        time.sleep(0.05)


def test_two_five_three_and_one_ranks_make_one_film(tmp_path: Path) -> None:
    """Log, film and export are those of a run on one rank."""
    (whole := tmp_path / "whole").mkdir()
    alone = started(whole, 1, FRAMES, 0, "checkpoints")
    _, said = alone.communicate(timeout=TOLD_S)
    assert alone.returncode == 0, said
    (parts := tmp_path / "parts").mkdir()
    run = started(parts, 2, FRAMES, 0.3, "checkpoints")
    wait_for_frame(parts, 3)
    for ranks in (5, 3, 1):
        asked = resize(parts, ranks)
        assert asked.returncode == 0, asked.stderr
    _, said = run.communicate(timeout=120)
    assert run.returncode == 0, said
    for text in ("5 ranks", "3 ranks", "1 rank"):
        assert f"motes run: goes on with {text} when this frame is done" in said
    facts = json.loads((parts / "log" / "run.json").read_text())
    assert [len(part["ranks"]) for part in facts["continued"]] == [5, 3, 1]
    ours, theirs = rows_of(parts), rows_of(whole)
    assert [row["frame"] for row in ours] == list(range(FRAMES))
    for name in ("particles_digest", "image_sha256", "particles"):
        assert [row[name] for row in ours] == [row[name] for row in theirs]
    mine, other = (motes.open_particles(place / "particles") for place in (parts, whole))
    assert mine.frames == other.frames == tuple(range(FRAMES)) and mine.finished
    assert (mine[-1].position == other[-1].position).all()
    assert frames_of_film(parts / "snow.mp4") == FRAMES


def frames_of_film(path: Path) -> int:
    """Count the frames of a film."""
    av = pytest.importorskip("av")
    with av.open(str(path)) as film:
        return sum(1 for _ in film.decode(video=0))


def test_what_cannot_be_resized_says_so_and_goes_on(tmp_path: Path) -> None:
    """No checkpoints; a size that cannot be started; a run that has ended; a directory without a log."""
    assert "RUN must be the directory of a run's log" in resize(tmp_path, 3).stderr
    run = started(tmp_path, 2, FRAMES, 0.2, "")
    wait_for_frame(tmp_path, 2)
    refused = resize(tmp_path, 3)
    assert refused.returncode == 2
    assert "the run has no checkpoints to go on from: give its world World(checkpoint=...)" in refused.stderr
    run.send_signal(signal.SIGUSR2)
    _, said = run.communicate(timeout=TOLD_S)
    assert run.returncode == 0 and "it goes on with 2 ranks: the run has no checkpoints" in said
    assert [row["frame"] for row in rows_of(tmp_path)] == list(range(FRAMES))
    assert "has ended: start it again with the number of ranks that you want" in resize(tmp_path, 3).stderr
    facts = json.loads((tmp_path / "log" / "run.json").read_text())
    (tmp_path / "log" / "run.json").write_text(json.dumps({**facts, "launcher": None}))
    assert "was started without a launcher of motes" in resize(tmp_path, 3).stderr


def test_a_signal_alone_restarts_with_as_many_ranks(tmp_path: Path) -> None:
    """So does a size that the machine cannot start, as far as the run is concerned: it goes on as it was."""
    run = started(tmp_path, 2, 12, 0.3, "checkpoints")
    wait_for_frame(tmp_path, 2)
    refused = resize(tmp_path, 10_000_000)
    assert refused.returncode == 2 and "n must be in 1.." in refused.stderr
    assert "hosts must be" in resize(tmp_path, 2, "--hosts=-oProxyCommand=x").stderr
    time.sleep(2.1)  # until then, a signal may be the refused request's
    os.kill(run.pid, signal.SIGUSR2)
    _, said = run.communicate(timeout=TOLD_S)
    assert run.returncode == 0 and "goes on with 2 ranks when this frame is done" in said
    facts = json.loads((tmp_path / "log" / "run.json").read_text())
    assert [len(part["ranks"]) for part in facts["continued"]] == [2]
    assert [row["frame"] for row in rows_of(tmp_path)] == list(range(12))
