"""`python -m motes record`: what a script records, frame by frame, as a file that replays without Python.

A scene holds each frame's recorded list: systems, births, actions, spawn rules, sprites, the view. It holds
no particles, which follow from the lists and the seed. The script runs and its lists are kept, but nothing is
computed until the script reads: `System.local`, `gather`, sums, `World.digest`, `count`, `born`, `dropped`
and `cuts` compute everything up to that point, and from then on all frames are computed. (On several ranks,
all frames are computed, because a getter must not communicate.) No pictures are drawn: frames are falsy, as
on ranks other than the image generator, and movies are empty. `--full` computes and draws as usual.

Callbacks and writing particles in `System.local` are refused, because a scene cannot contain them.
"""

from __future__ import annotations

import sys
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

from .. import _core
from .._io import files
from ..errors import MotesError

__all__ = ["NO_PICTURE", "Recording", "claim", "record"]

NO_PICTURE = "a recording draws no pictures; `record --full` does"


@dataclass(eq=False, repr=False)
class Recording:
    """The scene that this process records, and its file."""

    path: Path
    full: bool = False
    """Whether particles are computed and pictures drawn as in an ordinary run."""
    claimed: bool = False
    """Whether a world is being recorded, or has been."""
    content: bytes | None = None
    """The content of the file, once the world has ended."""
    facts: dict[str, int] = field(default_factory=dict)
    """The numbers to print about the scene."""
    here: bool = False
    """Whether this rank writes the file and reports."""

    def refuse(self, frame: int, what: str) -> NoReturn:
        """Raise MotesError: a scene cannot hold what the script did."""
        raise MotesError(
            f"record: frame {frame}: {what}, which only Python can repeat; a recorded scene cannot contain it"
        )

    def keep(self, engine: _core.Engine, facts: Mapping[str, Any], here: bool) -> None:
        """Store what the world has recorded; `here`: whether this rank writes the file."""
        self.content, self.here = engine.scene_bytes(_texts(facts)), here
        self.facts = {
            "frames": engine.recorded_frames,
            "systems": len(facts["systems"]),
            "bytes": len(self.content),
        }

    def write(self) -> None:
        """Write the file, whole or not at all."""
        if self.content is None:
            raise MotesError("record: the script ran no world to its end, so nothing was written")
        if self.here:
            files.write_whole(self.path, self.content)


active: Recording | None = None


def claim(engine: _core.Engine) -> Recording | None:
    """Let the active recording, if any, keep this engine's lists."""
    if active is None:
        return None
    if active.claimed:
        raise MotesError("record: the script creates a second world; a scene holds only one")
    active.claimed = True
    engine.keep_lists(active.full)
    return active


def record(program: Sequence[str], path: Path, *, full: bool = False) -> Recording | None:
    """Run `program`, a script and its arguments, in this process and write its scene to `path`.

    Returns None if the script failed with an error of motes, after printing it on standard error. Raises
    SystemExit if the script exited with a code other than 0, MotesError if it ran no world.
    """
    import runpy  # few programs start here

    global active
    active = Recording(path.absolute(), full)
    sys.argv = list(program)
    sys.path[0] = str(Path(program[0]).resolve().parent)
    try:
        runpy.run_path(program[0], run_name="__main__")
    except SystemExit as end:
        if end.code not in (None, 0):
            raise
    except MotesError:
        traceback.print_exc()  # shows the script's own line
        return None
    active.write()
    return active


def _texts(facts: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the facts that the lists do not contain; none of them changes a particle."""
    chosen = {name: facts[name] for name in ("axis", "space", "balancer", "combine")}
    return [("recorded_from", " ".join(sys.argv)), *((name, str(value)) for name, value in chosen.items())]
