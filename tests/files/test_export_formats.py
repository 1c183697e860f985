"""Adding an export format takes one table row: writing, cleaning up and naming follow from it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motes
from motes import ArgumentError
from motes._interchange import formats
from motes._interchange.format import Format
from motes._interchange.manifest import Manifest


def _write(path: Path, columns: Mapping[str, Any], *, frame: int, time: float) -> None:
    path.write_text(json.dumps({name: column.tolist() for name, column in columns.items()}))


def _read(path: Path, names: Any, *, frame: int) -> dict[str, Any]:
    columns = json.loads(path.read_text())
    wanted = columns if names is None else names
    return {name: np.array(columns[name], np.uint64 if name == "id" else np.float32) for name in wanted}


def _show(manifest: Manifest, folder: str) -> bytes:
    return f"particles in {folder}, {len(manifest.frames)} frames".encode()


TOY = Format(
    *("toy", ".toys", _write, _read, _show, "particles in"),
    beside={".names.txt": lambda system: system.name.encode()},
    alone=True,
    mistaken=(".toy",),
)


def test_a_new_format_is_a_row(tmp_path, monkeypatch):
    monkeypatch.setitem(formats.FORMATS, "toy", TOY)
    target = tmp_path / "snow.toys"
    for _ in range(2):  # the second export replaces all files of the first
        world = motes.World(seed=1, progress="off")
        snow = world.system("snow")
        with world, motes.Export(target) as export:
            for _ in world.frames(2):
                snow.burst((0, 1, 2), count=3)
                world.step()
                export.write(world)
        assert target.read_text() == "particles in snow.toys.parts, 2 frames"
        folder = tmp_path / "snow.toys.parts"
        assert (folder / "snow.names.txt").read_text() == "snow"
        assert len(list(folder.glob("*.toy"))) == 2
    opened = motes.open_particles(target)
    assert [len(particles) for particles in opened.values()] == [3, 6]
    assert len(motes.open_particles(next(folder.glob("*.toy")))) == 1
    with pytest.raises(ArgumentError, match=r"did you mean \.toys\?"):
        motes.Export(tmp_path / "snow.toy")
