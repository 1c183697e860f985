"""A run killed with -9 at a random moment leaves files that can be read up to the last complete frame."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import random
import signal
import time

import numpy as np
import pytest
from launching import mpirun
from standing import on_ranks
from test_export import short_run

import motes
from motes._interchange import vtp

SCENE = """
import os, pathlib, sys
import motes
from motes.shapes import Box, Sphere

folder, name = pathlib.Path(sys.argv[1]), sys.argv[2]
last = int(sys.argv[3]) if len(sys.argv) > 3 else 20_000
world = motes.World(seed=3, space=(-1, 1), roles="shared", progress="off")
systems = [world.system("a"), world.system("b")]
(folder / f"pid{world.rank}").write_text(str(os.getpid()))
with world, motes.Export(folder / name) as export:
    for frame in world.frames(last):
        for s in systems:
            s.configure(velocity=Sphere((0, 0, 0), 3), lifetime=motes.Uniform(0.1, 0.4))
            s.source(Box((-1, -1, -1), (1, 1, 1)), rate=2400)
            s.kill_expired()
            s.move()
        world.step()
        export.write(world)
"""
NAMES = ["out", "out.pvd", *(["out.usd"] if importlib.util.find_spec("pxr") else [])]


class Killer:
    """Kills one rank, some time after the first file appears."""

    def __init__(self, folder, rank, delay_s):
        self.folder, self.rank, self.delay_s, self.at = folder, rank, delay_s, None

    def __call__(self, _):
        if self.at is None and any(path.name.startswith("a.0") for path in self.folder.glob("out*/*")):
            self.at = time.monotonic() + self.delay_s
        if self.at is not None and time.monotonic() >= self.at:
            with contextlib.suppress(ProcessLookupError, ValueError):
                os.kill(int((self.folder / f"pid{self.rank}").read_text()), signal.SIGKILL)


def check(folder, name, reference):
    """Compare the remaining frames with an undisturbed run on one rank; return their number."""
    systems = [motes.open_particles(folder / name, system=system) for system in ("a", "b")]
    frames = systems[0].frames
    assert frames == systems[1].frames == tuple(range(len(frames)))
    assert not systems[0].finished
    for system in systems:
        whole = motes.open_particles(reference, system=system.system)
        for frame in {0, len(frames) // 2, *frames[-3:]} & set(frames):
            read, wanted = system[frame].columns(), whole[frame].columns()
            assert sorted(read) == sorted(wanted)
            assert all(read[column].tobytes() == wanted[column].tobytes() for column in wanted), (name, frame)
    # All frames whose parts are all on disk can be read, except the last few, which may not be announced yet.
    parts = [
        path.name.split(".")[1] for path in systems[0].folder.glob("[ab].*.r*") if path.name[-3:] != "tmp"
    ]
    on_disk = sum(parts.count(frame) == 6 for frame in set(parts))
    assert len(frames) <= on_disk <= len(frames) + 3
    return len(frames)


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    """Run the scene undisturbed on one rank."""
    folder = tmp_path_factory.mktemp("whole")
    assert on_ranks(1, SCENE, folder, "reference", 600).code == 0
    return folder / "reference"


@pytest.mark.parametrize(
    "number", [*range(4), *(pytest.param(n, marks=pytest.mark.slow) for n in range(4, 60))]
)
def test_what_is_whole_is_read(tmp_path, number, reference, monkeypatch):
    name, rank = NAMES[number % len(NAMES)], number % 3
    delay_s = random.Random(number).uniform(0, 0.5)
    result = mpirun(3, SCENE, tmp_path, name, timeout=40, watch=Killer(tmp_path, rank, delay_s))
    assert result.code != 0, "the run was killed"
    count = check(tmp_path, name, reference)
    if name == "out.pvd":
        text = (tmp_path / name).read_text()
        assert text.startswith("<?xml") and text.endswith("</VTKFile>\n") and vtp.MARK in text
        assert all(
            (tmp_path / part).is_file() for part in text.split('file="')[1:] for part in [part.split('"')[0]]
        )
    if name == "out.usd":
        shown = stage_counts(tmp_path / name)
        opened = motes.open_particles(tmp_path / name, system="a")
        assert shown == [opened.count(frame) for frame in range(len(shown))]
        assert count - 30 <= len(shown) <= count  # it is written anew for an eighth of the time
    folder = motes.open_particles(tmp_path / name).folder
    (folder / ".a.000003.r0000.usdc.0123456789abcdef.pWtm9T").write_text("USD's own draft")
    if folder.name != name:  # as if the run had been killed while it wrote the index
        (tmp_path / f".{name}.0123456789abcdef.tmp").write_text("half an ind")
    with contextlib.suppress(FileNotFoundError):
        # Either file alone marks the folder as an export.
        (folder / "manifest.json" if number % 2 else folder / ".lock").unlink()
    monkeypatch.setenv("MOTES_FRESH", "1")
    short_run(motes.Export(tmp_path / name), frames=1)
    left = [path.name for path in folder.iterdir() if path.suffix not in (".json", ".usda")]
    assert not list(tmp_path.rglob("*.tmp"))
    assert len(left) == 1 and left[0].startswith("s.000000.r0000"), "what the killed run left is gone"


def stage_counts(path):
    """Return the number of points that USD shows of system a at each frame."""
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(path))
    prims = [prim for prim in stage.Traverse() if str(prim.GetPath()).startswith("/World/a/a")]
    if not prims:
        return []
    frames = range(int(stage.GetEndTimeCode()) + 1)
    counts = [[len(UsdGeom.Points(prim).GetPointsAttr().Get(frame)) for prim in prims] for frame in frames]
    return [int(total) for total in np.sum(counts, axis=1)]
