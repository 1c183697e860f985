"""The script that the desk shows: notices when it is saved, and tries it before it replaces a run."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from .._io import files
from .job import Job

__all__ = ["Script"]

LOOK_S = 0.25
REHEARSAL_S = 60.0
FRAMES = 2


class Script:
    """A script and its arguments."""

    def __init__(self, path: Path, arguments: Sequence[str]) -> None:
        """Take the script as it is now."""
        self.path = path
        self._arguments = arguments
        self._stamp = self._look()
        self._digest = self._read()
        self._started: bytes | None = None  # the text of the run that was started last
        self._good: bytes | None = None  # the text of the last run that got somewhere
        self._copy: Path | None = None

    # --- the last good text

    def starts(self) -> Path:
        """Note that a run of the script starts; return its path."""
        self.forget()
        with contextlib.suppress(OSError):
            self._started = self.path.read_bytes()
        return self.path

    def works(self) -> None:
        """Note that the run has reached the frame that it was meant to reach."""
        self._good = self._started

    def starts_good(self) -> Path | None:
        """Write the last good text beside the script, where it finds its files; None: there is none."""
        self.forget()
        if self._good is None or self._good == self._started:
            return None
        copy = self.path.with_name(f".{self.path.stem}.{os.getpid()}.py")
        try:
            files.write_whole(copy, self._good)
        except OSError:
            return None
        self._copy, self._started = copy, self._good
        return copy

    def forget(self) -> None:
        """Remove the copy of the last good text."""
        if self._copy is not None:
            self._copy.unlink(missing_ok=True)
            self._copy = None

    # --- what is saved

    async def saved(self) -> None:
        """Wait until the script has another content."""
        while True:
            await asyncio.sleep(LOOK_S)
            stamp = self._look()
            if stamp == self._stamp or stamp is None:
                continue
            await asyncio.sleep(LOOK_S / 2)
            if self._look() != stamp:  # it is still being written
                continue
            self._stamp = stamp
            digest = self._read()
            if digest is not None and digest != self._digest:
                self._digest = digest
                return

    async def rehearse(self) -> str:
        """Run the first frames in one process that writes no files; return what is wrong, or ""."""
        argv = [sys.executable, "-m", "motes", "run", "-n", "1", str(self.path), *self._arguments]
        job = Job(
            argv, {"MOTES_REHEARSAL": str(FRAMES), "MOTES_LIVE": "off", "MOTES_PROGRESS": "off"}, _Nobody()
        )
        playing = asyncio.create_task(job.run(echo=False))
        try:
            code = await asyncio.wait_for(asyncio.shield(playing), REHEARSAL_S)
        except TimeoutError:
            await job.end()
            late = f"has not finished its first {FRAMES} frames within {REHEARSAL_S:g} s"
            return f"{self.path.name} as saved {late}; the run goes on with the script before it"
        finally:
            with contextlib.suppress(Exception):
                await job.end()
        if code == 0:
            return ""
        fails = f"{self.path.name} as saved fails; the run goes on with the script before it"
        return "\n".join([fails, *job.last_words])

    def _look(self) -> tuple[int, int, int] | None:
        try:
            found = self.path.stat()
        except OSError:  # an editor is replacing it
            return None
        return found.st_mtime_ns, found.st_size, found.st_ino

    def _read(self) -> bytes | None:
        try:
            return hashlib.sha256(self.path.read_bytes()).digest()
        except OSError:
            return None


class _Nobody:
    """Hears nothing."""

    def joined(self, job: Job) -> None:
        """Do nothing."""

    def said(self, job: Job, message: object) -> None:
        """Do nothing."""

    def shown(self, job: Job, picture: bytes) -> None:
        """Do nothing."""

    def printed(self, job: Job) -> None:
        """Do nothing."""
