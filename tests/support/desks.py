"""`motes live` for tests: its page, and its end."""

from __future__ import annotations

import contextlib
import os
import re
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

from launching import kill_session

START_S = 60


class LiveCommand:
    """The command in progress."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self.process = process
        self.lines: list[str] = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.lines.append(line)

    @property
    def url(self) -> str:
        """The page's address, once the command has printed it."""
        limit = time.monotonic() + START_S
        while time.monotonic() < limit:
            for line in list(self.lines):
                if found := re.search(r"motes: live at (\S+)", line):
                    return found[1]
            assert self.process.poll() is None, "".join(self.lines)
            time.sleep(0.02)
        raise AssertionError("the command prints no address")

    def ended(self, seconds: float = 30) -> int:
        """Wait for the end of the command, and return its exit code."""
        code = self.process.wait(seconds)
        self._reader.join(5)
        return code


@contextlib.contextmanager
def live(
    script: Path, *arguments: object, ranks: int = 2, options: tuple[str, ...] = ()
) -> Iterator[LiveCommand]:
    """Start `motes live` with a script, and end it with all its processes."""
    argv = [sys.executable, "-m", "motes", "live", "-n", str(ranks), "--port", "0", *options, str(script)]
    process = subprocess.Popen(
        [*argv, *map(str, arguments)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, "MOTES_PROGRESS": "off"},
    )
    command = LiveCommand(process)
    try:
        yield command
    finally:
        if process.poll() is None:
            process.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(15)
        kill_session(process.pid)
        command.ended()
        assert process.stderr is not None
        process.stderr.close()
