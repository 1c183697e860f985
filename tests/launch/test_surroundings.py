"""What a user's or a service's environment may lack: HOME, folders for temporary files, PATH."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from launching import Result, command

from motes._launch import starting
from motes._launch.files import folder_of_a_job
from motes._mpi import rank_process
from motes.errors import MotesError

SCRIPT = """
import os, motes
with motes.World(seed=1, progress="off") as world: world.step()
print("ran", world.size, os.environ["HOME"])
"""
RUN = ("-m", "motes", "run", "-n", "2")
HERE = {name: value for name, value in os.environ.items() if name not in rank_process.LAUNCHED}


def run(
    *arguments: str, before: tuple[str, ...] = (), without: tuple[str, ...] = (), **changes: str
) -> Result:
    """Run Python in this environment with changes; `before`: a program that starts it."""
    env = {**HERE, "PYTHONPATH": os.pathsep.join(sys.path), **changes}
    unset = [word for name in without for word in ("-u", name)]
    argv = [
        *before,
        shutil.which("env"),
        *unset,
        *(f"{name}={value}" for name, value in env.items() if name not in without),
    ]
    return command([*argv, sys.executable, *arguments], timeout=60)


def ran(*arguments: str, ranks: int, home: str, **changes: object) -> None:
    """Run the script and check what it printed, and that nobody said anything."""
    ended = run(*arguments, "-c", SCRIPT, **changes)
    assert ended.lines == [f"ran {ranks} {home}"] * ranks and ended.err == "", ended.text


def test_without_a_home_it_is_that_of_the_password_database():
    home = (
        str(Path("~").expanduser())
        if "HOME" not in os.environ
        else subprocess.run(
            [
                shutil.which("env"),
                "-u",
                "HOME",
                sys.executable,
                "-c",
                "import os; print(os.path.expanduser('~'))",
            ],
            capture_output=True,
            text=True,
            check=True,
        ).stdout.strip()
    )
    ran(ranks=1, home=home, without=("HOME",))
    ran(*RUN, ranks=2, home=home, without=("HOME", "USER", "LOGNAME"))
    ran(ranks=1, home=home, HOME="")
    report = json.loads(run("-m", "motes", "doctor", "--json", without=("HOME",)).out)
    assert report["hello"] == ["rank 0 of 2", "rank 1 of 2"] and report["mpirun fits library"] == "yes"


def test_users_without_an_entry_in_the_password_database_run_too():
    other = ("unshare", "--user", "--map-user=54321", "--map-group=54321")
    if (
        shutil.which("unshare") is None
        or subprocess.run([*other, "true"], capture_output=True).returncode != 0
    ):
        pytest.skip("no user namespaces here")
    ran(ranks=1, home="/", before=other, without=("HOME",))
    ran(*RUN, ranks=2, home="/", before=other, without=("HOME",))


@pytest.mark.parametrize("home", ["/nowhere/at/all", "/proc", "/dev/null"])
def test_the_home_may_be_missing_or_not_writable(home):
    ran(*RUN, ranks=2, home=home, HOME=home)


@pytest.mark.parametrize("survive", [(), ("--survive",)])
def test_the_folder_for_temporary_files_may_be_missing_or_have_a_long_name(tmp_path, survive):
    long = tmp_path / ("l" * 150)
    long.mkdir()
    for folder in (tmp_path / "missing", long):
        ran(*RUN, *survive, ranks=2, home=os.environ.get("HOME", "/"), TMPDIR=str(folder))
    assert list(long.iterdir()) == []


def test_the_folder_for_temporary_files_may_be_full(tmp_path):
    if (
        os.geteuid() != 0
        or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8k", "none", tmp_path]).returncode != 0
    ):
        pytest.skip("a file system of its own needs root")
    try:
        with (tmp_path / "all").open("wb", buffering=0) as file, pytest.raises(OSError, match="space"):
            while True:
                file.write(bytes(4096))
        ran(*RUN, ranks=2, home=os.environ.get("HOME", "/"), TMPDIR=str(tmp_path))
    finally:
        subprocess.run(["umount", tmp_path], check=True)


def test_no_folder_for_temporary_files_at_all_is_a_sentence(monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "nowhere"))
    with (
        pytest.raises(MotesError, match="no folder for temporary files: .*nowhere.*; set TMPDIR"),
        folder_of_a_job(),
    ):
        pass


def test_the_environments_own_mpirun_is_found_without_a_path():
    ran(*RUN, ranks=2, home=os.environ.get("HOME", "/"), PATH="/usr/bin:/bin")
    ran(*RUN, ranks=2, home=os.environ.get("HOME", "/"), without=("PATH",))


def test_why_a_launcher_does_not_say_its_version_is_told(monkeypatch, tmp_path):
    """The error may be of the surroundings, and the launcher the right one."""
    path = tmp_path / "mpirun"
    path.write_text("#!/bin/sh\necho 'it lacks something' >&2\nexit 3\n")
    path.chmod(0o755)
    monkeypatch.delenv("MOTES_MPIRUN", raising=False)
    monkeypatch.setattr(starting, "_launchers", lambda: [str(path)])
    with pytest.raises(MotesError, match=rf"found: {path} \(--version: it lacks something\)"):
        starting.find_mpirun()
    path.write_text("#!/bin/sh\nexit 3\n")
    starting._asked.cache_clear()
    with pytest.raises(MotesError, match=rf"found: {path} \(--version: exit code 3\)"):
        starting.find_mpirun()
