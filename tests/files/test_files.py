"""Files are complete or absent."""

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


# --- drafts


def test_no_symbolic_link_is_followed(tmp_path, monkeypatch):
    victim = tmp_path / "victim"
    victim.write_bytes(b"precious")
    monkeypatch.setattr(files.os, "urandom", lambda count: bytes(count))
    (tmp_path / f".a.{bytes(8).hex()}.tmp").symlink_to(victim)
    with pytest.raises(FileExistsError):
        files.write_whole(tmp_path / "a", b"new")
    assert victim.read_bytes() == b"precious"


def test_the_draft_that_is_written_is_the_one_that_was_made(tmp_path):
    victim = tmp_path / "victim"
    victim.write_bytes(b"precious")
    with pytest.raises(OSError, match="symbolic link"), files.whole_path(tmp_path / "a") as draft:
        draft.unlink()
        draft.symlink_to(victim)
        files._open_made(str(draft), os.O_WRONLY | os.O_CREAT)
    assert victim.read_bytes() == b"precious"


def test_what_killed_writers_left_is_removed_and_what_living_ones_write_is_not(tmp_path):
    path = tmp_path / "a"
    (tmp_path / ".a.00112233445566ff.tmp").write_bytes(b"of a process that is gone")
    (tmp_path / ".b.00112233445566ff.tmp").write_bytes(b"another's")
    (tmp_path / ".a.00112233445566aa.tmp").symlink_to(tmp_path / "elsewhere")
    with files.whole_path(path) as living:
        with files.whole_path(path, remove_abandoned=True) as draft:
            draft.write_bytes(b"first")
        assert path.read_bytes() == b"first"
        assert living.exists()
        living.write_bytes(b"second")
    assert path.read_bytes() == b"second"
    assert sorted(os.listdir(tmp_path)) == [".a.00112233445566aa.tmp", ".b.00112233445566ff.tmp", "a"]


def test_what_a_killed_run_left_of_its_pictures_is_removed_by_the_next(tmp_path):
    script = (
        "import os, sys\nimport numpy as np\nfrom motes._picture import frame\n"
        "frame.files.os.replace = lambda *_: os.kill(os.getpid(), 9)\n"
        "frame.Frame(96, 4.0, np.zeros((8, 8, 3), np.uint8)).save(sys.argv[1])"
    )
    subprocess.run([sys.executable, "-c", script, str(tmp_path / "f0096.png")], timeout=20)
    assert len(os.listdir(tmp_path)) == 1
    (tmp_path / ".mine.tmp").touch()
    with files.whole_path(tmp_path / "living") as draft:
        again = "import sys\nimport numpy as np\nfrom motes._picture.frame import Frame\n"
        again += "for name in sys.argv[1:]: Frame(7, 0.0, np.zeros((8, 8, 3), np.uint8)).save(name)"
        names = [tmp_path / "f0007.png", tmp_path / "f0008.png"]
        subprocess.run([sys.executable, "-c", again, *map(str, names)], timeout=20, check=True)
        assert sorted(os.listdir(tmp_path)) == sorted([draft.name, ".mine.tmp", "f0007.png", "f0008.png"])


def test_a_draft_that_is_swept_away_before_it_is_locked_is_made_again(tmp_path, monkeypatch):
    lock = files.try_lock

    def late(file):
        monkeypatch.setattr(files, "try_lock", lock)
        files.sweep(tmp_path / "a")
        return lock(file)

    monkeypatch.setattr(files, "try_lock", late)
    files.write_whole(tmp_path / "a", b"content")
    assert (tmp_path / "a").read_bytes() == b"content"
    assert os.listdir(tmp_path) == ["a"]
