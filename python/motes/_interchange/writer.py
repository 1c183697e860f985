"""The thread that writes an export's files while the run continues."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from .formats import Place
from .manifest import Part

__all__ = ["FrameJob", "Writer"]

MOST_FRAMES = 2  # queued or being written: their particles are in memory
_ABANDON_S = 1.0  # how long `end` waits for the file being written


@dataclass
class FrameJob:
    """The particles of one rank in one frame, of all systems."""

    frame: int
    time: float
    rank: int | None
    systems: list[tuple[int, str, Mapping[str, NDArray[Any]], Any]]
    """Index in the manifest, stem and columns of each system, and how it is drawn, if that is written."""


class Writer:
    """Writes frames in order in a background thread, and keeps its errors until `take` raises them."""

    def __init__(self, place: Place) -> None:
        """Take the place; the thread starts with the first job."""
        self._place = place
        self._jobs: deque[FrameJob] = deque()
        self._under_way = 0
        self._publish: Callable[[], None] | None = None
        self._unpublished = 0  # frames that the waiting call will publish
        self._written: list[tuple[int, Part]] = []
        self._error: BaseException | None = None
        self._ends = False
        self._changed = threading.Condition()
        self._thread: threading.Thread | None = None

    def put(self, job: FrameJob) -> None:
        """Queue a frame. Call `has_room` first, on the script's thread."""
        self._place.format.begin()
        with self._changed:
            self._jobs.append(job)
            self._under_way += 1
        self._wake()

    def publish(self, call: Callable[[], None]) -> None:
        """Queue a call, in place of one that is still waiting. Call `has_room` first."""
        with self._changed:
            self._publish = call
            self._unpublished += 1
        self._wake()

    def fail(self, error: BaseException) -> None:
        """Keep an error for `take`."""
        with self._changed:
            self._error = self._error or error
            self._changed.notify_all()

    def has_room(self, timeout_s: float) -> bool:
        """Wait until there is room for a frame or the thread has failed; return False after the timeout."""
        with self._changed:
            return self._changed.wait_for(
                lambda: self._error is not None or max(self._under_way, self._unpublished) < MOST_FRAMES,
                timeout_s,
            )

    def is_idle(self, timeout_s: float) -> bool:
        """Wait until all jobs are done or the thread has failed; return False after the timeout."""
        with self._changed:
            return self._changed.wait_for(
                lambda: self._error is not None or not (self._under_way or self._publish), timeout_s
            )

    def check(self) -> None:
        """Raise the thread's error, if there is one."""
        with self._changed:
            if self._error is not None:
                raise self._error

    def take(self) -> list[tuple[int, Part]]:
        """Return the parts written since the last call, each with its frame; raise the thread's error."""
        self.check()
        with self._changed:
            written, self._written = self._written, []
            return written

    def end(self) -> None:
        """Drop queued jobs, and end the thread after the file that it is writing."""
        with self._changed:
            self._ends = True
            self._jobs.clear()
            self._publish = None
            self._changed.notify_all()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(_ABANDON_S)

    def _wake(self) -> None:
        with self._changed:
            if self._thread is None:
                # A daemon, since Python waits for other threads: that would keep a failed rank alive, and so
                # the whole job.
                name = f"export {self._place.path.name}"
                self._thread = threading.Thread(target=self._work, name=name, daemon=True)
                self._thread.start()
            self._changed.notify_all()

    def _work(self) -> None:
        try:
            while (task := self._next()) is not None:
                task()
        except BaseException as error:
            self.fail(error)

    def _next(self) -> Callable[[], None] | None:
        with self._changed:
            self._changed.wait_for(lambda: self._ends or self._jobs or self._publish)
            if self._ends:
                return None
            if self._publish is not None:
                return self._run_publish
            job = self._jobs.popleft()
        return lambda: self._write(job)

    def _run_publish(self) -> None:
        with self._changed:
            call, pending = self._publish, self._unpublished
        if call is not None:
            call()
        with self._changed:
            self._unpublished -= pending
            if self._publish is call:
                self._publish = None
            self._changed.notify_all()

    def _write(self, job: FrameJob) -> None:
        parts = []
        for number, stem, columns, drawn in job.systems:
            if self._ends:
                return
            file = self._place.file(stem, job.frame, job.rank)
            size = self._place.write_part(file, columns, frame=job.frame, time=job.time, drawn=drawn)
            parts.append((job.frame, Part(number, job.rank, file, len(columns["id"]), size)))
        job.systems.clear()  # frees their memory for the next frame
        with self._changed:
            self._written += parts
            self._under_way -= 1
            self._changed.notify_all()
