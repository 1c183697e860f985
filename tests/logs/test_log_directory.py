"""A log directory belongs to one run: earlier logs are moved aside, other directories are refused."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from launching import said
from standing import on_ranks

from motes._io import files
from motes._run.log_directory import LogDirectory
from motes.errors import ArgumentError, LogError


def earlier_log(folder: Path, **more: str) -> Path:
    """Create the files of an earlier run."""
    folder.mkdir()
    run = {"schema": 1, "argv": ["x.py"]}
    files = {
        "run.json": json.dumps(run),
        "load.jsonl": "",
        "frames.jsonl": "",
        "spans.r0007.jsonl": "old",
        **more,
    }
    for name, text in files.items():
        (folder / name).write_text(text)
    return folder


def names(folder: Path) -> set[str]:
    """List a directory, without its lock."""
    return {file.name for file in folder.iterdir()} - {".lock"}


# --- in this process


def test_a_new_or_empty_directory_is_claimed(tmp_path):
    (tmp_path / "empty").mkdir()
    for name in ("new/deep", "empty"):
        claimed = LogDirectory.claim(tmp_path / name)
        assert claimed.moved is None
        assert names(tmp_path / name) == set()
        claimed.release()


def test_earlier_logs_are_moved_aside_one_after_another(tmp_path):
    today = tmp_path / "today"
    for number in (1, 2, 3):
        earlier_log(today, **{"events.jsonl": str(number)})
        claimed = LogDirectory.claim(today)
        assert claimed.moved == tmp_path / f"today.{number}"
        assert names(today) == set()
        claimed.release()
        (today / ".lock").unlink()
        today.rmdir()
    for number in (1, 2, 3):
        aside = tmp_path / f"today.{number}"
        assert (aside / "events.jsonl").read_text() == str(number)
        assert (aside / "spans.r0007.jsonl").read_text() == "old"


def test_other_files_stay_where_they_are(tmp_path):
    today = earlier_log(tmp_path / "today", **{"film.mp4": "mine"})
    claimed = LogDirectory.claim(today)
    assert names(today) == {"film.mp4"}
    assert names(tmp_path / "today.1") == {"run.json", "load.jsonl", "frames.jsonl", "spans.r0007.jsonl"}
    with pytest.raises(ArgumentError, match="is writing to this one"):
        LogDirectory.claim(today)
    claimed.release()
    LogDirectory.claim(today).release()  # its run left no run.json
    assert names(today) == {"film.mp4"}
    assert not (tmp_path / "today.2").exists()


def test_the_folder_in_which_the_script_works_stays_its_folder(tmp_path, monkeypatch):
    today = earlier_log(tmp_path / "today")
    monkeypatch.chdir(today)
    LogDirectory.claim(".").release()
    Path("picture.png").touch()
    assert names(today) == {"picture.png"}
    assert "run.json" in names(tmp_path / "today.1")


@pytest.mark.parametrize(
    "content",
    [
        {"notes.txt": "mine"},
        {"run.json": "mine"},
        {"run.json": '{"schema": 1}'},
        {"run.json": "[" * 100_000},
        {"frames.jsonl": "mine"},
        {".hidden": "mine"},
        {"load.jsonl": "rows", "frames.jsonl": "rows", "film.mp4": "mine"},
    ],
    ids=lambda content: "-".join(f"{name}={text[:5]}" for name, text in content.items()),
)
def test_what_is_no_log_is_refused_and_left_alone(tmp_path, content):
    for name, text in content.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(ArgumentError, match="log must be a new or empty directory, or an earlier run's log"):
        LogDirectory.claim(tmp_path)
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == content


def test_a_run_that_was_killed_before_run_json_left_a_log(tmp_path):
    today = earlier_log(tmp_path / "today")
    (today / "run.json").unlink()
    assert LogDirectory.claim(today).moved == tmp_path / "today.1"


def test_a_directory_that_cannot_be_made_says_why(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(LogError, match=r"the log directory .*/file cannot be created: File exists"):
        LogDirectory.claim(tmp_path / "file")
    with pytest.raises(LogError, match=r"/file/log cannot be created: Not a directory"):
        LogDirectory.claim(tmp_path / "file" / "log")


def test_the_lock_ends_with_its_owner(tmp_path):
    code = (
        "import sys, time; from motes._run.log_directory import LogDirectory\n"
        "claimed = LogDirectory.claim(sys.argv[1]); print('claimed', flush=True); time.sleep(60)"
    )
    owner = subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    try:
        assert owner.stdout is not None
        assert owner.stdout.readline() == "claimed\n"
        with pytest.raises(
            ArgumentError, match=rf"the run of process {owner.pid} on .* is writing to this one"
        ):
            LogDirectory.claim(tmp_path)
    finally:
        owner.send_signal(signal.SIGKILL)
        owner.communicate()
    LogDirectory.claim(tmp_path).release()


def test_only_one_of_many_simultaneous_runs_gets_it(tmp_path):
    for turn in range(20):
        today = earlier_log(tmp_path / f"today-{turn}")
        won: list[LogDirectory] = []
        lost: list[BaseException] = []
        go = threading.Barrier(8)

        def compete(today=today, go=go, won=won, lost=lost):
            go.wait()
            try:
                won.append(LogDirectory.claim(today))
            except ArgumentError as error:
                lost.append(error)

        threads = [threading.Thread(target=compete) for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert (len(won), len(lost)) == (1, 7)
        assert names(today) == set()
        assert "run.json" in names(tmp_path / f"today-{turn}.1")
        assert not (tmp_path / f"today-{turn}.2").exists()
        won[0].release()


def test_a_directory_that_is_moved_while_it_is_looked_at_is_made_again(tmp_path, monkeypatch):
    today = earlier_log(tmp_path / "today")
    mkdir = os.mkdir

    def too_late(path, mode=0o777):
        try:
            mkdir(path, mode)
        except FileExistsError:
            if not (tmp_path / "moved").exists():
                today.rename(tmp_path / "moved")
            raise

    monkeypatch.setattr(os, "mkdir", too_late)
    LogDirectory.claim(today).release()
    assert names(today) == set() and "run.json" in names(tmp_path / "moved")


def test_a_file_system_without_locks_is_reported(tmp_path, monkeypatch, capsys):
    def no_locks(*_):
        raise OSError(37, "No locks available")

    monkeypatch.setattr(files.fcntl, "flock", no_locks)
    LogDirectory.claim(tmp_path).release()
    assert "is on a file system without locks (No locks available)" in capsys.readouterr().err


# --- as jobs


@pytest.mark.parametrize("ranks", [2, 3])
def test_all_ranks_raise_where_the_log_is_refused(tmp_path, ranks):
    (tmp_path / "notes.txt").write_text("mine")
    caught = (
        "import motes, os, sys\n"
        f"world = motes.World(seed=1, log={str(tmp_path)!r}, progress='off')\n"
        "meet = motes._world.handshake.meet\n"
        "def told(*arguments):\n"
        "    try: return meet(*arguments)\n"
        "    except motes.ArgumentError as error:\n"
        "        os.write(1, f'{world.rank}: {error}\\n'.encode()); raise\n"
        "motes._world.handshake.meet = told\n"
        "with world: pass\n"
    )
    result = on_ranks(ranks, caught, timeout=30)
    allowed = "log must be a new or empty directory, or an earlier run's log (this one holds 'notes.txt'"
    assert sorted(line[: len(allowed) + 3] for line in result.out.splitlines()) == [
        f"{rank}: {allowed}" for rank in range(ranks)
    ]
    assert len(said(result.err, "*** motes: ")) == 1, result.text
    assert result.code == 1
    assert [file.name for file in tmp_path.iterdir()] == ["notes.txt"]
