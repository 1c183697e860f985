"""The effects among the examples, and a small run of each.

`python tests/support/effects.py > tests/support/effect_digests` writes the table of these runs: an effect's
name, the systems, particles of each and frames of a small run, and the digests of its last frame: particles,
then picture. With names of effects it writes only their rows.
"""

from __future__ import annotations

import contextlib
import io
import os
import runpy
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
TABLE = Path(__file__).with_name("effect_digests")
NO_EFFECTS = ("export", "heterogeneous")  # they show how to use particles, not effects


class Small(NamedTuple):
    """A small run of an effect, and the digests of its last frame."""

    systems: int
    particles: int
    frames: int
    digests: tuple[str, str]

    def options(self, out: str | Path) -> list[str]:
        """Return the script's arguments."""
        counts = ("--systems", self.systems, "--particles", self.particles, "--frames", self.frames)
        return [*map(str, counts), "--size", "160x90", "--digest", "--out", str(out)]


def names() -> list[str]:
    """Return the names of all effects."""
    return sorted(path.stem for path in _scripts() if path.stem not in NO_EFFECTS)


def script(name: str) -> Path:
    """Return the script of an effect."""
    return next(path for path in _scripts() if path.stem == name)


def _scripts() -> list[Path]:
    return [*EXAMPLES.glob("*.py"), *EXAMPLES.glob("light/*.py")]


def table() -> dict[str, Small]:
    """Return the small runs by the name of the effect."""
    rows = (line.split() for line in TABLE.read_text().splitlines())
    return {row[0]: Small(int(row[1]), int(row[2]), int(row[3]), (row[4], row[5])) for row in rows}


def lines(name: str, options: Sequence[str]) -> list[list[str]]:
    """Run an effect in this process; return the fields of each frame's line: frame, two digests."""
    said, argv = io.StringIO(), sys.argv
    sys.argv = [f"{name}.py", *options]
    try:
        with contextlib.redirect_stdout(said):
            runpy.run_path(str(script(name)), run_name="__main__")
    finally:
        sys.argv = argv
    return [line.split() for line in said.getvalue().splitlines() if line[0].isdigit()]


def main() -> None:
    """Run all effects, or those that are named, and print the table."""
    os.environ["MOTES_PROGRESS"] = "off"
    runs = table()
    with TemporaryDirectory() as out:
        for name in sys.argv[1:] or runs:
            small = runs[name]
            _, *digests = lines(name, small.options(out))[-1]
            print(name, small.systems, small.particles, small.frames, *digests)


if __name__ == "__main__":
    main()
