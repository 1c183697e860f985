"""Jobs that run random scripts side by side, to compare their results.

Jobs of 1, 2, 3 and 5 ranks run side by side and take each script that hypothesis draws, so a script costs
milliseconds, and hypothesis can minimise a failing one. The printed script runs by itself, with note = print.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, settings
from launching import Hang, Result, mpirun
from random_lists import FRAMES
from same_bits import widths

PLAYER = Path(__file__).parents[1] / "scenes" / "list_player.py"
LIMIT_S = 60  # for one script


@dataclass
class Job:
    """A running job that takes scripts."""

    folder: Path
    name: str
    size: int
    env: dict[str, str]
    first: int
    cancelled: bool = False
    ended: list[Result | BaseException] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Start it."""
        self.thread = threading.Thread(target=self._run)
        self.thread.start()

    def _run(self) -> None:
        def watch(_: int) -> None:
            if self.cancelled:
                raise Hang("cancelled")

        try:
            argv = (self.folder, self.name, self.first)
            env = {"MOTES_STALL_S": "30", **self.env}
            self.ended.append(mpirun(self.size, PLAYER, *argv, timeout=7200, env=env, watch=watch))
        except BaseException as error:
            self.ended.append(error)

    def answer(self, number: int) -> str:
        """Wait for the job's answer to a script."""
        path, limit = self.folder / f"{number}.{self.name}", time.monotonic() + LIMIT_S
        while not path.exists():
            if not self.thread.is_alive() and not path.exists():
                ended = self.ended[0]
                return ended.text if isinstance(ended, Result) else repr(ended)
            if time.monotonic() > limit:
                self.stop()
                return f"no answer within {LIMIT_S} s"
            time.sleep(0.002)
        return path.read_text()

    def stop(self) -> None:
        """End it at once."""
        self.cancelled = True
        self.thread.join()


class Jobs:
    """The jobs to compare; one that has ended is started again."""

    def __init__(self, folder: Path, kinds: dict[str, tuple[int, dict[str, str]]]) -> None:
        """Take the jobs' names, sizes and environments."""
        self.folder, self.kinds, self.number = folder, kinds, 0
        self.running: dict[str, Job] = {}

    def ask(self, text: str) -> dict[str, str]:
        """Let every job run a script."""
        for name, (size, env) in self.kinds.items():
            if name not in self.running or not self.running[name].thread.is_alive():
                self.running[name] = Job(self.folder, name, size, env, self.number)
        draft = self.folder / "draft.txt"
        draft.write_text(text)
        draft.rename(self.folder / f"{self.number}.txt")
        answers = {name: job.answer(self.number) for name, job in self.running.items()}
        self.number += 1
        return answers

    def compare(self, text: str) -> None:
        """Fail if the jobs' answers differ or are missing."""
        answers = self.ask(text)
        lines = answers[next(iter(answers))].splitlines()
        bad = [
            name for name, answer in answers.items() if answer.splitlines() != lines or len(lines) != FRAMES
        ]
        if bad:
            shown = "\n".join(f"--- {name}\n{answer}" for name, answer in answers.items())
            pytest.fail(f"{bad} differ from {next(iter(answers))}\n{text}\n{shown}", pytrace=False)


MakeJobs = Callable[[dict[str, tuple[int, dict[str, str]]]], Jobs]


@pytest.fixture
def jobs(tmp_path: Path) -> Iterator[MakeJobs]:
    """Return a function that starts jobs; they end with the test."""
    made: list[Jobs] = []

    def make(kinds: dict[str, tuple[int, dict[str, str]]]) -> Jobs:
        made.append(Jobs(tmp_path, kinds))
        return made[-1]

    yield make
    (tmp_path / "stop").touch()
    for one in made:
        for job in one.running.values():
            job.thread.join(20)
            job.stop()


def searched(examples: int) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Let hypothesis draw this many scripts, the same ones each time."""
    return settings(
        max_examples=examples,
        derandomize=True,
        deadline=None,
        database=None,
        phases=(Phase.generate, Phase.shrink),
        suppress_health_check=list(HealthCheck),
    )


def threads(count: int) -> dict[str, str]:
    """Return the environment of jobs whose ranks have this many threads, which share even a few particles."""
    return {"MOTES_THREADS": str(count), "MOTES_GRAIN": "64"}


def by_width() -> dict[str, dict[str, str]]:
    """Return environments that each choose an instruction set."""
    return {name: {"MOTES_SIMD": name} for name in widths()}
