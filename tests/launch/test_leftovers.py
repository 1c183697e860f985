"""What a killed job leaves behind: its launcher removes its folders, and the memory that its ranks shared."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from launching import command, kill_session, python

from motes._launch import files

SHARED = Path("/dev/shm")
pytestmark = pytest.mark.skipif(not os.access(SHARED, os.W_OK), reason="no folder for shared memory here")
MAPPED = """
import pathlib, sys, time
import motes
with motes.World(seed=1, progress="off") as world:
    world.step()
    maps = pathlib.Path("/proc/self/maps").read_text().splitlines()
    print(*{line.split()[5] for line in maps if "/dev/shm/" in line}, flush=True)
    time.sleep(float(sys.argv[1]))
"""


def test_a_process_without_a_launcher_shares_no_memory():
    assert python(MAPPED, 0).out == "\n"


def test_the_launcher_of_a_job_removes_what_a_killed_mpirun_leaves(tmp_path):
    """Other jobs' memory stays: here another one runs meanwhile."""
    argv = [sys.executable, "-m", "motes", "run", "-n", "2", "-c", MAPPED, "60"]
    jobs = [
        subprocess.Popen(
            argv, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, start_new_session=True
        )
        for _ in range(2)
    ]
    try:
        mapped = []
        for job in jobs:
            assert job.stdout is not None
            mapped.append({path for _ in range(2) for path in job.stdout.readline().split()})
        assert all(mapped) and all(os.path.exists(path) for path in mapped[0] | mapped[1])
        mpirun = int(Path(f"/proc/{jobs[0].pid}/task/{jobs[0].pid}/children").read_text().split()[0])
        os.kill(mpirun, signal.SIGKILL)
        assert jobs[0].wait(20) == 137
        assert not any(os.path.exists(path) for path in mapped[0])
        assert all(os.path.exists(path) for path in mapped[1])
        jobs[1].send_signal(signal.SIGHUP)
        jobs[1].wait(20)
        assert not any(os.path.exists(path) for path in mapped[1])
    finally:
        for job in jobs:
            kill_session(job.pid)
            job.communicate()


HOLD = """
import sys, tempfile, time
from motes._launch import files
tempfile.tempdir = files._SHARED_MEMORY = sys.argv[1]
with files.folder_of_a_job() as (folder, _):
    print(folder, flush=True)
    time.sleep(60)
"""


def test_the_next_launcher_removes_the_folders_of_killed_ones(tmp_path, monkeypatch):
    monkeypatch.setattr(files.tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(files, "_SHARED_MEMORY", str(tmp_path))
    stranger = tmp_path / "motes-job-link"
    stranger.symlink_to(tmp_path / "elsewhere")
    argv = [sys.executable, "-c", HOLD, str(tmp_path)]
    first, second = (subprocess.Popen(argv, stdout=subprocess.PIPE, text=True) for _ in range(2))
    with first, second:
        assert first.stdout is not None and second.stdout is not None
        killed, running = Path(first.stdout.readline().strip()), Path(second.stdout.readline().strip())
        (killed / "segment").write_text("memory")
        first.kill()
        first.wait()
        assert len(list(tmp_path.glob("motes-job-*"))) == 5, "two of each, and the link"
        with files.folder_of_a_job() as (own, variables):
            assert running.is_dir() and not killed.exists() and stranger.is_symlink()
            assert (
                set(variables.values()) <= {str(path) for path in tmp_path.iterdir()}
                and own in variables.values()
            )
            assert len(list(tmp_path.glob("motes-job-*"))) == 5, "two of each that runs, and the link"
        assert running.is_dir() and not Path(own).exists()
        second.kill()


def test_a_user_may_choose_where_ranks_share_memory(tmp_path):
    env = {"OMPI_MCA_btl_sm_backing_directory": str(tmp_path)}
    script = MAPPED.replace("/dev/shm/", f"{tmp_path}/")
    ended = command([sys.executable, "-m", "motes", "run", "-n", "2", "-c", script, "0"], env=env)
    assert all(str(tmp_path) in line for line in ended.lines)


def test_launchers_that_start_at_once_do_not_remove_each_others_folders(tmp_path, monkeypatch):
    """A folder has no lock at first. If it is removed then, its maker makes another one."""
    swept = []

    def between(**options: str) -> str:
        folder = make(**options)
        if len(swept) < 2:
            swept.append(folder)
            files._sweep(str(tmp_path))
        return folder

    make = files.tempfile.mkdtemp
    monkeypatch.setattr(files.tempfile, "mkdtemp", between)
    with files._own_folder(str(tmp_path)) as own:
        assert len(swept) == 2 and own not in swept and Path(own).is_dir()
    assert list(tmp_path.iterdir()) == []
