"""Files are whole or not there."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

from motes._io import files


def test_bytes_arrive_and_directories_appear(tmp_path):
    path = tmp_path / "new" / "deep" / "a.bin"
    files.write_whole(path, b"abc")
    assert path.read_bytes() == b"abc"
    assert os.listdir(path.parent) == ["a.bin"]


def test_a_function_writes_into_the_open_file(tmp_path):
    files.write_whole(tmp_path / "a", lambda file: file.write(b"abc"))
    assert (tmp_path / "a").read_bytes() == b"abc"


def test_text_mode(tmp_path):
    with files.whole_file(tmp_path / "a.json", "w", encoding="utf-8") as file:
        file.write("ü")
        assert not (tmp_path / "a.json").exists()
    assert (tmp_path / "a.json").read_text("utf-8") == "ü"


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "a"
    files.write_whole(path, b"old")
    with pytest.raises(KeyError), files.whole_file(path) as file:
        file.write(b"new")
        raise KeyError
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["a"]


def test_a_new_file_is_as_readable_as_any_other(tmp_path):
    files.write_whole(tmp_path / "a", b"")
    (tmp_path / "b").touch()
    assert (tmp_path / "a").stat().st_mode == (tmp_path / "b").stat().st_mode


def test_only_writing_modes(tmp_path):
    with pytest.raises(ValueError, match="'a'"), files.whole_file(tmp_path / "a", "a"):
        pass


def test_a_killed_writer_leaves_the_old_file(tmp_path):
    path = tmp_path / "a"
    files.write_whole(path, b"old")
    script = (
        "import os, sys\nfrom motes._io import files\n"
        "def write(file): file.write(b'new'); file.flush(); os.kill(os.getpid(), 9)\n"
        "files.write_whole(sys.argv[1], write)"
    )
    ended = subprocess.run([sys.executable, "-c", script, str(path)], timeout=20)
    assert ended.returncode == -signal.SIGKILL
    assert path.read_bytes() == b"old"
